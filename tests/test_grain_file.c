/* Samples whose grains a table gives. */
#include "sim_fixture.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/grain_file.h"
#include "common/scene_file.h"
#include "sim/run/sample_source.h"

static char folder[] = "/tmp/shakedown-grains-XXXXXX";

static void write_file(const char *name, const char *text)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *out = fopen(path, "w");
    assert_non_null(out);
    assert_true(fputs(text, out) >= 0);
    assert_int_equal(fclose(out), 0);
}

/* The scene with a table of this text; `sample` goes into its group. */
static enum status scene_with(struct scene *scene, int dimension, const char *table, const char *sample)
{
    char text[2048], path[256];
    write_file("grains.csv", table);
    snprintf(
        text, sizeof text,
        "dimension = %d;\nsample = { initial = \"file\"; file = \"grains.csv\"; density_kg_per_m3 = 2000.0; %s };\n"
        "material = { kn_n_per_m = 1e5; kt_n_per_m = 2e4; mu_s = 0.5; };\n"
        "stages = ( { name = \"a\"; duration_s = 1e-3; } );\n",
        dimension, sample);
    write_file("scene.cfg", text);
    snprintf(path, sizeof path, "%s/scene.cfg", folder);
    return scene_load(scene, path, NULL, 0);
}

static struct fixture opened(int dimension, const char *table, const char *sample)
{
    struct fixture f = {.scene = calloc(1, sizeof *f.scene)};
    assert_non_null(f.scene);
    must(scene_with(f.scene, dimension, table, sample));
    must(sample_from_scene(&f.sample, f.scene));
    return f;
}

/* In any order of columns, with comments, spaces and line ends of other systems. */
static void grains_are_where_the_table_says(void **state)
{
    static const char table[] = "# of a scan\r\n radius , z,y,x,vz,omega_y,omega_x\r\n"
                                "1e-3,0.002,0.003,0.004,-0.5,7,8\r\n\r\n# the other\r\n0.5e-3,0.006,0.003,0.001,0,0,0";
    struct fixture f = opened(3, table, "box_min_m = [0.0, 0.0, -0.001]; box_max_m = [0.01, 0.02, 0.03];");
    const struct particles *p = &f.sample->particles;
    (void)state;
    assert_int_equal(p->count, 2);
    assert_true(p->x[0][0] == 0.004 && p->x[1][0] == 0.003 && p->x[2][0] == 0.002);
    assert_true(p->radius[0] == 1e-3 && p->radius[1] == 0.5e-3);
    assert_true(p->v[0][0] == 0 && p->v[2][0] == -0.5 && p->omega[0][0] == 8 && p->omega[1][0] == 7);
    assert_true(f.sample->walls[4].x == -0.001 && f.sample->walls[3].x == 0.02);
    assert_true(f.scene->sample.count == 2 && f.scene->sample.radius_min_m == 0.5e-3);
    assert_close("mean of the cubes", f.scene->sample.mean_cube_m3, 0.5 * (1e-9 + 0.125e-9), 1e-24);
    fixture_close(&f);
}

/* A spin about y turns the lowest point of a grain, at (0, 0, -a), towards -x: omega x r = (-omega a, 0, 0). Friction
 * of the floor then drives the grain towards +x, the same in both dimensions but for rounding in other orders: 1e-9. */
static void spin_means_the_same_in_both_dimensions(void **state)
{
    static const char *const box[] = {"box_min_m = [0.0, 0.0]; box_max_m = [0.01, 0.01];",
                                      "box_min_m = [0.0, -0.01, 0.0]; box_max_m = [0.01, 0.01, 0.01];"};
    double speed[2];
    (void)state;
    for (int d = 2; d <= 3; d++) {
        struct fixture f = opened(d, "x,y,z,radius,vz,omega_y\n0.005,0,0.001001,0.001,-0.1,100\n", box[d - 2]);
        fixture_run(&f, 300);
        speed[d - 2] = f.sample->particles.v[0][0];
        assert_true(speed[d - 2] > 0.01);
        fixture_close(&f);
    }
    assert_close("speeds after the contact", relative(speed[0], speed[1]), 0, 1e-9);
}

