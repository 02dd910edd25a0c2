/* Packed samples with friction: the energy ledger over cycles, friction coefficient zero, and the hard cases: each must
 * stay finite and account for its energy, or end with an error that says what is wrong. */
#include "common/scene_file.h"
#include "sim_fixture.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sim/measure/measure.h"
#include "sim/sample/stage.h"
#include "sim/sample/step_completion.h"
#include "sim/sample/time_step.h"
#include "sim/sample/wall_state.h"
#include "wallctl/control_law.h"

static const double PI = 3.14159265358979323846;
static const char quick[] = SCENES "/triaxial_quick.cfg"; /* 216 spheres; 65 000 steps of preparation, then cycles */

static struct fixture open_scene(const char *path, const char *const *overrides)
{
    struct fixture f = {.scene = calloc(1, sizeof *f.scene)};
    int n = 0;
    while (overrides && overrides[n])
        n++;
    assert_non_null(f.scene);
    must(scene_load(f.scene, path, overrides, n));
    must(sample_create(&f.sample, f.scene));
    return f;
}

/* As fixture_run, but hands errors back. */
static enum status try_run(struct fixture *f, int64_t n_steps)
{
    struct sample *sample = f->sample;
    while (sample->step < n_steps) {
        struct wall_state state;
        struct wall_command command;
        sample_wall_state(sample, &state);
        state.energy_step = -1;
        TRY(wallctl_law(f->scene, &state, &command));
        if (command.finished)
            return STATUS_OK;
        TRY(sample_command(sample, &command));
        for (int k = 0; k < command.n_steps; k++)
            TRY(sample_step(sample));
    }
    return STATUS_OK;
}

static int64_t steps_of(const struct fixture *f, int stages)
{
    int64_t steps = 0;
    for (int k = 0; k < stages; k++)
        steps += llround(f->scene->stage[k].duration_s / f->scene->stage[k].dt_s);
    return steps;
}

/* The residual gained in each cycle over the work of that cycle (sum of absolute changes): less than 0.1 % is what the
 * scene promises. The scheme is of second order, stick and slide apart: (omega dt)^2/12 at 24 steps per contact time is
 * 1.4e-3 of what vibrates, and in quasi-static cycles hardly anything does. */
static void ledger_of_cycles(void **state)
{
    enum { CYCLES = 4, PARTS = 50 };
    static const char *const strong[] = {"material.mu_s=0.5", NULL};
    /* nothing damps what sticks, at t_c/24 */
    static const char *const undamped[] = {"material.mu_s=0.5", "material.kt_n_per_m=5000.0",
                                           "material.gamma_t_kg_per_s=0.0", "material.gamma_br_kg_per_s=0.0", NULL};
    static const char *const *const overrides[] = {NULL, strong, undamped};
    (void)state;
    for (int variant = 0; variant < 3; variant++) {
        struct fixture f = open_scene(quick, overrides[variant]);
        struct measurement m;
        int64_t start = steps_of(&f, 2), period = llround(0.2 / f.scene->stage[2].dt_s);
        double residual = 0, work = 0, friction = 0;
        fixture_run(&f, start + 1);
        assert_int_equal(f.sample->stage, 2);
        for (int cycle = 0; cycle < CYCLES; cycle++) {
            double total = 0, worst = 0;
            for (int k = 1; k <= PARTS; k++) {
                fixture_run(&f, start + cycle * period + k * period / PARTS);
                total += fabs(f.sample->ledger.work_walls - work);
                work = f.sample->ledger.work_walls;
                must(measure(sample_complete(f.sample), &m));
                worst = fmax(worst, fabs(m.residual_j - residual));
            }
            residual = m.residual_j;
            print_message("mu %g, cycle %d: residual %.2g of %.2g J, sliding %.3f\n", f.scene->stage[2].material.mu_s,
                          cycle + 1, worst / total, total, m.sliding_fraction);
            assert_true(worst < 1e-3 * total);
        }
        friction = f.sample->ledger.contacts.friction;
        assert_true(friction > 0.01 * (f.sample->ledger.contacts.viscous_normal + friction)); /* it did slide */
        fixture_close(&f);
    }
}

/* Stage 0 has no friction; whether friction is modelled (stage 1 has it) must not change a bit of x and v. */
static void no_friction_is_frictionless(void **state)
{
    static const char *const none[] = {"material.mu_s=0", NULL};
    struct fixture with = open_scene(quick, NULL), without = open_scene(quick, none);
    (void)state;
    assert_int_equal(with.sample->particles.n_rotations, 3);
    assert_int_equal(without.sample->particles.n_rotations, 0);
    fixture_run(&with, 30000);
    fixture_run(&without, 30000);
    assert_true(with.sample->pairs.count > 0);
    for (int c = 0; c < 3; c++) {
        size_t size = (size_t)with.sample->particles.count * sizeof(double);
        assert_memory_equal(with.sample->particles.x[c], without.sample->particles.x[c], size);
        assert_memory_equal(with.sample->particles.v[c], without.sample->particles.v[c], size);
        assert_true(with.sample->particles.omega[c][0] == 0);
    }
    fixture_close(&with);
    fixture_close(&without);
}

