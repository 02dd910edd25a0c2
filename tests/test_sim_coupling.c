/* The coupling schemes on a wall at the end of a chain of particles, against its closed form; what is exact at an
 * interval of one step; the interface residual; and how an unstable loop is stopped. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "sim/measure/measure.h"
#include "sim/sample/stage.h"
#include "sim/sample/step_completion.h"
#include "sim_fixture.h"
#include "wallctl/stress_control.h"

static const double PI = 3.14159265358979323846;

/* ---- a chain: wall, 8 particles, wall of a particle's mass under constant pressure; nine equal springs and masses
 * with one end fixed and one free: omega_1 = 2 sqrt(k/m) sin(pi/(2 (2 N + 1))), u_i = sin(i pi/(2 N + 1)), i = 1 ... N
 * ---- */

enum { CHAIN = 8, MASSES = CHAIN + 1, STEPS = 4096 };
static const double K = 1e5, RADIUS = 1e-3, OVERLAP = 1e-5, AMPLITUDE = 1e-7;

static double disc_mass(void)
{
    return 4.0 / 3.0 * PI * 2000 * RADIUS * RADIUS * RADIUS;
}

static double chain_omega(void)
{
    return 2 * sqrt(K / disc_mass()) * sin(PI / (2 * (2 * MASSES + 1)));
}

/* STEPS steps are three eighths of a period. */
static double chain_dt(void)
{
    return 0.375 * 2 * PI / chain_omega() / STEPS;
}

static double chain_shape(int i)
{
    return sin(i * PI / (2 * MASSES + 1));
}

/* Box of height 1 (area 1 m^2 with the 2D depth), the chain at half height, at rest, bent into its first mode. */
static struct fixture chain_open(const char *coupling)
{
    char text[2048];
    snprintf(text, sizeof text,
             "dimension = 2;\n"
             "sample = { count = %d; radius_min_m = %.17g; radius_max_m = %.17g; density_kg_per_m3 = 2000.0; };\n"
             "material = { kn_n_per_m = %.17g; };\n"
             "walls = { x = { mode = \"stress\"; pressure_pa = %.17g; mass_kg = %.17g; damping_kg_per_s = 0.0;\n"
             "  opposite = \"fixed\"; }; };\n"
             "coupling = { %s };\n"
             "stages = ( { name = \"a\"; dt_s = %.17e; duration_s = 1.0; } );\n",
             CHAIN, RADIUS, RADIUS, K, K * OVERLAP, disc_mass(), coupling, chain_dt());
    struct fixture fixture = fixture_from_text(text);
    struct sample *sample = fixture.sample;
    for (int i = 0; i < CHAIN; i++) {
        sample->particles.x[0][i] = (2 * i + 1) * RADIUS - (i + 1) * OVERLAP + AMPLITUDE * chain_shape(i + 1);
        sample->particles.x[1][i] = 0.5;
    }
    sample->walls[0].x = sample->walls[2].x = 0;
    sample->walls[1].x = 2 * CHAIN * RADIUS - MASSES * OVERLAP + AMPLITUDE * chain_shape(MASSES);
    sample->walls[3].x = 1;
    for (int w = 0; w < 4; w++)
        sample->trajectory.x0[w] = sample->walls[w].x;
    particles_set_mass(&sample->particles, 2000);
    must(verlet_list_build(&sample->verlet, &sample->particles, &sample->pairs, sample->walls, sample->n_walls));
    struct wall_command start = {.n_steps = 1, .n_walls = 4}; /* forces of the bent chain, before the first state */
    for (int w = 0; w < 4; w++)
        start.position_m[w] = sample->walls[w].x;
    must(sample_command(sample, &start));
    sample->trajectory.n_steps = 0; /* no interval before the first */
    return fixture;
}

/* Error of the wall's place at the end, over the amplitude. */
static double chain_error(const char *scheme, int n)
{
    char coupling[128];
    snprintf(coupling, sizeof coupling, "scheme = \"%s\"; interval_steps = %d;", scheme, n);
    struct fixture fixture = chain_open(coupling);
    fixture_run(&fixture, STEPS);
    assert_int_equal(fixture.sample->step, STEPS);
    double rest = 2 * CHAIN * RADIUS - MASSES * OVERLAP;
    double exact = AMPLITUDE * chain_shape(MASSES) * cos(chain_omega() * STEPS * chain_dt());
    double error = fabs(fixture.sample->walls[1].x - rest - exact) / (AMPLITUDE * chain_shape(MASSES));
    fixture_close(&fixture);
    return error;
}

