/* prepare = { ... }: dense and loose samples at a pressure, and a solid fraction. */
#include "sim_fixture.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/scene_file.h"
#include "sim/run/checkpoint.h"
#include "sim/run/run.h"

static const double PRESSURE_PA = 1000;

static struct scene *scene_of(const char *prepare)
{
    char text[2048];
    snprintf(text, sizeof text,
             "dimension = 3; seed = 5;\n"
             "sample = { count = 216; initial = \"random\"; radius_min_m = 0.8e-3; radius_max_m = 1.2e-3;\n"
             "  density_kg_per_m3 = 2000.0; };\n"
             "material = { kn_n_per_m = 2e3; gamma_n_kg_per_s = 0.05; mu_s = 0.5; kt_n_per_m = 8e2; wall_friction = "
             "0.0; };\n"
             "coupling = { scheme = \"compensated\"; interval_steps = 4; };\n"
             "prepare = { %s };\n"
             "stages = ( { name = \"rest\"; duration_s = 1e-4; } );\n",
             prepare);
    return fixture_scene_of(text);
}

struct outcome {
    double solid_fraction, stress_pa[3];
};

/* Runs the scene and looks at its last checkpoint. */
static struct outcome outcome_of(struct scene *scene)
{
    char folder[] = "/tmp/shakedown-prepare-XXXXXX", path[64], of_stage[400];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/checkpoint.h5", folder);
    const struct run_options options = {.in_process = true, .checkpoint = path};
    const enum status status = run_scene(scene, &options);
    if (status != STATUS_OK && status != STATUS_DOUBTFUL)
        fail_msg("%s", status_message());
    struct checkpoint_content *content;
    must(checkpoint_load_sample(&content, path));
    const struct sample *sample = content->sample;
    struct outcome outcome = {0};
    double volume = 1;
    for (int c = 0; c < 3; c++)
        volume *= sample_box_length_m(sample, c);
    for (int c = 0; c < 3; c++)
        outcome.stress_pa[c] = 0.5 * (fabs(sample->walls[2 * c].force) + fabs(sample->walls[2 * c + 1].force)) *
                               sample_box_length_m(sample, c) / volume;
    outcome.solid_fraction = particles_solid_volume(&sample->particles) / volume;
    checkpoint_content_free(content);
    assert_int_equal(unlink(path), 0);
    for (int k = 0; k < scene->n_stages; k++) {
        snprintf(of_stage, sizeof of_stage, "%s/checkpoint-%s.h5", folder, scene->stage[k].name);
        assert_int_equal(unlink(of_stage), 0);
    }
    assert_int_equal(rmdir(folder), 0);
    return outcome;
}

/* The last condition is a stress within 1e-3; in the 1e-4 s after it, with walls at rest and E_kin/E_el below 1e-6, it
 * moves by less than the square root of that. */
static void dense_is_denser_than_loose_at_one_pressure(void **state)
{
    static const char *const how[] = {"to = \"dense\"; pressure_pa = 1000.0;", "to = \"loose\"; pressure_pa = 1000.0;"};
    double fraction[2];
    (void)state;
    for (int k = 0; k < 2; k++) {
        struct scene *scene = scene_of(how[k]);
        const struct outcome outcome = outcome_of(scene);
        for (int c = 0; c < 3; c++)
            assert_close("stress", relative(outcome.stress_pa[c], PRESSURE_PA), 0, 2e-3);
        fraction[k] = outcome.solid_fraction;
        print_message("%s solid fraction %.4f\n", how[k], fraction[k]);
        fixture_scene_free(scene);
    }
    /* 216 spheres between smooth walls: both below the 0.64 and 0.55 of large packings, some 0.04 apart */
    assert_true(fraction[0] > fraction[1] + 0.02);
}

/* Walls are moved to the volume: but for rounding of 1e5 steps. */
static void a_solid_fraction_is_reached(void **state)
{
    struct scene *scene = scene_of("to = \"solid_fraction\"; solid_fraction = 0.57; pressure_pa = 1000.0;");
    (void)state;
    assert_close("solid fraction", outcome_of(scene).solid_fraction, 0.57, 1e-9);
    fixture_scene_free(scene);
}

/* What is recorded are the stages themselves. */
static void stages_are_ordinary_ones(void **state)
{
    struct scene *scene = scene_of("to = \"dense\"; pressure_pa = 1000.0; mu_s = 0.1; dt_s = 1e-6;");
    char *text = NULL;
    size_t size = 0;
    (void)state;
    assert_int_equal(scene->n_stages, 3);
    assert_string_equal(scene->stage[0].name, "prepare-compress");
    assert_string_equal(scene->stage[1].name, "prepare-settle");
    assert_true(scene->stage[0].material.mu_s == 0.1 && scene->stage[1].material.mu_s == 0.5);
    assert_true(scene->stage[0].dt_s == 1e-6 && scene->stage[2].axis[AXIS_X].mode == WALL_FIXED);
    assert_non_null(strstr(scene->prepared, "name = \"prepare-settle\";"));
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    scene_print(out, scene);
    assert_int_equal(fclose(out), 0);
    struct scene *again = fixture_scene_of(text);
    assert_int_equal(again->n_stages, 3);
    assert_null(again->prepared);
    assert_memory_equal(&again->stage[1].axis, &scene->stage[1].axis, sizeof again->stage[1].axis);
    fixture_scene_free(again);
    fixture_scene_free(scene);
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stages_are_ordinary_ones),
        cmocka_unit_test(dense_is_denser_than_loose_at_one_pressure),
        cmocka_unit_test(a_solid_fraction_is_reached),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
