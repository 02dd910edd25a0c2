/* Scene files: numbers as they are written, groups of stages, and the way back from the effective configuration. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/auto_time_step.h"
#include "common/config_literals.h"
#include "common/scene_file.h"

static const char head[] =
    "dimension = 2;\n"
    "sample = { count = 1; radius_min_m = 1e-3; radius_max_m = 1e-3; density_kg_per_m3 = 2000; };\n"
    "material = { kn_n_per_m = 1e5; };\n";

static struct scene *parsed(const char *text)
{
    struct scene *scene = calloc(1, sizeof *scene);
    assert_non_null(scene);
    if (scene_parse(scene, text, "text") != STATUS_OK)
        fail_msg("%s", status_message());
    return scene;
}

static struct scene *with_head(const char *rest)
{
    char text[4096];
    assert_true(snprintf(text, sizeof text, "%s%s", head, rest) < (int)sizeof text);
    return parsed(text);
}

static void dispose(struct scene *scene)
{
    scene_free(scene);
    free(scene);
}

static void numbers_are_taken_exactly(void **unused)
{
    static const struct {
        const char *written, *read;
    } cases[] = {
        {"a = 5000000000;", "a = 5000000000L;"},
        {"a = -2147483649;", "a = -2147483649L;"},
        {"a = 2147483647;", "a = 2147483647;"},
        {"a = 9223372036854775807L;", "a = 9223372036854775807L;"},
        {"a = 0xFFFFFFFF;", "a = 4294967295L;"},
        {"a = [1, 2.5, 5000000000];", "a = [1.0, 2.5, 5000000000.0];"},
        {"a = (1, 2.5);", "a = (1, 2.5);"},
        {"a1e999 = 1e-3; // 1e999\n# 5000000000\n/* . */ b = \"\\\" 1e999\";",
         "a1e999 = 1e-3; // 1e999\n# 5000000000\n/* . */ b = \"\\\" 1e999\";"},
    };
    (void)unused;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        char *checked;
        assert_int_equal(config_literals(cases[k].written, "text", &checked), STATUS_OK);
        assert_string_equal(checked, cases[k].read);
        free(checked);
    }
    struct scene *scene = with_head("seed = 3000000000;"
                                    "stages = ( { name = \"a\"; dt_s = 1e-6; duration_s = 3000000000e-9;"
                                    " material = { kn_n_per_m = 5000000000; }; } );");
    assert_true(scene->seed == 3000000000);
    assert_true(scene->stage[0].material.kn_n_per_m == 5e9);
    dispose(scene);
}

/* What stands at once behind a number is part of it: written anew beside each other, 1e4 and +04 would be 1e404. */
static void numbers_end_where_they_end(void **unused)
{
    static const char *const wrong[] = {"a = 1e4+0+4;", "a = 1e4+0;",    "a = 3L5;",    "a = 5-3;",
                                        "a = 1.5.5;",   "a = 1.5e3e2;",  "a = 2\"b\";", "a = 7b;",
                                        "a = 0x1fg;",   "a = [1, 2+3];", "a = 1e4L;",   "a = 1e;"};
    static const char *const right[] = {"a = 1;",    "a = (1,2);", "a = {b = 1;}",  "a = [1]",
                                        "a = 1// b", "a = 1#",     "a = 1/* 2 */;", "a = 1\n"};
    (void)unused;
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
        char *checked;
        assert_int_equal(config_literals(wrong[k], "text", &checked), STATUS_CONFIG);
        assert_null(checked);
        assert_non_null(strstr(status_message(), "text:1: "));
        assert_non_null(strstr(status_message(), "is not a number"));
    }
    for (size_t k = 0; k < sizeof right / sizeof *right; k++) {
        char *checked;
        assert_int_equal(config_literals(right[k], "text", &checked), STATUS_OK);
        free(checked);
    }
}

/* Radius 1 mm, 2000 kg/m^3, k = 1e5 N/m: m = 8.378e-6 kg, t_c = pi sqrt(m/(2 k)) = 2.0333e-5 s, a twentieth
 * is 1.01665e-6 s. Uniform radii of 0.5 to 1.5 mm: the mean mass is 1.047e-5 kg, a twentieth 1.1366e-6 s; the smallest
 * one 1.047e-6 kg, a seventh 1.0269e-6 s, which is less. gamma = 10 kg/s bears about 1/lambda, lambda = 1.5 gamma (1/m
 * + 1/<m>) = 1.576e7 /s, a third of it 2.115e-8 s. */
