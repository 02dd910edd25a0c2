#include "sim_fixture.h"
#include "common/scene_file.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sim/measure/measure.h"
#include "sim/sample/stage.h"
#include "sim/sample/time_step.h"
#include "sim/sample/wall_state.h"
#include "wallctl/control_law.h"

void must(enum status status)
{
    if (status != STATUS_OK)
        fail_msg("%s: %s", status_text(status), status_message());
}

double relative(double value, double expected)
{
    return fabs(value - expected) / fabs(expected);
}

void assert_close(const char *what, double value, double expected, double tolerance)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%s: %.17g instead of %.17g, off by %.3g, allowed %.3g", what, value, expected, value - expected,
                 tolerance);
}

struct scene *fixture_scene_of(const char *text)
{
    struct scene *scene = calloc(1, sizeof *scene);
    assert_non_null(scene);
    must(scene_parse(scene, text, "fixture"));
    return scene;
}

void fixture_scene_free(struct scene *scene)
{
    scene_free(scene);
    free(scene);
}

struct fixture fixture_from_text(const char *text)
{
    struct fixture fixture = {.scene = fixture_scene_of(text)};
    must(sample_create(&fixture.sample, fixture.scene));
    return fixture;
}

struct fixture fixture_open(const struct fixture_options *options)
{
    char text[4096];
    int length = snprintf(
        text, sizeof text,
        "dimension = %d;\n"
        "sample = { count = %d; radius_min_m = 1e-3; radius_max_m = 1e-3; density_kg_per_m3 = 2000.0;\n"
        "  gap_ratio = 100.0; };\n"
        "material = { %s };\n%s\n"
        "stages = ( { name = \"a\"; dt_s = %.17e; duration_s = 1.0; } );\n",
        options->dimension, options->count, options->material, options->more ? options->more : "", options->dt_s);
    assert_true(length > 0 && length < (int)sizeof text);
    return fixture_from_text(text);
}

void fixture_close(struct fixture *fixture)
{
    sample_free(fixture->sample);
    fixture_scene_free(fixture->scene);
}

void fixture_start(struct fixture *fixture)
{
    struct sample *sample = fixture->sample;
    struct wall_command command = {.n_steps = INT_MAX, .n_walls = sample->n_walls};
    particles_set_mass(&sample->particles, fixture->scene->sample.density_kg_per_m3);
    must(sample_build_lists(sample));
    for (int w = 0; w < sample->n_walls; w++)
        command.position_m[w] = sample->walls[w].x;
    must(sample_command(sample, &command));
}

void fixture_steps(struct fixture *fixture, int n)
{
    for (int k = 0; k < n; k++)
        must(sample_step(fixture->sample));
}

void fixture_run(struct fixture *fixture, int64_t n_steps)
{
    must(fixture_try(fixture, n_steps));
}

enum status fixture_try(struct fixture *fixture, int64_t n_steps)
{
    struct sample *sample = fixture->sample;
    struct wall_command command = {0};
    while (sample->step < n_steps) {
        struct wall_state state;
        sample_wall_state(sample, &state);
        state.energy_step = -1;   /* no condition is met on energies that were not measured */
        if (command.n_steps == 0) /* not asked for ahead */
            TRY(wallctl_law(fixture->scene, &state, &command));
        if (command.finished)
            return STATUS_OK;
        TRY(sample_command(sample, &command));
        const int interval = command.n_steps, ahead = coupling_ahead_steps(&fixture->scene->coupling, interval);
        command.n_steps = 0;
        for (int k = 0; k < interval - ahead; k++)
            TRY(sample_step(sample));
        if (ahead > 0) {
            if (ahead < interval)
                sample_wall_state(sample, &state);
            sample_wall_state_ahead(sample, &state);
            state.energy_step = -1;
            TRY(wallctl_law(fixture->scene, &state, &command));
        }
        for (int k = 0; k < ahead; k++)
            TRY(sample_step(sample));
    }
    return STATUS_OK;
}

struct fixture fixture_pair(const struct fixture_options *options, double overlap_m, double speed_m_per_s)
{
    struct fixture_options two = *options;
    two.count = 2;
    struct fixture fixture = fixture_open(&two);
    struct particles *p = &fixture.sample->particles;
    double half = 0.5 * (p->radius[0] + p->radius[1] - overlap_m);
    for (int i = 0; i < 2; i++) {
        double side = i == 0 ? -1 : 1;
        for (int c = 0; c < p->dimension; c++)
            p->x[c][i] = 0.5 * (fixture.sample->walls[2 * c].x + fixture.sample->walls[2 * c + 1].x);
        p->x[0][i] += side * half;
        p->v[0][i] = -0.5 * side * speed_m_per_s;
    }
    fixture_start(&fixture);
    return fixture;
}

double fixture_overlap(const struct fixture *fixture)
{
    const struct particles *p = &fixture->sample->particles;
    double d2 = 0;
    for (int c = 0; c < p->dimension; c++)
        d2 += (p->x[c][0] - p->x[c][1]) * (p->x[c][0] - p->x[c][1]);
    return p->radius[0] + p->radius[1] - sqrt(d2);
}

double fixture_approach(const struct fixture *fixture)
{
    const struct particles *p = &fixture->sample->particles;
    return p->v[0][0] - p->v[0][1];
}
