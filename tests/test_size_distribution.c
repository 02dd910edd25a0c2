/* Radii: grading curves, lognormal radii, and what follows from them. */
#include "sim_fixture.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/scene_file.h"
#include "common/size_distribution.h"
#include "sim/run/sample_source.h"

static const char table[] = "size_distribution = \"table\"; diameters_m = [0.063e-3, 0.1e-3, 0.2e-3, 0.4e-3, 0.63e-3];"
                            " passing_by_mass = [0.0, 0.05, 0.35, 0.9, 1.0];";

static struct fixture opened(int dimension, int count, int seed, const char *sample)
{
    char text[1024];
    snprintf(text, sizeof text,
             "dimension = %d; seed = %d;\nsample = { count = %d; initial = \"random\"; solid_fraction = 0.01; "
             "density_kg_per_m3 = 2650.0; %s };\nmaterial = { kn_n_per_m = 1e5; };\n"
             "stages = ( { name = \"a\"; duration_s = 1e-3; } );\n",
             dimension, seed, count, sample);
    struct fixture f = {.scene = fixture_scene_of(text)};
    must(sample_from_scene(&f.sample, f.scene));
    return f;
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Mass of particles up to a diameter, over that of all. */
static double finer(const struct particles *p, double diameter_m)
{
    double sum = 0, all = 0;
    for (int i = 0; i < p->count; i++) {
        const double cube = pow(p->radius[i], 3);
        all += cube;
        sum += 2 * p->radius[i] <= diameter_m ? cube : 0;
    }
    return sum / all;
}

/* The part of the mass that is finer differs by at most one particle: that of the part of the number distribution in
 * which the diameter lies, as all parts below it are there in full. Its mass is that of a particle of at most the end
 * of the part; with the next particle's size, or the largest one's, as its bound. Rounding: 1e-9. */
static void grading_curves_are_kept_within_one_particle(void **state)
{
    static const int counts[] = {12, 60, 1000};
    (void)state;
    for (int k = 0; k < 6; k++) {
        struct fixture f = opened(2 + k / 3, counts[k % 3], 1, table);
        struct particles *p = &f.sample->particles;
        double total = 0;
        for (int i = 0; i < p->count; i++)
            total += pow(p->radius[i], 3);
        qsort(p->radius, (size_t)p->count, sizeof *p->radius, by_size);
        for (double d = 0.063e-3; d <= 0.63e-3; d *= 1.003) {
            int next = 0;
            while (next < p->count - 1 && 2 * p->radius[next] <= d)
                next++;
            const double one = pow(p->radius[next + 1 < p->count ? next + 1 : next], 3) / total;
            assert_true(fabs(finer(p, d) - size_table_passing(&f.scene->sample, d)) <= one + 1e-9);
        }
        assert_true(p->radius[0] >= 0.5 * 0.063e-3 && p->radius[p->count - 1] <= 0.5 * 0.63e-3);
        fixture_close(&f);
    }
}

/* Each particle has the mass of its part, so that the mean of the cubes is that of the curve; the mean radius is that
 * of radii within the parts, which one radius each overestimates, with 1000 parts by less than 1e-3. Seeds change the
 * order alone. */
static void sizes_follow_from_the_curve(void **state)
{
    struct fixture a = opened(3, 1000, 1, table), b = opened(3, 1000, 2, table);
    double sum = 0, cubes = 0;
    (void)state;
    for (int i = 0; i < 1000; i++) {
        assert_true(a.sample->particles.radius[i] == b.sample->particles.radius[i]); /* random starts are by size */
        sum += a.sample->particles.radius[i] / 1000;
        cubes += pow(a.sample->particles.radius[i], 3) / 1000;
    }
    assert_close("mean of the cubes", relative(cubes, a.scene->sample.mean_cube_m3), 0, 1e-9);
    assert_close("mean radius", relative(sum, a.scene->sample.mean_radius_m), 0, 1e-3);
    assert_close("d50", size_table_diameter_m(&a.scene->sample, 0.5), 0.2e-3 * pow(2, 0.15 / 0.55), 1e-12);
    assert_close("passing at d50", size_table_passing(&a.scene->sample, 0.2e-3 * pow(2, 0.15 / 0.55)), 0.5, 1e-12);
    fixture_close(&a);
    fixture_close(&b);
}

/* Means of N = 20000 draws scatter by sd/sqrt(N); five of these are allowed. */
static void lognormal_radii_have_their_moments(void **state)
{
    enum { N = 20000 };
    struct fixture f = opened(2, N, 3,
                              "size_distribution = \"lognormal\"; radius_median_m = 1e-3; radius_log_sd = 0.4; "
                              "radius_min_m = 0.4e-3; radius_max_m = 2e-3;");
    const struct scene_sample *s = &f.scene->sample;
    const double *radius = f.sample->particles.radius;
    double sum = 0, squares = 0, cubes = 0, sixths = 0;
    (void)state;
    for (int i = 0; i < N; i++) {
        assert_true(radius[i] >= s->radius_min_m && radius[i] <= s->radius_max_m);
        sum += radius[i] / N;
        squares += radius[i] * radius[i] / N;
        cubes += pow(radius[i], 3) / N;
        sixths += pow(radius[i], 6) / N;
    }
    assert_close("mean", sum, s->mean_radius_m, 5 * sqrt((squares - sum * sum) / N));
    assert_close("mean of the cubes", cubes, s->mean_cube_m3, 5 * sqrt((sixths - cubes * cubes) / N));
    /* cut, by more than the scatter: exp(0.4^2/2) = 1.083 without */
    assert_true(s->mean_radius_m < 1.05e-3);
    fixture_close(&f);
}

/* A table in a file is recorded as the two lists, and reads back as the same scene. */
static void tables_in_files_become_lists(void **state)
{
    char folder[] = "/tmp/shakedown-sizes-XXXXXX", path[128], scene_path[128], *text = NULL;
    size_t size = 0;
    (void)state;
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/sizes.csv", folder);
    snprintf(scene_path, sizeof scene_path, "%s/scene.cfg", folder);
    FILE *out = fopen(path, "w"), *scene_out = fopen(scene_path, "w");
    assert_true(out && scene_out);
    assert_true(fputs("passing,diameter\n0,1e-3\n0.3,2e-3\n1,4e-3\n", out) >= 0);
    assert_true(fputs("dimension = 3; sample = { count = 9; size_distribution = \"table\"; size_table = \"sizes.csv\"; "
                      "density_kg_per_m3 = 2650.0; }; material = { kn_n_per_m = 1e5; };\n"
                      "stages = ( { name = \"a\"; duration_s = 1e-3; } );\n",
                      scene_out) >= 0);
    assert_int_equal(fclose(out) + fclose(scene_out), 0);
    struct scene *scene = calloc(1, sizeof *scene);
    assert_non_null(scene);
    must(scene_load(scene, scene_path, NULL, 0));
    assert_true(scene->sample.radius_min_m == 0.5e-3 && scene->sample.radius_max_m == 2e-3);
    assert_true(scene->sample.size_table[0] == '\0' && scene->sample.passing_by_mass.value[1] == 0.3);
    FILE *memory = open_memstream(&text, &size);
    assert_non_null(memory);
    scene_print(memory, scene);
    assert_int_equal(fclose(memory), 0);
    struct scene *again = fixture_scene_of(text);
    assert_memory_equal(&again->sample, &scene->sample, sizeof again->sample);
    fixture_scene_free(again);
    fixture_scene_free(scene);
    free(text);
    assert_int_equal(unlink(path) + unlink(scene_path) + rmdir(folder), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(grading_curves_are_kept_within_one_particle),
        cmocka_unit_test(sizes_follow_from_the_curve),
        cmocka_unit_test(lognormal_radii_have_their_moments),
        cmocka_unit_test(tables_in_files_become_lists),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