static void a_time_step_follows_from_the_scene(void **unused)
{
    static const char *const given[] = {"dt_s = \"auto\"; ", ""};
    struct scene *wide = parsed("dimension = 2; material = { kn_n_per_m = 1e5; };\n"
                                "sample = { count = 1; radius_min_m = 0.5e-3; radius_max_m = 1.5e-3; "
                                "density_kg_per_m3 = 2000; };\n"
                                "stages = ( { name = \"a\"; duration_s = 1e-3; } );");
    struct scene_material material = {.kn_n_per_m = 1e5};
    (void)unused;
    for (int k = 0; k < 2; k++) {
        char text[256];
        snprintf(text, sizeof text, "stages = ( { name = \"a\"; %sduration_s = 1e-3; } );", given[k]);
        struct scene *scene = with_head(text);
        assert_true(fabs(scene->stage[0].dt_s - 1.01665e-6) < 1e-10);
        dispose(scene);
    }
    assert_true(fabs(time_step_auto_s(&wide->sample, &material, 0) - 1.0269e-6) < 1e-10);
    material.gamma_n_kg_per_s = 10;
    assert_true(fabs(time_step_auto_s(&wide->sample, &material, 0) - 2.115e-8) < 2e-11);
    assert_true(time_step_auto_s(&wide->sample, &(struct scene_material){0}, 0) == 0);
    dispose(wide);
}

/* A stiff rolling spring is what bears the shortest step, whatever the normal law: radius 1 mm, m = 8.378e-6 kg,
 * k_r = 1e9 N/m. Along a line a packing has 2 contacts on m/2, and a spring at the lever of the radius acts on 2/5 of
 * the mass: omega^2 = 2.5 * 4 k_r/m (kt, 5e3 times as soft, at 3.5), and a third of 2/omega is 1.929e-8 s. */
static void stiff_rolling_shortens_the_time_step(void **unused)
{
    static const char *const laws[] = {"law = \"linear\"; kn_n_per_m = 1e5; kt_n_per_m = 2e5;",
                                       "law = \"hertz\"; youngs_modulus_pa = 1e8; poisson_ratio = 0.25;"};
    (void)unused;
    for (int k = 0; k < 2; k++)
        for (int torsion = 0; torsion < 2; torsion++) {
            char text[1024];
            double step_s[2];
            for (int on = 0; on < 2; on++) {
                snprintf(text, sizeof text,
                         "dimension = 3; sample = { count = 1; radius_min_m = 1e-3; radius_max_m = 1e-3; "
                         "density_kg_per_m3 = 2000; };\n"
                         "material = { %s mu_s = 0.3; %s = %g; %s = 1e9; };\n"
                         "stages = ( { name = \"a\"; duration_s = 1e-3; } );",
                         laws[k], torsion ? "mu_torsion" : "mu_rolling", on ? 0.1 : 0.0,
                         torsion ? "ko_n_per_m" : "kr_n_per_m");
                struct scene *scene = parsed(text);
                step_s[on] = scene->stage[0].dt_s;
                dispose(scene);
            }
            assert_true(step_s[0] > 5e-7); /* it does not count where nothing resists */
            assert_true(fabs(step_s[1] / 1.929e-8 - 1) < 1e-3);
        }
}

static void groups_are_repeated(void **unused)
{
    static const char *const names[] = {"start", "up.1", "down.1", "up.2", "down.2", "up.3", "down.3", "end"};
    struct scene *scene = with_head("stages = ( { name = \"start\"; dt_s = 1e-6; duration_s = 1e-3; },\n"
                                    "{ repeat = 3; stages = (\n"
                                    "  { name = \"up\"; dt_s = 1e-6; duration_s = 2e-3; },\n"
                                    "  { name = \"down\"; dt_s = 2e-6; duration_s = 4e-3; } ); },\n"
                                    "{ name = \"end\"; dt_s = 1e-6; duration_s = 8e-3; } );");
    (void)unused;
    assert_int_equal(scene->n_stages, 8);
    for (int k = 0; k < 8; k++) {
        assert_string_equal(scene->stage[k].name, names[k]);
        assert_int_equal(scene_stage_find(scene, names[k]), k);
    }
    assert_true(scene->stage[6].dt_s == 2e-6 && scene->stage[5].duration_s == 2e-3);
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    scene_print(out, scene);
    assert_int_equal(fclose(out), 0);
    struct scene *again = parsed(text);
    assert_int_equal(again->n_stages, 8);
    for (int k = 0; k < 8; k++) {
        assert_true(again->stage[k].line > 0 && scene->stage[k].line > 0);
        again->stage[k].line = scene->stage[k].line; /* other texts */
    }
    assert_memory_equal(again->stage, scene->stage, 8 * sizeof *scene->stage);
    free(text);
    dispose(again);
    dispose(scene);
}

/* A pressure of 0 that is given is a free wall; one that is not given is refused. As recorded, it must be given again.
 */
static void a_free_wall_stays_one(void **unused)
{
    struct scene *scene = with_head("stages = ( { name = \"a\"; dt_s = 1e-6; duration_s = 1e-3;"
                                    " walls = { x = { mode = \"stress\"; pressure_pa = 0.0; mass_kg = 1.0; }; }; } );");
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    (void)unused;
    assert_non_null(out);
    scene_print(out, scene);
    assert_int_equal(fclose(out), 0);
    assert_non_null(strstr(text, "pressure_pa = 0.0"));
    dispose(parsed(text));
    free(text);
    dispose(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_are_taken_exactly),
        cmocka_unit_test(numbers_end_where_they_end),
        cmocka_unit_test(a_time_step_follows_from_the_scene),
        cmocka_unit_test(stiff_rolling_shortens_the_time_step),
        cmocka_unit_test(groups_are_repeated),
        cmocka_unit_test(a_free_wall_stays_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
