/* The control law against closed forms, and the protocol of stages. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/pressure_target.h"
#include "common/strain_path.h"
#include "wall_fixture.h"
#include "wallctl/control_law.h"

/* Walls of the 2D box. */
enum { X_LO, X_HI, Z_LO, Z_HI };

static const double PI = 3.14159265358979323846;

static void assert_near(double value, double expected, double tolerance)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%.17g is not within %g of %.17g", value, tolerance, expected);
}

static struct wall_command answer(const struct scene *scene, const struct wall_state *state)
{
    struct wall_command command;
    if (wallctl_law(scene, state, &command) != STATUS_OK)
        fail_msg("%s", status_message());
    return command;
}

/* ---- strain control ---- */

static const struct scene_axis paper_axis = {
    .mode = WALL_STRAIN, .opposite = OPPOSITE_FIXED, .strain = 0.035, .frequency_hz = 10};
static const double paper_z0_m = 0.12;

static void strain_path_has_its_closed_form(void **unused)
{
    (void)unused;
    double zf_m = paper_z0_m * (1 - paper_axis.strain);
    /* A handful of roundings of numbers of size z0: below 4 eps z0. */
    double tolerance = 4 * DBL_EPSILON * paper_z0_m;
    assert_near(strain_path_length_m(&paper_axis, paper_z0_m, 0), paper_z0_m, tolerance);
    assert_near(strain_path_length_m(&paper_axis, paper_z0_m, 0.025), 0.5 * (paper_z0_m + zf_m), tolerance);
    assert_true(strain_path_length_m(&paper_axis, paper_z0_m, 0.05) == zf_m);
    assert_true(strain_path_length_m(&paper_axis, paper_z0_m, 7) == zf_m);
    assert_true(strain_path_rate_m_per_s(&paper_axis, paper_z0_m, 0.0500001) == 0);
}

static void strain_rate_is_the_derivative(void **unused)
{
    (void)unused;
    double omega = 2 * PI * 10, amplitude_m = 0.5 * paper_z0_m * paper_axis.strain, h = 1e-5;
    /* Central difference: |z'''| h^2/6, and rounding of two lengths over 2h. */
    double tolerance = amplitude_m * omega * omega * omega * h * h / 6 + 4 * DBL_EPSILON * paper_z0_m / h;
    for (double t_s = 0.001; t_s < 0.0499; t_s += 0.004) {
        double slope = (strain_path_length_m(&paper_axis, paper_z0_m, t_s + h) -
                        strain_path_length_m(&paper_axis, paper_z0_m, t_s - h)) /
                       (2 * h);
        assert_near(strain_path_rate_m_per_s(&paper_axis, paper_z0_m, t_s), slope, tolerance);
    }
}

/* Every interval must end on the path, the motion must begin with the path's rate, and rest once it is there. */
static void strain_run(int opposite, int interval_steps)
{
    struct scene *scene = fixture_scene(2);
    struct wall_state state = fixture_state(4, paper_z0_m);
    scene->coupling.interval_steps = interval_steps;
    scene->stage[0].dt_s = 1e-4;
    scene->stage[0].duration_s = 0.06; /* the path takes 0.05 s */
    scene->stage[0].axis[AXIS_Z] = paper_axis;
    scene->stage[0].axis[AXIS_Z].opposite = opposite;
    double share = opposite == OPPOSITE_MIRROR ? 0.5 : 1;
    /* x0 + v H + a H^2/2 with a = 2 (way - v H)/H^2: a few roundings of numbers no larger than z0. */
    double tolerance = 4 * DBL_EPSILON * paper_z0_m;
    for (int k = 0; k < 600; k++) {
        struct wall_command command = answer(scene, &state);
        if (command.finished)
            break;
        double rate = strain_path_rate_m_per_s(&paper_axis, paper_z0_m, (double)state.stage_step * 1e-4);
        assert_near(command.velocity_m_per_s[Z_HI], share * rate, 0);
        fixture_advance(scene, &command, &state);
        double z_m = strain_path_length_m(&paper_axis, paper_z0_m, (double)state.stage_step * 1e-4);
        assert_near(state.position_m[Z_HI] - state.position_m[Z_LO], z_m, 2 * tolerance);
        assert_near(state.position_m[Z_HI], paper_z0_m + share * (z_m - paper_z0_m), tolerance);
        assert_true(state.position_m[X_HI] == paper_z0_m && state.position_m[X_LO] == 0);
    }
    assert_int_equal(state.stage_step, 600);
    assert_near(state.position_m[Z_HI] - state.position_m[Z_LO], paper_z0_m * (1 - 0.035), 2 * tolerance);
    if (interval_steps <= 100) /* the last interval began after the path's end */
        assert_true(state.velocity_m_per_s[Z_HI] == 0);
    if (opposite == OPPOSITE_FIXED)
        assert_true(state.position_m[Z_LO] == 0);
    fixture_scene_free(scene);
}

static void strain_control_stays_on_the_path(void **unused)
{
    (void)unused;
    strain_run(OPPOSITE_FIXED, 1);
    strain_run(OPPOSITE_FIXED, 7);
    strain_run(OPPOSITE_MIRROR, 1);
    strain_run(OPPOSITE_MIRROR, 600);
}

/* ---- stress control ---- */

enum { OSCILLATOR_K = 100 }; /* N/m; mass 1 kg, damping 1 kg/s: omega_0 = 10 1/s, damping ratio 0.05 */

static struct scene *oscillator_scene(double dt_s, int interval_steps)
{
    struct scene *scene = fixture_scene(2);
    scene->coupling.interval_steps = interval_steps;
    scene->stage[0].dt_s = dt_s;
    scene->stage[0].duration_s = 1;
    scene->stage[0].axis[AXIS_Z] = (struct scene_axis){
        .mode = WALL_STRESS, .opposite = OPPOSITE_FIXED, .pressure_pa = 10, .mass_kg = 1, .damping_kg_per_s = 1};
    return scene;
}