/* zeta = 2: delta(t) = v (e^(-a t) - e^(-b t))/(b - a), a, b = omega0 (2 -+ sqrt 3); it never bounces. Second order,
 * with omega0 dt = 0.01 and b dt = 0.04: below (b dt)^2 of the largest overlap. */
static void overdamped_contact(void **state)
{
    const double k = 1e5, m12 = 0.5 * 4.0 / 3.0 * PI * 2000 * 1e-9, omega = sqrt(k / m12), v = 0.1;
    const double a = omega * (2 - sqrt(3)), b = omega * (2 + sqrt(3)), dt = 0.01 / omega;
    char material[160];
    snprintf(material, sizeof material,
             "kn_n_per_m = %.17e; gamma_n_kg_per_s = %.17e; mu_s = 0.5; kt_n_per_m = 2e4; gamma_t_kg_per_s = 5.0;", k,
             4 * sqrt(k * m12));
    struct fixture_options options = {.dimension = 3, .dt_s = dt, .material = material};
    struct fixture f = fixture_pair(&options, 0, v);
    double largest = v / b;
    (void)state;
    for (int n = 0; n < 1000; n++) {
        double t = f.sample->time_s;
        /* no spring without overlap: the first step is without force, an error of b dt to start with */
        assert_close("overlap", fixture_overlap(&f), v * (exp(-a * t) - exp(-b * t)) / (b - a), 2 * b * dt * largest);
        fixture_steps(&f, 1);
    }
    assert_true(fixture_overlap(&f) > 0);
    fixture_close(&f);
}

/* The step from 0.1 to 1 of 2 sqrt(m/k) of the two smallest spheres. Up to 0.2 the ledger closes to 1 %; beyond, a
 * sphere with many contacts is too stiff at some point: then the run ends as unstable, or what is measured is finite.
 */
static void steps_up_to_the_critical(void **state)
{
    static const double fraction[] = {0.1, 0.2, 0.4, 0.7, 1.0};
    const double m12 = 0.5 * 4.0 / 3.0 * PI * 2000 * 27e-9, critical = 2 * sqrt(m12 / 5000);
    (void)state;
    for (int k = 0; k < 5; k++) {
        char dt[64];
        snprintf(dt, sizeof dt, "stages.0.dt_s=%.17e", fraction[k] * critical);
        const char *const overrides[] = {dt, "stages.0.material.mu_s=0.3", NULL};
        struct fixture f = open_scene(quick, overrides);
        struct measurement m = {0};
        enum status status = try_run(&f, steps_of(&f, 1));
        if (status == STATUS_OK)
            status = measure(sample_complete(f.sample), &m);
        print_message("dt %.1f of critical: %s, residual %.2g of the work\n", fraction[k],
                      status == STATUS_OK ? "ran" : status_message(), m.residual_j / f.sample->ledger.work_walls);
        assert_true(status == STATUS_OK || status == STATUS_UNSTABLE);
        if (fraction[k] <= 0.2)
            assert_true(status == STATUS_OK && fabs(m.residual_j) < 0.01 * f.sample->ledger.work_walls);
        fixture_close(&f);
    }
}

/* Mass and damping of all walls of the first stage. */
static struct fixture with_walls(const char *mass, const char *damping, const char *pressure)
{
    char text[9][80];
    const char *overrides[10] = {NULL};
    for (int c = 0; c < 3; c++) {
        snprintf(text[3 * c], sizeof *text, "walls.%c.mass_kg=%s", "xyz"[c], mass);
        snprintf(text[3 * c + 1], sizeof *text, "walls.%c.damping_kg_per_s=%s", "xyz"[c], damping);
        snprintf(text[3 * c + 2], sizeof *text, "walls.%c.pressure_pa=%s", "xyz"[c], pressure);
    }
    for (int k = 0; k < 9; k++)
        overrides[k] = text[k];
    return open_scene(quick, overrides);
}

/* Without mass the wall follows force over damping: it arrives like the one with mass. With 1e9 kg it stays: p A/m
 * t^2/2 = 4e-9 m after 1 s. */
static void wall_masses(void **state)
{
    (void)state;
    struct fixture none = with_walls("0.0", "32.0", "1000.0"), tiny = with_walls("1e-9", "32.0", "1000.0");
    struct fixture huge = with_walls("1e9", "32.0", "1000.0");
    struct measurement m;
    double length = sample_box_length_m(huge.sample, 0);
    fixture_run(&none, steps_of(&none, 1));
    fixture_run(&tiny, steps_of(&tiny, 1));
    fixture_run(&huge, steps_of(&huge, 1));
    for (int c = 0; c < 3; c++) { /* at rest but for the last creep without friction */
        must(measure(sample_complete(none.sample), &m));
        assert_close("massless wall", m.stress_wall_pa[c], 1000, 10);
        must(measure(sample_complete(tiny.sample), &m));
        assert_close("light wall", m.stress_wall_pa[c], 1000, 10);
    }
    assert_close("heavy wall", sample_box_length_m(huge.sample, 0), length, 1e-7);
    must(measure(sample_complete(huge.sample), &m));
    fixture_close(&none);
    fixture_close(&tiny);
    fixture_close(&huge);
}