/* Of second order: doubling the interval multiplies the error by four. From 32 steps on it is far above the error of
 * the time step itself (that of n = 1), which is taken off; up to 256 the next order is below a quarter. */
static void schemes_are_of_second_order(void **unused)
{
    static const char *const schemes[] = {"hold", "jacobian", "pipelined"};
    (void)unused;
    for (int s = 0; s < 3; s++) {
        double before = 0, floor = chain_error(schemes[s], 1);
        assert_true(floor < 1e-5);
        for (int n = 32; n <= 256; n *= 2) {
            double error = chain_error(schemes[s], n);
            print_message("%s n = %d: error %.3g of the amplitude, order %.3f\n", schemes[s], n, error,
                          before > 0 ? log2(error / before) : NAN);
            assert_true(error > 20 * floor);
            if (before > 0)
                assert_close(schemes[s], log2(error / before), 2, 0.3);
            before = error;
        }
    }
}

/* A constant driving force is the same in every step: the bits of the exact loop at any interval. */
static void impedance_is_exact_under_a_constant_load(void **unused)
{
    (void)unused;
    struct fixture exact = chain_open("interval_steps = 1;");
    fixture_run(&exact, STEPS);
    for (int n = 1; n <= STEPS; n *= 8) {
        char coupling[128];
        snprintf(coupling, sizeof coupling, "scheme = \"impedance\"; interval_steps = %d;", n);
        struct fixture fixture = chain_open(coupling);
        fixture_run(&fixture, STEPS);
        assert_true(sample_hash(sample_complete(fixture.sample)) == sample_hash(sample_complete(exact.sample)));
        fixture_close(&fixture);
    }
    fixture_close(&exact);
}

/* The error follows the tolerance: a tenth of it must give less, and no more than a third of the exchanges are saved on
 * nothing. */
static double adaptive_error(double tolerance, int *exchanges)
{
    char coupling[128];
    snprintf(coupling, sizeof coupling, "scheme = \"adaptive\"; interval_steps = 512; tolerance = %g;", tolerance);
    struct fixture fixture = chain_open(coupling);
    struct sample *sample = fixture.sample;
    for (*exchanges = 0; sample->step < STEPS; ++*exchanges)
        fixture_run(&fixture, sample->step + 1); /* one interval */
    double rest = 2 * CHAIN * RADIUS - MASSES * OVERLAP, t = (double)sample->step * chain_dt();
    double exact = AMPLITUDE * chain_shape(MASSES) * cos(chain_omega() * t);
    double error = fabs(sample->walls[1].x - rest - exact) / (AMPLITUDE * chain_shape(MASSES));
    fixture_close(&fixture);
    return error;
}

static void adaptive_follows_its_tolerance(void **unused)
{
    int many, few;
    (void)unused;
    double fine = adaptive_error(1e-7, &many), coarse = adaptive_error(1e-5, &few);
    print_message("tolerance 1e-7: error %.3g in %d exchanges; 1e-5: %.3g in %d\n", fine, many, coarse, few);
    assert_true(few < many / 3 && many < STEPS / 4);
    assert_true(fine < coarse / 5);
}

/* ---- a small sample under pressure and strain ---- */

static const char *sample_text(const char *coupling, const char *stage)
{
    static char text[2048];
    snprintf(text, sizeof text,
             "dimension = 2;\n"
             "sample = { count = 60; radius_min_m = 0.5e-3; radius_max_m = 1.5e-3; density_kg_per_m3 = 2000.0;\n"
             "  speed_m_per_s = 1.0; };\n"
             "material = { kn_n_per_m = 1e5; gamma_n_kg_per_s = 0.1; gamma_b_kg_per_s = 0.01; };\n"
             "walls = { x = { mode = \"stress\"; pressure_pa = 500.0; mass_kg = 1e-5; damping_kg_per_s = 2.0; };\n"
             "  z = { mode = \"stress\"; pressure_pa = 500.0; mass_kg = 1e-5; damping_kg_per_s = 2.0; }; };\n"
             "coupling = { %s };\n"
             "stages = ( { name = \"press\"; dt_s = 1e-6; duration_s = 0.02; %s },\n"
             "  { name = \"shear\"; dt_s = 5e-7; duration_s = 0.005;\n"
             "    walls = { z = { mode = \"strain\"; strain = 0.02; frequency_hz = 100.0; }; }; } );\n",
             coupling, stage);
    return text;
}