/* y'' + y'/m + k y/m = 0, y(0) = p A/k, y'(0) = 0, y = z - (L - p A/k); A = 1 m^2. */
static void oscillator_exact(double t_s, double *position_m, double *velocity_m_per_s)
{
    double beta = 0.5, k = OSCILLATOR_K, omega = sqrt(k - beta * beta), y0 = 10 / k;
    double decay = exp(-beta * t_s);
    *position_m = 1 - y0 + y0 * decay * (cos(omega * t_s) + beta / omega * sin(omega * t_s));
    *velocity_m_per_s = -y0 * decay * (k / omega) * sin(omega * t_s);
}

/* Errors of position and of the velocity at the end of the last interval, after 1 s. */
static void oscillator_errors(double dt_s, int interval_steps, double *position_error, double *velocity_error)
{
    struct scene *scene = oscillator_scene(dt_s, interval_steps);
    struct wall_state state = fixture_state(4, 1);
    double end_velocity = 0, position_m, velocity_m_per_s;
    for (struct wall_command command = answer(scene, &state); !command.finished; command = answer(scene, &state)) {
        fixture_advance(scene, &command, &state);
        fixture_springs(&state, OSCILLATOR_K, 1);
        end_velocity = command.velocity_m_per_s[Z_HI] + command.acceleration_m_per_s2[Z_HI] * command.n_steps * dt_s;
    }
    oscillator_exact(1, &position_m, &velocity_m_per_s);
    *position_error = fabs(state.position_m[Z_HI] - position_m);
    *velocity_error = fabs(end_velocity - velocity_m_per_s);
    fixture_scene_free(scene);
}

/* Second order: halving H divides the error by 4 (1 + O(omega H)). At the coarsest pair omega H = 0.05, so the order is
 * 2 within log2(1 + 0.05) = 0.07. The finest error is still 1e-6 of the motion, far above rounding. */
static void stress_control_is_of_second_order(void **unused)
{
    double position_before = 0, velocity_before = 0;
    (void)unused;
    for (int n = 200; n <= 1600; n *= 2) {
        double position_error, velocity_error;
        oscillator_errors(1.0 / n, 1, &position_error, &velocity_error);
        if (n > 200) {
            print_message("H = 1/%d s: orders %.3f (position) %.3f (velocity)\n", n,
                          log2(position_before / position_error), log2(velocity_before / velocity_error));
            assert_near(log2(position_before / position_error), 2, 0.07);
            assert_near(log2(velocity_before / velocity_error), 2, 0.07);
        }
        position_before = position_error;
        velocity_before = velocity_error;
    }
}

/* The same path whether H is one step or eight: position depends on H alone, but for rounding of some 200 intervals. */
static void held_intervals_follow_the_same_positions(void **unused)
{
    double one, eight, velocity_error;
    (void)unused;
    oscillator_errors(1.0 / 200, 1, &one, &velocity_error);
    oscillator_errors(1.0 / 1600, 8, &eight, &velocity_error);
    assert_near(eight, one, 200 * 4 * DBL_EPSILON);
}

/* v+ of the upper z wall for one interval of 2 steps (held: it is the commanded velocity), T = H. */
static double next_velocity(double mass_kg, double damping_kg_per_s, double last_velocity_m_per_s, double force_n)
{
    struct scene *scene = oscillator_scene(1e-3, 2);
    struct wall_state state = fixture_state(4, 1);
    scene->stage[0].axis[AXIS_Z].mass_kg = mass_kg;
    scene->stage[0].axis[AXIS_Z].damping_kg_per_s = damping_kg_per_s;
    state.stage = 0;
    state.stage_step = 2;
    state.interval_s = 2e-3;
    state.velocity_m_per_s[Z_HI] = last_velocity_m_per_s;
    state.force_n[Z_HI] = force_n;
    struct wall_command command = answer(scene, &state);
    assert_true(command.acceleration_m_per_s2[Z_HI] == 0);
    fixture_scene_free(scene);
    return command.velocity_m_per_s[Z_HI];
}

static void stress_control_has_its_limits(void **unused)
{
    (void)unused;
    double h = 2e-3, net_n = 25 - 10; /* p A = 10 N */
    double eps = 4 * DBL_EPSILON;     /* relative; up to four roundings */
    assert_near(next_velocity(0, 3, 0.7, 25), net_n / 3, eps * 5);
    assert_near(next_velocity(1e-300, 3, 0.7, 25), net_n / 3, eps * 5);
    assert_near(next_velocity(2, 0, 0.7, 25), 0.7 + net_n * h / 2, eps);
    /* First order in x = gamma T/m = 1e-12: both terms are off by x relative. */
    assert_near(next_velocity(2, 1e-9, 0.7, 25), 0.7 + net_n * h / 2, 1.01e-12 * 0.72);
    assert_near(next_velocity(2, 1e-320, 0.7, 25), 0.7 + net_n * h / 2, eps);
    /* Free flight: damping alone, exactly. */
    assert_near(next_velocity(2, 500, 0.7, 10), 0.7 * exp(-500 * h / 2), eps);
    /* Very heavy: it does not move. */
    assert_near(next_velocity(1e300, 3, 0.7, 25), 0.7, eps);
}

static struct scene_axis stress_axis(int opposite)
{
    return (struct scene_axis){.mode = WALL_STRESS,
                               .opposite = opposite,
                               .target = TARGET_COSINE,
                               .pressure_pa = 10,
                               .amplitude_pa = 4,
                               .period_s = 0.25,
                               .mass_kg = 1,
                               .damping_kg_per_s = 1};
}

/* Unequal springs would push a free pair aside; the mirrored one must keep its centre and react to the mean force. */
static void mirror_keeps_the_centre(void **unused)
{
    struct scene *scene = fixture_scene(2);
    struct wall_state state = fixture_state(4, 1);
    (void)unused;
    scene->stage[0].axis[AXIS_Z] = stress_axis(OPPOSITE_MIRROR);
    int intervals = 0;
    for (struct wall_command c = answer(scene, &state); !c.finished; c = answer(scene, &state)) {
        assert_true(c.velocity_m_per_s[Z_LO] == -c.velocity_m_per_s[Z_HI]);
        assert_true(c.acceleration_m_per_s2[Z_LO] == -c.acceleration_m_per_s2[Z_HI]);
        fixture_advance(scene, &c, &state);
        fixture_springs(&state, OSCILLATOR_K, 1);
        state.force_n[Z_LO] *= 3;
        intervals++;
    }
    assert_int_equal(intervals, 1000);
    assert_true(state.position_m[Z_LO] > 0.01); /* it moved */
    /* Two roundings of at most one ulp of 1 each interval, all the same way at worst. */
    assert_near(state.position_m[Z_LO] + state.position_m[Z_HI], 1, intervals * 2 * DBL_EPSILON);
    fixture_scene_free(scene);
}

