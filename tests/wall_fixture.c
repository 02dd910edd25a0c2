#include "wall_fixture.h"
#include "common/scene_file.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

enum { FIXTURE_STAGES = 4 }; /* room for what tests add */

struct scene *fixture_scene(int dimension)
{
    static const char format[] =
        "dimension = %d;\n"
        "sample = { count = 1; radius_min_m = 0.001; radius_max_m = 0.001; density_kg_per_m3 = 2000.0; };\n"
        "material = { kn_n_per_m = 1.0; };\n"
        "stages = ( { name = \"a\"; dt_s = 1e-3; duration_s = 1.0; } );\n";
    char text[sizeof format + 16];
    struct scene *scene = calloc(1, sizeof *scene);
    assert_non_null(scene);
    snprintf(text, sizeof text, format, dimension);
    if (scene_parse(scene, text, "fixture") != STATUS_OK)
        fail_msg("%s", status_message());
    scene->stage = realloc(scene->stage, FIXTURE_STAGES * sizeof *scene->stage);
    assert_non_null(scene->stage);
    return scene;
}

void fixture_scene_free(struct scene *scene)
{
    scene_free(scene);
    free(scene);
}

const char *fixture_scene_text(void)
{
    return "dimension = 2;\n"
           "sample = { count = 1; radius_min_m = 0.001; radius_max_m = 0.001; density_kg_per_m3 = 2000.0; };\n"
           "material = { kn_n_per_m = 1.0; };\n"
           "walls = { x = { mode = \"stress\"; pressure_pa = 500.0; mass_kg = 1e-2; damping_kg_per_s = 1.0; }; };\n"
           "coupling = { interval_steps = 3; };\n"
           "stages = (\n"
           "  { name = \"settle\"; dt_s = 1e-4; duration_s = 0.01; },\n"
           "  { name = \"test\"; dt_s = 2e-4; duration_s = 0.04;\n"
           "    walls = { z = { mode = \"strain\"; strain = 0.035; frequency_hz = 20.0; opposite = \"fixed\"; }; }; "
           "},\n"
           "  { name = \"cycles\"; dt_s = 1e-4; duration_s = 0.02;\n"
           "    walls = { x = { target = \"cosine\"; amplitude_pa = 100.0; period_s = 0.01; }; }; },\n"
           "  { name = \"kept\"; dt_s = 1e-4; until_cycles = 2; condition_steps = 50;\n"
           "    walls = { x = { mode = \"coupled\"; keep = \"p\"; };\n"
           "              z = { mode = \"strain\"; course = \"cosine\"; strain = 0.01; frequency_hz = 200.0; }; }; },\n"
           "  { name = \"undrained\"; dt_s = 1e-4;\n"
           "    walls = { x = { mode = \"coupled\"; keep = \"volume\"; };\n"
           "              z = { mode = \"strain\"; course = \"rate\"; strain = 0.01; rate_per_s = 1.0; }; }; } );\n";
}

struct wall_state fixture_state(int n_walls, double length_m)
{
    struct wall_state state = {.stage = -1, .n_walls = n_walls};
    for (int wall = 1; wall < n_walls; wall += 2)
        state.position_m[wall] = state.stage_position_m[wall] = length_m;
    return state;
}

void fixture_advance(const struct scene *scene, const struct wall_command *command, struct wall_state *state)
{
    double dt_s = scene->stage[command->stage].dt_s;
    double h = command->n_steps * dt_s;
    if (state->stage != command->stage) {
        state->stage = command->stage;
        state->stage_step = 0;
        for (int wall = 0; wall < state->n_walls; wall++)
            state->stage_position_m[wall] = state->position_m[wall];
    }
    for (int wall = 0; wall < state->n_walls; wall++) {
        double v = command->velocity_m_per_s[wall], a = command->acceleration_m_per_s2[wall];
        state->position_m[wall] = command->position_m[wall] + v * h + 0.5 * a * h * h;
        state->velocity_m_per_s[wall] = v + 0.5 * a * h;
        state->acceleration_m_per_s2[wall] = a;
    }
    state->step += command->n_steps;
    state->command_step = state->step;
    state->stage_step += command->n_steps;
    state->stage_time_s = (double)state->stage_step * dt_s;
    state->time_s += h;
    state->interval_s = h;
}

void fixture_springs(struct wall_state *state, double k_n_per_m, double length_m)
{
    for (int wall = 0; wall < state->n_walls; wall += 2) {
        state->force_n[wall] = k_n_per_m * state->position_m[wall];
        state->force_n[wall + 1] = k_n_per_m * (length_m - state->position_m[wall + 1]);
    }
}