enum { PRESS_STEPS = 20000, SAMPLE_STEPS = PRESS_STEPS + 10000 };

static struct fixture sample_run(const char *coupling, int64_t steps)
{
    struct fixture fixture = fixture_from_text(sample_text(coupling, ""));
    fixture_run(&fixture, steps);
    return fixture;
}

static void all_schemes_are_exact_at_one_step(void **unused)
{
    static const char *const schemes[] = {"jacobian", "adaptive", "impedance", "compensated"};
    (void)unused;
    struct fixture exact = sample_run("scheme = \"hold\"; interval_steps = 1;", SAMPLE_STEPS);
    assert_true(exact.sample->audit.residual_j == 0);
    for (int s = 0; s < 4; s++) {
        char coupling[128];
        snprintf(coupling, sizeof coupling, "scheme = \"%s\"; interval_steps = 1;", schemes[s]);
        struct fixture fixture = sample_run(coupling, SAMPLE_STEPS);
        assert_true(sample_hash(sample_complete(fixture.sample)) == sample_hash(sample_complete(exact.sample)));
        fixture_close(&fixture);
    }
    fixture_close(&exact);
}

/* Both sides measure the same energy: with the force that the controller took for the sample's the mismatch differs by
 * the part that its added mass stands for. Shorter intervals leave less. */
static void both_sides_measure_the_residual(void **unused)
{
    double coarse = INFINITY;
    (void)unused;
    for (int n = 32; n >= 8; n /= 4) {
        char coupling[128];
        snprintf(coupling, sizeof coupling, "scheme = \"jacobian\"; interval_steps = %d;", n);
        struct fixture fixture = sample_run(coupling, SAMPLE_STEPS);
        const struct coupling_audit *audit = &fixture.sample->audit;
        print_message("n = %d: %.3g J, controller %.3g J, work %.3g J\n", n, audit->residual_j,
                      audit->controller_residual_j, fixture.sample->ledger.work_walls);
        assert_true(audit->residual_j > 0 && audit->residual_j < 0.03 * fixture.sample->ledger.work_walls);
        assert_true(audit->controller_residual_j > 0);
        assert_true(audit->controller_residual_j < 0.3 * fixture.sample->ledger.work_walls);
        assert_true(audit->residual_j < coarse / 4);
        coarse = audit->residual_j;
        fixture_close(&fixture);
    }
}

/* A load that changes along the interval is foreseen by a parabola, the way of the other walls by their velocity: the
 * jump of the driving force at the end of an interval is of second order, and half as many are twice as long. */
static void impedance_foresees_the_load(void **unused)
{
    double jump[2];
    (void)unused;
    for (int k = 0; k < 2; k++) {
        struct fixture fixture = fixture_from_text(sample_text(
            k == 0 ? "scheme = \"impedance\"; interval_steps = 400;" : "scheme = \"impedance\"; interval_steps = 200;",
            "walls = { x = { target = \"cosine\"; amplitude_pa = 100.0; period_s = 0.002; }; };"));
        fixture_run(&fixture, PRESS_STEPS);
        jump[k] = fixture.sample->audit.residual_j;
        fixture_close(&fixture);
    }
    print_message("jumps of the driving force: %.3g J, halved intervals %.3g J\n", jump[0], jump[1]);
    assert_true(jump[1] > 0 && jump[1] < jump[0] / 3);
}

/* ---- loops that are not stable ---- */

/* The step at which a sample that was pressed in small steps is stopped under the coupling; -1: it is not. */
static enum status pressed_then(const char *coupling, char message[512])
{
    struct fixture fixture = fixture_from_text(sample_text("interval_steps = 1;", ""));
    fixture_run(&fixture, PRESS_STEPS);
    struct fixture other = {.scene = fixture_scene_of(sample_text(coupling, "")), .sample = fixture.sample};
    other.sample->scene = other.scene;
    enum status status = fixture_try(&other, SAMPLE_STEPS);
    snprintf(message, 512, "%s", status == STATUS_OK ? "" : status_message());
    other.sample->scene = fixture.scene;
    fixture_scene_free(other.scene);
    fixture_close(&fixture);
    return status;
}