static void mirror_follows_the_mean_force(void **unused)
{
    struct scene *scene = fixture_scene(2);
    struct wall_state state = fixture_state(4, 1);
    (void)unused;
    scene->stage[0].axis[AXIS_Z] = stress_axis(OPPOSITE_MIRROR);
    state.force_n[Z_LO] = 30;
    state.force_n[Z_HI] = 10;
    struct wall_command mirrored = answer(scene, &state);
    scene->stage[0].axis[AXIS_Z].opposite = OPPOSITE_FIXED;
    state.force_n[Z_HI] = 20;
    struct wall_command single = answer(scene, &state);
    assert_true(mirrored.velocity_m_per_s[Z_HI] == single.velocity_m_per_s[Z_HI]);
    assert_true(mirrored.acceleration_m_per_s2[Z_HI] == single.acceleration_m_per_s2[Z_HI]);
    assert_true(single.velocity_m_per_s[Z_LO] == 0 && single.acceleration_m_per_s2[Z_LO] == 0);
    fixture_scene_free(scene);
}

/* The lower wall of "constant" sees pressure_pa whatever the cycle, and outward is downward for it. */
static void constant_opposite_is_a_wall_of_its_own(void **unused)
{
    struct scene *scene = fixture_scene(2);
    struct wall_state state = fixture_state(4, 1);
    (void)unused;
    scene->coupling.interval_steps = 2;
    scene->stage[0].axis[AXIS_Z] = stress_axis(OPPOSITE_CONSTANT);
    state.stage = 0;
    state.stage_step = 125; /* half the period: the target is 14 Pa */
    state.interval_s = 2e-3;
    state.force_n[Z_LO] = 10;
    state.force_n[Z_HI] = 14;
    struct wall_command command = answer(scene, &state);
    /* 1 - cos(pi): a rounding of 14 Pa on 1 m^2, over T/m. */
    assert_near(command.velocity_m_per_s[Z_HI], 0, 2e-3 * 14 * 4 * DBL_EPSILON);
    assert_true(command.velocity_m_per_s[Z_LO] == 0);
    state.force_n[Z_LO] = 11;
    command = answer(scene, &state);
    assert_true(command.velocity_m_per_s[Z_LO] < 0);
    /* 1 N for 2 ms on 1 kg, damped by at most gamma T/m = 0.2 %. */
    assert_near(command.velocity_m_per_s[Z_LO], -2e-3, 0.002 * 2e-3);
    fixture_scene_free(scene);
}

static void area_is_the_product_of_the_other_lengths(void **unused)
{
    struct scene *scene = fixture_scene(3);
    struct wall_state state = fixture_state(6, 1);
    (void)unused;
    scene->stage[0].axis[AXIS_Y] = stress_axis(OPPOSITE_FIXED);
    scene->stage[0].axis[AXIS_Y].amplitude_pa = 0;
    state.position_m[1] = 2; /* x */
    state.position_m[5] = 7; /* z */
    state.force_n[3] = 10 * 2 * 7;
    struct wall_command command = answer(scene, &state);
    for (int wall = 0; wall < 6; wall++)
        assert_true(command.velocity_m_per_s[wall] == 0 && command.acceleration_m_per_s2[wall] == 0);
    state.force_n[3] = 10 * 2 * 7 + 1;
    command = answer(scene, &state);
    assert_true(command.acceleration_m_per_s2[3] > 0);
    fixture_scene_free(scene);
}

static void targets_have_their_closed_forms(void **unused)
{
    (void)unused;
    struct scene_axis ramp = {.target = TARGET_RAMP, .pressure_pa = 100, .pressure_end_pa = 500, .ramp_s = 2};
    struct scene_axis cosine = {.target = TARGET_COSINE, .pressure_pa = 1000, .amplitude_pa = 200, .period_s = 10};
    struct scene_axis constant = {.target = TARGET_CONSTANT, .pressure_pa = 7};
    assert_true(pressure_target_pa(&constant, 3) == 7);
    assert_true(pressure_target_pa(&ramp, 0) == 100);
    assert_true(pressure_target_pa(&ramp, 0.5) == 200);
    assert_true(pressure_target_pa(&ramp, 2) == 500);
    assert_true(pressure_target_pa(&ramp, 99) == 500);
    assert_true(pressure_target_pa(&cosine, 0) == 1000);
    /* cos of a rounded argument of size 2 pi: 8 eps, times 100 Pa; and a rounding of 1200 Pa. */
    double tolerance = (8 * 100 + 1200) * DBL_EPSILON;
    assert_near(pressure_target_pa(&cosine, 2.5), 1100, tolerance);
    assert_near(pressure_target_pa(&cosine, 5), 1200, tolerance);
    assert_near(pressure_target_pa(&cosine, 10), 1000, tolerance);
}

/* ---- protocol ---- */

