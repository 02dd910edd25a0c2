/* What the commands of the schemes say: the loop that sim closes itself, the mass that a scheme adds, what ends a
 * stage. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <float.h>
#include <math.h>

#include "common/pressure_target.h"
#include "wall_fixture.h"
#include "wallctl/control_law.h"
#include "wallctl/stress_control.h"

enum { Z_HI = 3 };

static void assert_near(double value, double expected, double tolerance)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%.17g is not within %g of %.17g", value, tolerance, expected);
}

/* impedance: mass and damping as in the scene, and a driving force through the target's values at the start, in the
 * middle and at the end of the interval, times the area, which stays 1 m2 as the other walls rest. */
static void the_loop_is_the_scenes(void **unused)
{
    struct scene *scene = fixture_scene(2);
    struct wall_state state = fixture_state(4, 1);
    struct wall_command command;
    const double h = 0.04, t0 = 0.02;
    (void)unused;
    scene->coupling.scheme = SCHEME_IMPEDANCE;
    scene->coupling.interval_steps = 40;
    scene->stage[0].axis[AXIS_Z] = (struct scene_axis){.mode = WALL_STRESS,
                                                       .opposite = OPPOSITE_FIXED,
                                                       .target = TARGET_COSINE,
                                                       .pressure_pa = 10,
                                                       .amplitude_pa = 4,
                                                       .period_s = 0.25,
                                                       .mass_kg = 1.5,
                                                       .damping_kg_per_s = 0.75};
    state.stage = 0;
    state.stage_step = 20;
    state.stage_time_s = t0;
    state.interval_s = h;
    assert_int_equal(wallctl_law(scene, &state, &command), STATUS_OK);
    assert_int_equal(command.n_steps, 40);
    assert_int_equal(command.drive[Z_HI], DRIVE_IMPEDANCE);
    assert_true(command.mass_kg[Z_HI] == 1.5 && command.damping_kg_per_s[Z_HI] == 0.75);
    /* Sums of three terms of at most 60 N (the rate times h is four times a difference): below 8 roundings of that. */
    const double tolerance = 8 * 60 * DBL_EPSILON;
    for (int k = 0; k <= 2; k++) {
        const double t_s = 0.5 * k * h;
        assert_near(command.force_n[Z_HI] +
                        t_s * (command.force_rate_n_per_s[Z_HI] + 0.5 * t_s * command.force_rate2_n_per_s2[Z_HI]),
                    pressure_target_pa(&scene->stage[0].axis[AXIS_Z], t0 + t_s), tolerance);
    }
    fixture_scene_free(scene);
}

/* v+ = v + (F - p A) T/(m + m'), without damping, where m' = K T2/4 + C T/2 (docs/coupling.md); eight times the first
 * term for an answer that comes an interval late; none where the force is held. */
static void a_scheme_adds_its_mass(void **unused)
{
    static const struct {
        int scheme;
        double added_kg;
    } cases[] = {{SCHEME_HOLD, 0},
                 {SCHEME_JACOBIAN, 0.25 * 100 * 0.04 + 0.5 * 3 * 0.2}, /* K = 100, T = 0.2, C = 3 */
                 {SCHEME_PIPELINED, 8 * 0.25 * 100 * 0.04 + 0.5 * 3 * 0.2}};
    (void)unused;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const struct stress_loop loop = {.mass_kg = 2,
                                         .stiffness_n_per_m = 100,
                                         .contact_damping_kg_per_s = 3,
                                         .last_interval_s = 0.1,
                                         .interval_s = 0.3,
                                         .velocity_m_per_s = 0.7,
                                         .force_n = 25,
                                         .target_n = 10};
        const double velocity = stress_motion(cases[k].scheme, &loop).motion.velocity_m_per_s;
        assert_near(velocity, 0.7 + 15 * 0.2 / (2 + cases[k].added_kg), 8 * DBL_EPSILON); /* numbers up to 2.2 */
    }
}

/* Cycles that end with the time given for them have come to their end. */
static void cycles_may_take_all_the_time(void **unused)
{
    struct scene *scene = fixture_scene(2);
    struct wall_state state = fixture_state(4, 1);
    struct scene_stage *stage = &scene->stage[0];
    struct wall_command command;
    (void)unused;
    stage->dt_s = 3e-3, stage->duration_s = 0.3, stage->until_cycles = 3; /* of 0.1 s */
    stage->axis[AXIS_Z] = (struct scene_axis){.mode = WALL_STRAIN, .course = COURSE_COSINE, .frequency_hz = 10};
    state.stage = 0, state.stage_step = 100;
    assert_int_equal(wallctl_law(scene, &state, &command), STATUS_OK);
    assert_true(command.finished && command.ended == STAGE_END_CYCLES);
    fixture_scene_free(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_loop_is_the_scenes),
        cmocka_unit_test(a_scheme_adds_its_mass),
        cmocka_unit_test(cycles_may_take_all_the_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