static void an_unstable_loop_names_an_interval_that_holds(void **unused)
{
    char message[512], coupling[128];
    int n = 0;
    (void)unused;
    assert_int_equal(pressed_then("scheme = \"hold\"; interval_steps = 64;", message), STATUS_UNSTABLE);
    print_message("%s\n", message);
    const char *named = strstr(message, "coupling.interval_steps = ");
    assert_non_null(named);
    assert_int_equal(sscanf(named, "coupling.interval_steps = %d", &n), 1);
    assert_in_range(n, 2, 32);
    snprintf(coupling, sizeof coupling, "scheme = \"hold\"; interval_steps = %d;", n);
    assert_int_equal(pressed_then(coupling, message), STATUS_OK);
    assert_int_equal(pressed_then("scheme = \"jacobian\"; interval_steps = 64;", message), STATUS_OK);
    assert_int_equal(pressed_then("scheme = \"adaptive\"; interval_steps = 64;", message), STATUS_OK);
    assert_int_equal(pressed_then("scheme = \"compensated\"; interval_steps = 64;", message), STATUS_OK);
    assert_int_equal(pressed_then("scheme = \"impedance\"; interval_steps = 64;", message), STATUS_OK);
}

/* Nothing to push on and nothing that brakes: the wall runs over the particles, which is the end. */
static void a_wall_that_nothing_holds_is_stopped(void **unused)
{
    struct fixture_options options = {
        .dimension = 2,
        .count = 2,
        .dt_s = 1e-6,
        .material = "kn_n_per_m = 1e5;",
        .more = "walls = { x = { mode = \"stress\"; pressure_pa = 1e7; mass_kg = 1e-3; damping_kg_per_s = 0.0; }; };"};
    (void)unused;
    struct fixture fixture = fixture_open(&options);
    assert_int_equal(fixture_try(&fixture, 1000000), STATUS_UNSTABLE);
    print_message("%s\n", status_message());
    assert_non_null(strstr(status_message(), "heavier wall"));
    fixture_close(&fixture);
}

/* The bound of the hold scheme has a closed form: K H/gamma < 2 coth(gamma H/2m). */
static void stable_steps_are_the_closed_form(void **unused)
{
    const double dt = 5e-7;
    (void)unused;
    for (double mass = 1e-6; mass < 1; mass *= 10) {
        struct stress_loop loop = {.mass_kg = mass, .damping_kg_per_s = 19.35, .stiffness_n_per_m = 6e6};
        int n = 0;
        while (n < 512) {
            double h = (n + 1) * dt;
            if (!(loop.stiffness_n_per_m * h / loop.damping_kg_per_s <
                  2 / tanh(loop.damping_kg_per_s * h / (2 * mass))))
                break;
            n++;
        }
        const struct scene_coupling hold = {.scheme = SCHEME_HOLD}, jacobian = {.scheme = SCHEME_JACOBIAN};
        int found = stress_stable_steps(&hold, &loop, dt, 512);
        print_message("m = %g kg: %d steps, closed form %d\n", mass, found, n);
        assert_in_range(found, n - 1, n);
        assert_int_equal(stress_stable_steps(&jacobian, &loop, dt, 512), 512);
        for (int ahead = 0; ahead <= 256; ahead += ahead + 1) {
            const struct scene_coupling compensated = {.scheme = SCHEME_COMPENSATED, .ahead_steps = ahead};
            assert_int_equal(stress_stable_steps(&compensated, &loop, dt, 512), 512);
        }
    }
}

/* ---- compensated ---- */

/* The force of a spring and a damper at t in an interval of H = 1: s has the position where it begins, the mean
 * velocity and the acceleration. */
static double spring_force(const double s[3], double t, double k, double g)
{
    const double v = s[1] + (t - 0.5) * s[2];
    return -k * (s[0] + t * (s[1] + 0.5 * (t - 1) * s[2])) - g * v;
}

/* Spectral radius of one interval of H = 1 on a spring and a damper that need not be as stiff as their bounds, from
 * 2^26 intervals: a double root of modulus 1 grows with their number N and so reads 1 + ln(N)/N. The force is told
 * bounds->ahead_s before the end. */