/* 0.3/0.1 and 0.07/0.01 are not whole in binary; the steps must be, whatever the interval. */
static void stages_have_whole_steps(void **unused)
{
    static const int64_t intervals[] = {1, 2, 5, 1000};
    struct scene *scene = fixture_scene(2);
    (void)unused;
    scene->n_stages = 3;
    scene->stage[1] = scene->stage[2] = scene->stage[0];
    scene->stage[0].dt_s = 0.1, scene->stage[0].duration_s = 0.3;
    scene->stage[1].dt_s = 0.01, scene->stage[1].duration_s = 0.07;
    scene->stage[2].dt_s = 0.5, scene->stage[2].duration_s = 0.5;
    for (int k = 0; k < 4; k++) {
        struct wall_state state = fixture_state(4, 1);
        int64_t steps[3] = {0};
        double fraction = 0;
        scene->coupling.interval_steps = intervals[k];
        struct wall_command c = answer(scene, &state);
        assert_int_equal(c.stage, 0);
        for (int guard = 0; !c.finished && guard < 100; guard++, c = answer(scene, &state)) {
            assert_true(c.n_steps >= 1 && c.n_steps <= intervals[k] && c.step == state.step);
            assert_true(c.fraction_done >= fraction && c.fraction_done < 1);
            fraction = c.fraction_done;
            steps[c.stage] += c.n_steps;
            fixture_advance(scene, &c, &state);
        }
        assert_true(c.finished && c.n_steps == 0 && c.fraction_done == 1 && c.stage == 2);
        assert_true(steps[0] == 3 && steps[1] == 7 && steps[2] == 1);
    }
    fixture_scene_free(scene);
}

/* Eight cycles of 0.2 s are 53333.3 steps of 3e-5 s, and 22857.1 of 7e-5 s: the last one ends in the step after. */
static void cycles_are_whole(void **unused)
{
    static const struct {
        double dt_s, duration_s;
        int64_t steps;
    } cases[] = {{2e-5, 1.6, 80000}, {3e-5, 1.6, 53334}, {7e-5, 1.6, 22858}, {3e-5, 1.59999, 53333}, {0.1, 0.6, 6}};
    struct scene *scene = fixture_scene(2);
    (void)unused;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        struct wall_state state = fixture_state(4, 1);
        scene->coupling.interval_steps = 1000000;
        scene->stage[0].dt_s = cases[k].dt_s;
        scene->stage[0].duration_s = cases[k].duration_s;
        scene->stage[0].axis[AXIS_Z] = stress_axis(OPPOSITE_FIXED);
        scene->stage[0].axis[AXIS_Z].period_s = 0.2;
        struct wall_command command = answer(scene, &state);
        assert_int_equal(command.n_steps, cases[k].steps);
    }
    fixture_scene_free(scene);
}

/* A new stage starts its path where the walls are, at time 0, with the velocity they have. */
static void a_new_stage_starts_where_the_walls_are(void **unused)
{
    struct scene *scene = fixture_scene(2);
    struct wall_state state = fixture_state(4, 1);
    (void)unused;
    scene->n_stages = 2;
    scene->stage[1] = scene->stage[0];
    scene->stage[1].axis[AXIS_Z] = paper_axis;
    scene->stage[1].axis[AXIS_X] = (struct scene_axis){.mode = WALL_STRESS, .opposite = OPPOSITE_FIXED, .mass_kg = 1};
    state.stage = 0;
    state.stage_step = 1000;
    state.interval_s = 1e-3;
    state.position_m[Z_HI] = 0.5; /* the stage before moved it */
    state.velocity_m_per_s[X_HI] = -0.25;
    struct wall_command command = answer(scene, &state);
    assert_int_equal(command.stage, 1);
    assert_true(command.velocity_m_per_s[Z_HI] == 0); /* the path starts at rest ... */
    double end_m = strain_path_length_m(&paper_axis, 0.5, 1e-3);
    double way_m = 0.5 * command.acceleration_m_per_s2[Z_HI] * 1e-6;
    assert_near(0.5 + way_m, end_m, 2 * DBL_EPSILON); /* ... from the present length */
    assert_true(command.velocity_m_per_s[X_HI] == -0.25 && command.acceleration_m_per_s2[X_HI] == 0);
    fixture_scene_free(scene);
}

/* A state in the middle of stage 0 of 2 whose energy condition holds; tests take one thing away. */
static struct scene *condition_scene(struct wall_state *state)
{
    struct scene *scene = fixture_scene(2);
    scene->n_stages = 2;
    scene->stage[1] = scene->stage[0];
    scene->stage[0].until_energy_ratio = 1e-3;
    scene->stage[0].min_duration_s = 0.1;
    scene->stage[0].condition_steps = 1;
    *state = fixture_state(4, 1);
    state->stage = 0;
    state->step = state->command_step = 5100;
    state->stage_step = 100;
    state->energy_step = 5090;
    state->kinetic_energy_j = 0.9e-3;
    state->elastic_energy_j = 1;
    return scene;
}

static void energy_condition_ends_a_stage(void **unused)
{
    struct wall_state state, good;
    struct scene *scene = condition_scene(&good);
    (void)unused;
    assert_int_equal(answer(scene, &good).stage, 1);
    assert_true(answer(scene, &good).fraction_done == 0.5); /* the stage counts in full */
    state = good;
    state.kinetic_energy_j = 1.1e-3;
    assert_int_equal(answer(scene, &state).stage, 0);
    state = good;
    state.stage_step = 99; /* min_duration_s */
    assert_int_equal(answer(scene, &state).stage, 0);
    state = good;
    state.energy_step = 5000; /* of the stage before */
    assert_int_equal(answer(scene, &state).stage, 0);
    state = good;
    state.kinetic_energy_j = state.elastic_energy_j = 0; /* nothing touches: not at rest under load */
    assert_int_equal(answer(scene, &state).stage, 0);
    state = good;
    state.kinetic_energy_j = -1;
    state.elastic_energy_j = -1;
    assert_int_equal(answer(scene, &state).stage, 0);
    state.stage_step = 1000; /* the limit in time holds whatever the energies */
    assert_int_equal(answer(scene, &state).stage, 1);
    fixture_scene_free(scene);
}

