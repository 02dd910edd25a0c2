/* Answers of controllers: what sim refuses, by name. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <string.h>

#include "sim/run/command_check.h"
#include "wall_fixture.h"
#include "wallctl/control_law.h"

static void refused(const struct scene *scene, const struct wall_state *state, const struct wall_command *command,
                    const char *part)
{
    assert_int_equal(command_check(scene, state, command), STATUS_FORMAT);
    if (!strstr(status_message(), part))
        fail_msg("\"%s\" does not say \"%s\"", status_message(), part);
}

static void unfit_answers_are_refused_by_name(void **unused)
{
    struct scene *scene = fixture_scene(2); /* 1000 steps */
    struct wall_state state = fixture_state(4, 1);
    struct wall_command good, bad;
    (void)unused;
    state.stage = 0;
    state.stage_step = 400;
    assert_int_equal(wallctl_law(scene, &state, &good), STATUS_OK);
    assert_int_equal(command_check(scene, &state, &good), STATUS_OK);
    bad = good, bad.velocity_m_per_s[2] = NAN;
    refused(scene, &state, &bad, "velocity_m_per_s[2] is not finite");
    bad = good, bad.damping_kg_per_s[0] = INFINITY;
    refused(scene, &state, &bad, "damping_kg_per_s[0] is not finite");
    bad = good, bad.position_m[3] += 2e-6;
    refused(scene, &state, &bad, "position_m[3] is 1.000002, the wall is at 1; allowed: within 1e-06");
    bad = good, bad.position_m[3] += 0.5e-6;
    assert_int_equal(command_check(scene, &state, &bad), STATUS_OK);
    bad = good, bad.n_steps = 602;
    refused(scene, &state, &bad, "n_steps is 602; allowed: 1 to 601, what is left of stage \"a\"");
    bad = good, bad.n_steps = 0;
    refused(scene, &state, &bad, "n_steps is 0");
    bad = good, bad.stage = 1;
    refused(scene, &state, &bad, "stage is 1; allowed: 0 to 0");
    bad = good, bad.n_walls = 6;
    refused(scene, &state, &bad, "n_walls is 6; allowed: 4");
    bad = good, bad.drive[1] = 4;
    refused(scene, &state, &bad, "drive[1] is 4");
    bad = good, bad.drive[1] = DRIVE_IMPEDANCE;
    refused(scene, &state, &bad, "wall 1 has an impedance without mass_kg");
    fixture_scene_free(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(unfit_answers_are_refused_by_name)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