static double radius(int scheme, const struct stress_loop *bounds, double k, double g)
{
    const double asked_s = 1 - bounds->ahead_s;
    enum { SQUARINGS = 26 };
    double m[3][3], log_size = 0;
    for (int column = 0; column < 3; column++) {
        const double s[3] = {column == 0, column == 1, column == 2};
        const double told = spring_force(s, asked_s, k, g);
        struct stress_loop loop = *bounds;
        loop.velocity_m_per_s = s[1];
        loop.acceleration_m_per_s2 = s[2];
        loop.force_n = told + bounds->ahead_s / asked_s * (told - spring_force(s, 0, k, g));
        struct wall_motion motion = stress_motion(scheme, &loop).motion;
        m[1][column] = motion.velocity_m_per_s + 0.5 * motion.acceleration_m_per_s2;
        m[0][column] = s[0] + s[1];
        m[2][column] = motion.acceleration_m_per_s2;
    }
    for (int n = 0; n < SQUARINGS; n++) {
        double square[3][3] = {{0}}, size = 0;
        for (int i = 0; i < 27; i++)
            square[i / 9][i % 3] += m[i / 9][i / 3 % 3] * m[i / 3 % 3][i % 3];
        for (int i = 0; i < 9; i++)
            size = fmax(size, fabs(square[i / 3][i % 3]));
        for (int i = 0; i < 9; i++)
            m[i / 3][i % 3] = square[i / 3][i % 3] / size;
        log_size = 2 * log_size + log(size);
    }
    return exp(log_size / (1 << SQUARINGS));
}

/* Bounds K = 1 and g over ten decades of mass, damping and what the contacts really are, in units of K H and K H^2. */
static double worst_radius(int scheme, double ahead_s)
{
    double worst = 0;
    for (double mass = 1e-6; mass < 2e6; mass *= 10)
        for (double damping = 1e-5; damping < 2e4; damping *= pow(10, 0.25))
            for (double bound = 1e-4; bound < 200; bound *= 10)
                for (double k = 1; k > 1e-5; k /= 3)
                    for (int part = 0; part <= 2; part++) {
                        struct stress_loop loop = {.mass_kg = mass,
                                                   .damping_kg_per_s = damping,
                                                   .stiffness_n_per_m = 1,
                                                   .contact_damping_kg_per_s = bound,
                                                   .last_interval_s = 1,
                                                   .interval_s = 1,
                                                   .ahead_s = ahead_s};
                        worst = fmax(worst, radius(scheme, &loop, k, 0.5 * part * bound));
                    }
    return worst;
}

static void compensated_is_stable_on_all_springs(void **unused)
{
    (void)unused;
    const double hold = worst_radius(SCHEME_HOLD, 0);
    print_message("largest radius - 1: hold %.3g\n", hold - 1);
    for (int quarters = 0; quarters <= 2; quarters++) {
        const double ahead_s = 0.25 * quarters, compensated = worst_radius(SCHEME_COMPENSATED, ahead_s);
        print_message("compensated, asked %g of an interval ahead: %.3g\n", ahead_s, compensated - 1);
        assert_true(compensated < 1 + 1e-6); /* ln(2^26)/2^26 = 2.7e-7, and rounding */
    }
    assert_true(hold > 2);
}

/* ---- a wall of mass 1 with damping 1/2 on a spring 1 that the bound takes for 10, from rest at 1: closed form ---- */

static const double OSCILLATOR_BOUND = 10, OSCILLATOR_DAMPING = 0.5, OSCILLATOR_END_S = 4;

static double oscillator_position(double t)
{
    const double decay = 0.5 * OSCILLATOR_DAMPING, omega = sqrt(1 - decay * decay);
    return exp(-decay * t) * (cos(omega * t) + decay / omega * sin(omega * t));
}

static double oscillator_velocity(double t)
{
    const double decay = 0.5 * OSCILLATOR_DAMPING, omega = sqrt(1 - decay * decay);
    return -exp(-decay * t) / omega * sin(omega * t);
}

/* Error of the position at the end, with intervals of h that began before the start. */
static double oscillator_error(int scheme, double h, double ahead) /* a part of h */
{
    struct stress_loop loop = {.mass_kg = 1,
                               .damping_kg_per_s = OSCILLATOR_DAMPING,
                               .stiffness_n_per_m = OSCILLATOR_BOUND,
                               .last_interval_s = h,
                               .interval_s = h,
                               .ahead_s = ahead * h,
                               .velocity_m_per_s = (1 - oscillator_position(-h)) / h,
                               .acceleration_m_per_s2 = -oscillator_velocity(-h) / h};
    double x = oscillator_position(-h);
    for (int k = 0; k < (int)(OSCILLATOR_END_S / h + 0.5); k++) {
        const double asked_s = h - loop.ahead_s, v = loop.velocity_m_per_s, a = loop.acceleration_m_per_s2;
        const double way = asked_s * (v + 0.5 * (asked_s - h) * a);
        loop.force_n = -(x + way) - loop.ahead_s / asked_s * way;
        x += h * v;
        struct wall_motion motion = stress_motion(scheme, &loop).motion;
        loop.velocity_m_per_s = motion.velocity_m_per_s + 0.5 * h * motion.acceleration_m_per_s2;
        loop.acceleration_m_per_s2 = motion.acceleration_m_per_s2;
    }
    return fabs(x + h * loop.velocity_m_per_s - oscillator_position(OSCILLATOR_END_S));
}