static void stress_condition_looks_at_every_controlled_wall(void **unused)
{
    struct wall_state state;
    struct scene *scene = condition_scene(&state);
    struct scene_stage *stage = &scene->stage[0];
    (void)unused;
    stage->until_stress_error = 0.01;
    assert_int_equal(answer(scene, &state).stage, 0); /* no stress-controlled wall: never */
    stage->axis[AXIS_Z] = stress_axis(OPPOSITE_CONSTANT);
    stage->axis[AXIS_Z].amplitude_pa = 0;
    state.force_n[Z_HI] = 10.09;
    state.force_n[Z_LO] = 9.91;
    assert_int_equal(answer(scene, &state).stage, 1);
    state.force_n[Z_LO] = 9.89;
    assert_int_equal(answer(scene, &state).stage, 0);
    stage->axis[AXIS_Z].opposite = OPPOSITE_MIRROR; /* the mean is what is controlled */
    assert_int_equal(answer(scene, &state).stage, 1);
    stage->axis[AXIS_Z].opposite = OPPOSITE_FIXED; /* the lower wall is not controlled */
    state.force_n[Z_LO] = 0;
    assert_int_equal(answer(scene, &state).stage, 1);
    state.force_n[Z_HI] = 10.11;
    assert_int_equal(answer(scene, &state).stage, 0);
    state.force_n[Z_HI] = 10;
    stage->axis[AXIS_Z].pressure_pa = 0; /* a fraction of nothing */
    state.force_n[Z_HI] = 0.05;
    assert_int_equal(answer(scene, &state).stage, 0);
    stage->stress_tolerance_pa = 0.1;
    assert_int_equal(answer(scene, &state).stage, 1);
    state.kinetic_energy_j = 1; /* all given conditions must hold */
    assert_int_equal(answer(scene, &state).stage, 0);
    fixture_scene_free(scene);
}

/* ---- courses, cycles, tables ---- */

static void cycles_and_tables_have_their_closed_forms(void **unused)
{
    (void)unused;
    const double eps =
        16 * DBL_EPSILON; /* a few roundings of numbers of size 1, and of sin of an argument of size 13 */
    struct scene_axis a = {.target = TARGET_TRIANGLE, .pressure_pa = 10, .amplitude_pa = 4, .period_s = 2};
    assert_near(pressure_target_pa(&a, 0.5), 12, 14 * eps);
    assert_near(pressure_target_pa(&a, 1), 14, 14 * eps);
    assert_near(pressure_target_pa(&a, 3.5), 12, 14 * eps);
    a.two_way = true;
    assert_near(pressure_target_pa(&a, 0.25), 11, 14 * eps);
    assert_near(pressure_target_pa(&a, 1.5), 8, 14 * eps);
    a.target = TARGET_COSINE;
    assert_near(pressure_target_pa(&a, 0.5), 12, 14 * eps);
    assert_near(pressure_target_pa(&a, 1), 10, 14 * eps);
    a.amplitude_growth_pa = 2;
    a.growth_cycles = 2; /* amplitudes 4, 4, 6, 6, 8 ... */
    assert_near(pressure_target_pa(&a, 3.5), 8, 14 * eps);
    assert_near(pressure_target_pa(&a, 4.5), 13, 14 * eps);
    struct scene_axis table = {.target = TARGET_TABLE,
                               .times_s = {3, {0, 1, 3}},
                               .pressures_pa = {3, {5, 7, -1}},
                               .strains = {3, {0, 0.1, 0.05}}};
    assert_near(pressure_target_pa(&table, 0.5), 6, 7 * eps);
    assert_near(pressure_target_pa(&table, 2), 3, 7 * eps);
    assert_true(pressure_target_pa(&table, 4) == -1);
    table.course = COURSE_TABLE;
    assert_near(strain_path_length_m(&table, 2, 0.5), 1.9, 2 * eps);
    assert_near(strain_path_rate_m_per_s(&table, 2, 2), 0.05, 2 * eps);
    assert_true(strain_path_done(&table, 3) && strain_path_rate_m_per_s(&table, 2, 3) == 0);
}

/* At 0.2 1/s after a rise of 0.1 s: a strain of 0.01 there, 0.05 at 0.3 s. */
static void a_rate_rises_and_ends(void **unused)
{
    (void)unused;
    struct scene_axis a = {
        .mode = WALL_STRAIN, .course = COURSE_RATE, .strain = 0.05, .rate_per_s = 0.2, .rise_s = 0.1};
    const double eps = 16 * DBL_EPSILON;
    assert_near(strain_path_length_m(&a, 1, 0.05), 1 - 0.0025, eps);
    assert_near(strain_path_rate_m_per_s(&a, 1, 0.05), -0.1, eps);
    assert_near(strain_path_length_m(&a, 1, 0.1), 1 - 0.01, eps);
    assert_near(strain_path_rate_m_per_s(&a, 1, 0.2), -0.2, eps);
    assert_near(scene_axis_rate_end_s(&a), 0.3, eps);
    assert_true(strain_path_length_m(&a, 1, 0.31) == 0.95);
    a.strain = -0.0025, a.rate_per_s = -0.2; /* there before the rise is over */
    assert_near(scene_axis_rate_end_s(&a), 0.05, eps);
    assert_near(strain_path_length_m(&a, 1, 0.04), 1 + 0.0016, eps);
}

static void strain_cycles_have_their_rates(void **unused)
{
    static const int courses[] = {COURSE_COSINE, COURSE_TRIANGLE};
    (void)unused;
    for (int k = 0; k < 4; k++) {
        struct scene_axis a = {.mode = WALL_STRAIN, .course = courses[k % 2], .strain = 0.02, .frequency_hz = 3};
        a.two_way = k / 2;
        const double h = 1e-5, omega = 6 * PI;
        /* central difference: third derivative, and rounding of two lengths over 2h */
        const double tolerance = 0.02 * omega * omega * omega * h * h / 6 + 4 * DBL_EPSILON / h;
        double least = 1, most = -1;
        for (double t_s = 0.0013; t_s < 0.7; t_s += 0.0101) {
            const double before = strain_path_length_m(&a, 1, t_s - h), after = strain_path_length_m(&a, 1, t_s + h);
            assert_near(strain_path_rate_m_per_s(&a, 1, t_s), (after - before) / (2 * h), tolerance);
            least = fmin(least, 1 - after);
            most = fmax(most, 1 - after);
        }
        assert_near(most, 0.02, 0.02 * 0.07); /* the grid misses the top by at most 5 ms of 83 */
        assert_near(least, a.two_way ? -0.02 : 0, 0.02 * 0.07);
    }
}

/* ---- coupled axes ---- */