/* Nothing holds a wall that is too light for its undamped contacts: it must fail with a reason, not run on in NaN. */
static void light_undamped_walls(void **state)
{
    struct fixture f = with_walls("1e-7", "0.0", "1000.0");
    (void)state;
    enum status status = try_run(&f, steps_of(&f, 1));
    print_message("walls of 1e-7 kg: %s\n", status == STATUS_OK ? "ran" : status_message());
    assert_true(status != STATUS_OK && status_message()[0]);
    fixture_close(&f);
}

/* One sphere in a box: until it is touched nothing holds the walls. They stop at it, force pressure times area; with
 * very light walls the blow is too hard and must end in an error. */
static void almost_empty_box(void **state)
{
    static const char *const one[] = {"sample.count=1", "stages.0.duration_s=4", NULL};
    static const char *const light[] = {"sample.count=1",         "stages.0.duration_s=4",
                                        "walls.x.mass_kg=1e-6",   "walls.x.damping_kg_per_s=0",
                                        "walls.x.opposite=fixed", NULL};
    struct fixture f = open_scene(quick, one);
    struct measurement m;
    (void)state;
    fixture_run(&f, steps_of(&f, 1));
    must(measure(sample_complete(f.sample), &m));
    for (int c = 0; c < 3; c++)
        assert_close("one sphere carries the walls", m.stress_wall_pa[c], 1000, 1);
    fixture_close(&f);
    f = open_scene(quick, light);
    enum status status = try_run(&f, steps_of(&f, 1));
    print_message("light walls on an empty box: %s\n", status == STATUS_OK ? "ran" : status_message());
    assert_true(status == STATUS_OK || status == STATUS_UNSTABLE || status == STATUS_FORMAT);
    fixture_close(&f);
}

/* The pressure falls from 1000 to 1e-3 N/m^2: contacts open, nothing divides by zero, and what the sample gives back is
 * accounted for. */
static void pressure_to_zero(void **state)
{
    static const char *const overrides[] = {"stages.1.walls.x.pressure_pa=1e-3", "stages.1.walls.y.pressure_pa=1e-3",
                                            "stages.1.walls.z.pressure_pa=1e-3", NULL};
    struct fixture f = open_scene(quick, overrides);
    struct measurement m;
    (void)state;
    fixture_run(&f, steps_of(&f, 1) + 1);
    assert_int_equal(f.sample->stage, 1);
    double stored = f.sample->ledger.elastic_start;
    fixture_run(&f, steps_of(&f, 2));
    must(measure(sample_complete(f.sample), &m));
    print_message("at 1e-3 Pa: %.3f contacts per sphere, %.2f rattlers, elastic energy %.2g of before\n",
                  m.coordination, m.rattler_fraction, (m.elastic_normal_j + m.elastic_tangential_j) / stored);
    assert_true(m.elastic_normal_j + m.elastic_tangential_j < 1e-3 * stored);
    assert_true(fabs(m.residual_j) < 1e-3 * stored);
    assert_true(m.rattler_fraction >= 0 && m.rattler_fraction <= 1);
    fixture_close(&f);
}

/* 20 % in 0.05 s, an inertial number near 0.1: no longer quasi-static, but the ledger still closes to 1 % (contacts are
 * hit harder and open within a step, which costs first order there). */
static void fast_straining(void **state)
{
    static const char *const overrides[] = {"stages.1.walls.z.mode=strain", "stages.1.walls.z.strain=0.2",
                                            "stages.1.walls.z.frequency_hz=10", "stages.1.duration_s=0.05", NULL};
    struct fixture f = open_scene(quick, overrides);
    struct measurement m;
    (void)state;
    fixture_run(&f, steps_of(&f, 1) + 1250);
    must(measure(sample_complete(f.sample), &m));
    assert_true(m.inertial_number > 1e-2);
    print_message("inertial number %.2g, residual %.2g of the work\n", m.inertial_number,
                  m.residual_j / f.sample->ledger.work_walls);
    fixture_run(&f, steps_of(&f, 2));
    must(measure(sample_complete(f.sample), &m));
    assert_true(fabs(m.residual_j) < 0.01 * f.sample->ledger.work_walls);
    assert_close("strain", m.strain[2], 0.2, 1e-9);
    fixture_close(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ledger_of_cycles),   cmocka_unit_test(no_friction_is_frictionless),
        cmocka_unit_test(overdamped_contact), cmocka_unit_test(steps_up_to_the_critical),
        cmocka_unit_test(wall_masses),        cmocka_unit_test(light_undamped_walls),
        cmocka_unit_test(almost_empty_box),   cmocka_unit_test(pressure_to_zero),
        cmocka_unit_test(fast_straining),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