/* Second order, from where the next one is below a tenth; and without the price of the added mass K H^2/4, the error of
 * jacobian: what is left is the midpoint rule's, (omega H)^2/12, and that of a force that is expected to go on as it
 * went, (omega H)^2/2 times the part of H that it is told ahead. A tenth for orders above. */
static void compensated_does_not_pay_for_its_added_mass(void **unused)
{
    (void)unused;
    for (double ahead = 0; ahead <= 0.5; ahead += 0.25) {
        double before = 0;
        for (double h = 0.0125; h > 0.003; h *= 0.5) {
            const double jacobian = oscillator_error(SCHEME_JACOBIAN, h, 0);
            const double error = oscillator_error(SCHEME_COMPENSATED, h, ahead);
            print_message("ahead %g H = %g: jacobian %.3g, compensated %.3g, order %.2f\n", ahead, h, jacobian, error,
                          before > 0 ? log2(before / error) : NAN);
            assert_true(error > 0 && error < 1.1 * (1 / 12.0 + 0.5 * ahead) / (0.25 * OSCILLATOR_BOUND) * jacobian);
            if (before > 0)
                assert_close("compensated", log2(before / error), 2, 0.3);
            before = error;
        }
    }
}

struct hard_case {
    const char *name;
    double mass_kg, damping_kg_per_s, away_m, kc_n_per_m, pressure_pa;
};

static enum status hard_run(const struct hard_case *at, const char *scheme, int n)
{
    char coupling[64];
    snprintf(coupling, sizeof coupling, "scheme = \"%s\"; interval_steps = %d;", scheme, n);
    struct fixture pressed = sample_run("interval_steps = 1;", PRESS_STEPS);
    struct fixture hard = {.scene = fixture_scene_of(sample_text(coupling, "")), .sample = pressed.sample};
    struct scene_stage *stage = &hard.scene->stage[1];
    stage->axis[0].mass_kg = at->mass_kg;
    stage->axis[0].damping_kg_per_s = at->damping_kg_per_s;
    stage->axis[0].pressure_pa = at->pressure_pa;
    stage->material.kc_n_per_m = at->kc_n_per_m;
    hard.sample->walls[1].x += at->away_m;
    hard.sample->scene = hard.scene;
    enum status status = fixture_try(&hard, SAMPLE_STEPS);
    if (status != STATUS_OK)
        print_message("%s, %s %d: %s\n", at->name, scheme, n, status_message());
    hard.sample->scene = pressed.scene;
    fixture_scene_free(hard.scene);
    fixture_close(&pressed);
    return status;
}

static void compensated_holds_in_hard_cases(void **unused)
{
    static const struct hard_case cases[] = {{"light wall", 1e-8, 2, 0, 0, 500},   {"heavy wall", 1, 2, 0, 0, 500},
                                             {"no damping", 1e-5, 0, 0, 0, 500},   {"empty", 1e-5, 2, 0.05, 0, 500},
                                             {"contact", 1e-5, 0.1, 5e-4, 0, 500}, {"pull", 1e-5, 2, 0, 4e5, 5}};
    (void)unused;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++)
        for (int n = 8; n <= 256; n *= k == 0 ? 2 : 4)
            assert_int_equal(hard_run(&cases[k], "compensated", n), STATUS_OK);
    assert_int_equal(hard_run(&cases[0], "hold", 64), STATUS_UNSTABLE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(schemes_are_of_second_order),
        cmocka_unit_test(impedance_is_exact_under_a_constant_load),
        cmocka_unit_test(adaptive_follows_its_tolerance),
        cmocka_unit_test(all_schemes_are_exact_at_one_step),
        cmocka_unit_test(both_sides_measure_the_residual),
        cmocka_unit_test(impedance_foresees_the_load),
        cmocka_unit_test(an_unstable_loop_names_an_interval_that_holds),
        cmocka_unit_test(a_wall_that_nothing_holds_is_stopped),
        cmocka_unit_test(stable_steps_are_the_closed_form),
        cmocka_unit_test(compensated_is_stable_on_all_springs),
        cmocka_unit_test(compensated_does_not_pay_for_its_added_mass),
        cmocka_unit_test(compensated_holds_in_hard_cases),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