static double volume_at(const struct wall_command *c, double tau_s)
{
    double volume = 1;
    for (int wall = 0; wall < c->n_walls; wall += 2) {
        double x[2];
        for (int k = 0; k < 2; k++)
            x[k] = c->position_m[wall + k] +
                   tau_s * (c->velocity_m_per_s[wall + k] + 0.5 * tau_s * c->acceleration_m_per_s2[wall + k]);
        volume *= x[1] - x[0];
    }
    return volume;
}

/* The largest change of the volume over all steps, in and between exchanges. */
static double volume_error(struct scene *scene)
{
    struct wall_state state = fixture_state(scene_wall_count(scene), 1);
    double worst = 0;
    for (struct wall_command c = answer(scene, &state); !c.finished; c = answer(scene, &state)) {
        for (int k = 1; k <= c.n_steps; k++)
            worst = fmax(worst, fabs(volume_at(&c, k * scene->stage[0].dt_s) - 1));
        fixture_advance(scene, &c, &state);
        fixture_springs(&state, 100, 1);
    }
    return worst;
}

static void the_volume_is_kept_in_every_step(void **unused)
{
    static const struct {
        int dimension, opposite, interval, mode;
        double tolerance;
    } cases[] = {
        /* 10 % in 1000 steps. One step an interval: roundings of 3 lengths, and of the motion. 16 steps: a strain of
         * d = 1.6e-3; where the rate jumps from 0 (worst: the end of the rise) the parabola misses 1/z by 0.15 d^2. */
        {3, OPPOSITE_MIRROR, 1, WALL_STRAIN, 40 * DBL_EPSILON},
        {2, OPPOSITE_FIXED, 1, WALL_STRAIN, 40 * DBL_EPSILON},
        {3, OPPOSITE_MIRROR, 16, WALL_STRAIN, 0.15 * 1.6e-3 * 1.6e-3},
        {2, OPPOSITE_FIXED, 16, WALL_STRAIN, 0.15 * 1.6e-3 * 1.6e-3},
        /* undrained stress cycles at 0.4 m/s; the drive must not close the loop */
        {3, OPPOSITE_FIXED, 4, WALL_STRESS, 0.15 * 1.6e-3 * 1.6e-3},
    };
    (void)unused;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        struct scene *scene = fixture_scene(cases[k].dimension);
        scene->coupling.interval_steps = cases[k].interval;
        scene->coupling.scheme = SCHEME_IMPEDANCE;
        struct scene_axis follow = {.mode = WALL_COUPLED, .keep = KEEP_VOLUME, .opposite = cases[k].opposite};
        scene->stage[0].axis[AXIS_X] = follow;
        if (cases[k].dimension == 3)
            scene->stage[0].axis[AXIS_Y] = follow;
        struct scene_axis *z = &scene->stage[0].axis[AXIS_Z];
        *z = (struct scene_axis){.mode = WALL_STRAIN, .course = COURSE_RATE, .rate_per_s = 0.1, .rise_s = 0.1};
        if (cases[k].mode == WALL_STRESS)
            *z = stress_axis(OPPOSITE_FIXED);
        const double error = volume_error(scene);
        if (!(error <= cases[k].tolerance))
            fail_msg("case %d: the volume is off by %g", (int)k, error);
        fixture_scene_free(scene);
    }
}

/* Forces at which everything that is kept is kept: no wall is moved. One Newton more on z, and the others follow. */
static void kept_stresses_solve_their_equations(void **unused)
{
    static const struct {
        int keep_x, keep_y;
        double x, y, z; /* sigma [N/m^2] at rest, areas of 1 m^2 */
        double dx, dy;  /* what x and y shall have more when z has 1 more */
    } cases[] = {
        {KEEP_P, KEEP_P, 8, 8, 14, -0.5, -0.5},
        {KEEP_PATH, KEEP_PATH, 8, 8, 14, 0.25, 0.25}, /* dq/dp = 1.5: dq = 0.75, dp = 0.5 */
    };
    (void)unused;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        struct scene *scene = fixture_scene(3);
        struct wall_state state = fixture_state(6, 1);
        struct scene_axis axis = {.mode = WALL_COUPLED, .opposite = OPPOSITE_MIRROR, .mass_kg = 1, .pressure_pa = 10};
        axis.dq_dp = 1.5, axis.deviator_pa = 6;
        axis.keep = cases[k].keep_x;
        scene->stage[0].axis[AXIS_X] = axis;
        axis.keep = cases[k].keep_y;
        scene->stage[0].axis[AXIS_Y] = axis;
        scene->coupling.interval_steps = 1;
        state.force_n[0] = state.force_n[1] = cases[k].x;
        state.force_n[2] = state.force_n[3] = cases[k].y;
        state.force_n[4] = state.force_n[5] = cases[k].z;
        state.interval_s = 1e-3;
        struct wall_command rest = answer(scene, &state);
        for (int wall = 0; wall < 4; wall++) /* roundings of 14 N, over a mass of 1 kg */
            assert_near(rest.acceleration_m_per_s2[wall], 0, 14 * 16 * DBL_EPSILON);
        state.force_n[4] = state.force_n[5] = cases[k].z + 1;
        struct wall_command moved = answer(scene, &state); /* m a = F - target */
        assert_near(moved.acceleration_m_per_s2[1], -cases[k].dx, 15 * 16 * DBL_EPSILON);
        assert_near(moved.acceleration_m_per_s2[3], -cases[k].dy, 15 * 16 * DBL_EPSILON);
        fixture_scene_free(scene);
    }
}

/* q = 6 on z beside p = 10 on x and y: 8, 8, 14, whatever the forces; beside walls that keep the volume: sigma_xx + 6.
 */