/* Without a box the outermost grains touch the walls; grains that touch, but for rounding, are no overlap. */
static void the_box_fits_by_itself(void **state)
{
    struct fixture f = opened(2, "x,z,radius\n0.01,0.01,0.01\n0.03,0.01,0.01\n0.05,0.01,0.01\n", "");
    (void)state;
    assert_true(f.sample->walls[0].x == 0 && f.sample->walls[1].x == 0.05 + 0.01);
    assert_true(f.sample->walls[2].x == 0 && f.sample->walls[3].x == 0.02);
    fixture_close(&f);
}

/* What is recorded names the content; it reads back without the file, and refuses another one. */
static void the_record_names_the_content(void **state)
{
    char hash[CONFIG_STRING_MAX], given[300], *text = NULL;
    size_t size = 0;
    (void)state;
    struct fixture f = opened(2, "x,z,radius\n0.01,0.01,0.01\n", "");
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    scene_print(out, f.scene);
    assert_int_equal(fclose(out), 0);
    snprintf(hash, sizeof hash, "%s", f.scene->sample.file_hash);
    fixture_close(&f);
    struct scene *again = fixture_scene_of(text);
    assert_string_equal(again->sample.file_hash, hash);
    assert_true(again->sample.count == 1);
    fixture_scene_free(again);
    free(text);
    snprintf(given, sizeof given, "file_hash = \"%s\";", hash);
    again = calloc(1, sizeof *again);
    assert_non_null(again);
    must(scene_with(again, 2, "x,z,radius\n0.01,0.01,0.01\n", given));
    write_file("grains.csv", "x,z,radius\n0.01,0.01,0.0100\n"); /* the same grain, in other bytes */
    struct sample *sample;
    assert_int_equal(sample_from_scene(&sample, again), STATUS_CONFIG);
    assert_non_null(strstr(status_message(), "its content has changed"));
    scene_free(again);
    assert_int_equal(scene_with(again, 2, "x,z,radius\n0.01,0.01,0.0100\n", given), STATUS_CONFIG);
    free(again);
}

/* Overlaps are taken where the scene says so. */
static void overlaps_are_taken_if_wanted(void **state)
{
    static const char table[] = "x,z,radius\n0.01,0.01,0.01\n0.0299,0.01,0.01\n"; /* by 1e-2 of the radius */
    struct scene *scene = calloc(1, sizeof *scene);
    struct sample *sample;
    (void)state;
    assert_non_null(scene);
    must(scene_with(scene, 2, table, "overlap_ratio = 0.009;"));
    assert_int_equal(sample_from_scene(&sample, scene), STATUS_CONFIG);
    scene_free(scene);
    free(scene);
    struct fixture f = opened(2, table, "overlap_ratio = 0.011;");
    assert_int_equal(f.sample->pairs.count, 1);
    fixture_close(&f);
}

static void limits_of_tables_are_errors(void **state)
{
    static const char long_line[CSV_LINE_MAX + 10] = {[0 ... CSV_LINE_MAX + 8] = ' '};
    struct scene *scene = calloc(1, sizeof *scene);
    (void)state;
    assert_non_null(scene);
    assert_int_equal(scene_with(scene, 2, long_line, ""), STATUS_CONFIG);
    assert_non_null(strstr(status_message(), "grains.csv:1: longer than 1024 characters"));
    assert_int_equal(scene_with(scene, 2, "", ""), STATUS_CONFIG);
    assert_non_null(strstr(status_message(), "empty"));
    assert_int_equal(scene_with(scene, 2, "x,x,z,radius\n", ""), STATUS_CONFIG);
    assert_non_null(strstr(status_message(), "two columns \"x\""));
    assert_int_equal(scene_with(scene, 2, "x,z,radius\n1,1,nan\n", ""), STATUS_CONFIG);
    assert_non_null(strstr(status_message(), "finite"));
    free(scene);
}

static int setup(void **state)
{
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int teardown(void **state)
{
    char path[256];
    (void)state;
    for (int k = 0; k < 2; k++) {
        snprintf(path, sizeof path, "%s/%s", folder, k ? "scene.cfg" : "grains.csv");
        (void)unlink(path);
    }
    return rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(grains_are_where_the_table_says), cmocka_unit_test(spin_means_the_same_in_both_dimensions),
        cmocka_unit_test(the_box_fits_by_itself),          cmocka_unit_test(the_record_names_the_content),
        cmocka_unit_test(overlaps_are_taken_if_wanted),    cmocka_unit_test(limits_of_tables_are_errors),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