static void q_is_kept(void **unused)
{
    struct scene *scene = fixture_scene(3);
    struct wall_state state = fixture_state(6, 1);
    struct scene_axis axis = {.mode = WALL_COUPLED, .keep = KEEP_P, .opposite = OPPOSITE_MIRROR, .mass_kg = 1};
    (void)unused;
    axis.pressure_pa = 10;
    scene->stage[0].axis[AXIS_X] = scene->stage[0].axis[AXIS_Y] = axis;
    axis.keep = KEEP_Q, axis.pressure_pa = 6;
    scene->stage[0].axis[AXIS_Z] = axis;
    state.interval_s = 1e-3;
    const double tolerance = 16 * 16 * DBL_EPSILON; /* roundings of 14 N, over a mass of 1 kg */
    struct wall_command command = answer(scene, &state);
    assert_near(command.acceleration_m_per_s2[1], -8, tolerance);
    assert_near(command.acceleration_m_per_s2[3], -8, tolerance);
    assert_near(command.acceleration_m_per_s2[5], -14, tolerance);
    scene->stage[0].axis[AXIS_X].keep = scene->stage[0].axis[AXIS_Y].keep = KEEP_VOLUME;
    state.force_n[0] = state.force_n[1] = 7;
    state.force_n[2] = state.force_n[3] = 9;
    command = answer(scene, &state);
    assert_near(command.acceleration_m_per_s2[5], -14, tolerance);
    fixture_scene_free(scene);
}

/* p = 10, b = 0.25, sigma_zz = 16: sigma_xx = (3 p - (1 + b) sigma_zz)/(2 - b), sigma_yy = sigma_xx + b (16 - sigma_xx)
 */
static void p_and_b_are_kept_together(void **unused)
{
    struct scene *scene = fixture_scene(3);
    struct wall_state state = fixture_state(6, 1);
    const double x_pa = (30 - 1.25 * 16) / 1.75, y_pa = x_pa + 0.25 * (16 - x_pa);
    (void)unused;
    struct scene_axis axis = {.mode = WALL_COUPLED, .keep = KEEP_P, .opposite = OPPOSITE_MIRROR, .mass_kg = 1};
    axis.pressure_pa = 10;
    scene->stage[0].axis[AXIS_X] = axis;
    axis.keep = KEEP_B, axis.b = 0.25;
    scene->stage[0].axis[AXIS_Y] = axis;
    scene->coupling.interval_steps = 1;
    state.interval_s = 1e-3;
    state.force_n[4] = state.force_n[5] = 16;
    struct wall_command command = answer(scene, &state);
    assert_near(command.acceleration_m_per_s2[1], -x_pa, 16 * 16 * DBL_EPSILON);
    assert_near(command.acceleration_m_per_s2[3], -y_pa, 16 * 16 * DBL_EPSILON);
    fixture_scene_free(scene);
}

/* ---- what ends a stage ---- */

/* A state of stage 0 of 2, after 512 steps; stresses 8, 8, 14; z shortened by 2 %. */
static struct scene *ending_scene(struct wall_state *state)
{
    struct scene *scene = fixture_scene(3);
    scene->n_stages = 2;
    scene->stage[1] = scene->stage[0];
    scene->stage[0].condition_steps = 256;
    *state = fixture_state(6, 1);
    state->stage = 0;
    state->step = state->command_step = state->stage_step = 512;
    state->position_m[5] = 0.98;
    state->force_n[0] = state->force_n[1] = state->force_n[2] = state->force_n[3] = 8 * 0.98;
    state->force_n[4] = state->force_n[5] = 14;
    return scene;
}

static void expect_end(const struct scene *scene, const struct wall_state *state, int end)
{
    struct wall_command command = answer(scene, state);
    assert_int_equal(command.ended, end);
    assert_int_equal(command.stage, end != STAGE_END_NONE);
}

static void every_condition_ends_a_stage(void **unused)
{
    struct wall_state state;
    struct scene *scene = ending_scene(&state);
    struct scene_stage *stage = &scene->stage[0];
    struct scene_axis *z = &stage->axis[AXIS_Z];
    (void)unused;
    expect_end(scene, &state, STAGE_END_NONE);
    z->until_strain = (struct config_band){1, {0.0199}};
    expect_end(scene, &state, STAGE_END_STRAIN);
    z->until_strain = (struct config_band){1, {-0.01}};
    expect_end(scene, &state, STAGE_END_NONE);
    z->until_strain = (struct config_band){2, {-0.01, 0.03}};
    expect_end(scene, &state, STAGE_END_NONE);
    z->until_strain = (struct config_band){2, {0.025, 0.03}};
    expect_end(scene, &state, STAGE_END_STRAIN);
    z->until_strain.count = 0;
    z->until_stress_pa = (struct config_band){1, {13.9}};
    expect_end(scene, &state, STAGE_END_STRESS);
    z->until_stress_pa = (struct config_band){2, {13, 15}};
    stage->until_q_pa = (struct config_band){1, {5.9}};
    expect_end(scene, &state, STAGE_END_Q);
    stage->until_q_pa = (struct config_band){1, {6.1}};
    stage->until_q_over_p = (struct config_band){1, {0.59}};
    expect_end(scene, &state, STAGE_END_Q_OVER_P);
    stage->until_q_over_p.value[0] = 0.61;
    stage->until_r_u = 0.49;
    stage->reference_pressure_pa = 20;
    expect_end(scene, &state, STAGE_END_R_U);
    stage->until_r_u = 0.51;
    expect_end(scene, &state, STAGE_END_NONE);
    state.stage_step = 1000;
    expect_end(scene, &state, STAGE_END_LIMIT);
    fixture_scene_free(scene);
}

/* On the schedule and nowhere else; intervals stop there, and ask for the energies. */
static void conditions_have_a_schedule_of_their_own(void **unused)
{
    struct wall_state state;
    struct scene *scene = ending_scene(&state);
    struct scene_stage *stage = &scene->stage[0];
    (void)unused;
    scene->coupling.interval_steps = 100;
    assert_int_equal(answer(scene, &state).n_steps, 100);
    stage->axis[AXIS_Z].until_strain = (struct config_band){1, {0.01}};
    expect_end(scene, &state, STAGE_END_STRAIN);
    state.stage_step = 511;
    expect_end(scene, &state, STAGE_END_NONE);
    assert_int_equal(answer(scene, &state).n_steps, 1);
    assert_int_equal(answer(scene, &state).measure, 0); /* no energy is wanted */
    stage->until_energy_ratio = 1e-3;
    assert_int_equal(answer(scene, &state).measure, 1);
    state.stage_step = 500;
    assert_int_equal(answer(scene, &state).n_steps, 12);
    state.stage_step = 300;
    assert_int_equal(answer(scene, &state).n_steps, 100);
    assert_int_equal(answer(scene, &state).measure, 0);
    fixture_scene_free(scene);
}

/* Three cycles of 0.1 s in steps of 3 ms are 100 steps; a longer limit does not matter, a shorter one does. */
static void cycles_are_counted(void **unused)
{
    struct scene *scene = fixture_scene(2);
    struct wall_state state = fixture_state(4, 1);
    struct scene_stage *stage = &scene->stage[0];
    (void)unused;
    scene->coupling.interval_steps = 1000;
    stage->dt_s = 3e-3, stage->duration_s = 10, stage->until_cycles = 3;
    stage->axis[AXIS_Z] = (struct scene_axis){.mode = WALL_STRAIN, .course = COURSE_COSINE, .frequency_hz = 10};
    assert_int_equal(answer(scene, &state).n_steps, 100);
    state.stage = 0, state.stage_step = 100;
    struct wall_command command = answer(scene, &state);
    assert_true(command.finished && command.ended == STAGE_END_CYCLES);
    stage->duration_s = 0.15;
    command = answer(scene, &state);
    assert_true(command.finished && command.ended == STAGE_END_LIMIT);
    fixture_scene_free(scene);
}

/* ---- input ---- */

static void refuse(const struct scene *scene, const struct wall_state *state, const char *part_of_message)
{
    struct wall_command command;
    assert_int_equal(wallctl_law(scene, state, &command), STATUS_FORMAT);
    assert_non_null(strstr(status_message(), part_of_message));
}

static void bad_states_are_refused(void **unused)
{
    struct scene *scene = fixture_scene(2);
    const struct wall_state good = fixture_state(4, 1);
    struct wall_state bad = fixture_state(6, 1);
    (void)unused;
    assert_int_equal(answer(scene, &good).stage, 0);
    refuse(scene, &bad, "6 walls");
    bad = good, bad.stage = 1;
    refuse(scene, &bad, "stage 1");
    bad = good, bad.stage = -2;
    refuse(scene, &bad, "stage -2");
    bad = good, bad.stage_step = -1;
    refuse(scene, &bad, "stage");
    bad = good, bad.force_n[3] = NAN;
    refuse(scene, &bad, "finite");
    bad = good, bad.velocity_m_per_s[0] = INFINITY;
    refuse(scene, &bad, "finite");
    bad = good, bad.kinetic_energy_j = NAN;
    refuse(scene, &bad, "finite");
    bad = good, bad.interval_s = -1;
    refuse(scene, &bad, "negative interval");
    bad = good, bad.position_m[Z_LO] = 1;
    refuse(scene, &bad, "axis z have met");
    fixture_scene_free(scene);
}

static void a_command_that_is_not_finite_is_refused(void **unused)
{
    struct scene *scene = oscillator_scene(1e-3, 1);
    struct wall_state state = fixture_state(4, 1);
    struct wall_command command;
    (void)unused;
    state.force_n[Z_HI] = DBL_MAX;
    scene->stage[0].axis[AXIS_Z].mass_kg = DBL_MIN;
    scene->stage[0].axis[AXIS_Z].damping_kg_per_s = DBL_MIN;
    assert_int_equal(wallctl_law(scene, &state, &command), STATUS_UNSTABLE);
    fixture_scene_free(scene);
}

/* The law keeps nothing: the same state gives the same bits, also after answering others. */
static void the_law_keeps_nothing(void **unused)
{
    unsigned char first[WALL_MESSAGE_MAX], second[WALL_MESSAGE_MAX];
    struct scene *scene = oscillator_scene(1e-3, 1);
    struct wall_state state = fixture_state(4, 1);
    (void)unused;
    for (int k = 0; k < 50; k++) {
        struct wall_command command = answer(scene, &state);
        size_t size = wall_command_encode(&command, 1, k, state.time_s, first);
        struct wall_state other = fixture_state(4, 2);
        other.force_n[Z_HI] = k;
        command = answer(scene, &other);
        command = answer(scene, &state);
        assert_int_equal(wall_command_encode(&command, 1, k, state.time_s, second), size);
        assert_memory_equal(first, second, size);
        fixture_advance(scene, &command, &state);
        fixture_springs(&state, OSCILLATOR_K, 1);
    }
    fixture_scene_free(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(strain_path_has_its_closed_form),
        cmocka_unit_test(strain_rate_is_the_derivative),
        cmocka_unit_test(strain_control_stays_on_the_path),
        cmocka_unit_test(stress_control_is_of_second_order),
        cmocka_unit_test(held_intervals_follow_the_same_positions),
        cmocka_unit_test(stress_control_has_its_limits),
        cmocka_unit_test(mirror_keeps_the_centre),
        cmocka_unit_test(mirror_follows_the_mean_force),
        cmocka_unit_test(constant_opposite_is_a_wall_of_its_own),
        cmocka_unit_test(area_is_the_product_of_the_other_lengths),
        cmocka_unit_test(targets_have_their_closed_forms),
        cmocka_unit_test(stages_have_whole_steps),
        cmocka_unit_test(cycles_are_whole),
        cmocka_unit_test(a_new_stage_starts_where_the_walls_are),
        cmocka_unit_test(energy_condition_ends_a_stage),
        cmocka_unit_test(stress_condition_looks_at_every_controlled_wall),
        cmocka_unit_test(cycles_and_tables_have_their_closed_forms),
        cmocka_unit_test(a_rate_rises_and_ends),
        cmocka_unit_test(strain_cycles_have_their_rates),
        cmocka_unit_test(the_volume_is_kept_in_every_step),
        cmocka_unit_test(kept_stresses_solve_their_equations),
        cmocka_unit_test(q_is_kept),
        cmocka_unit_test(p_and_b_are_kept_together),
        cmocka_unit_test(every_condition_ends_a_stage),
        cmocka_unit_test(conditions_have_a_schedule_of_their_own),
        cmocka_unit_test(cycles_are_counted),
        cmocka_unit_test(bad_states_are_refused),
        cmocka_unit_test(a_command_that_is_not_finite_is_refused),
        cmocka_unit_test(the_law_keeps_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
