/* Checkpoints: a sample that was saved and restored at any step goes on with the same bits; scenes that start from a
 * prepared sample; files that are damaged, foreign or of another scene. */
#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "common/scene_file.h"
#include "sim/measure/measure.h"
#include "sim/run/checkpoint.h"
#include "sim/run/checkpoint_file.h"
#include "sim/run/sample_source.h"
#include "sim/sample/contact_state.h"
#include "sim/sample/stage.h"
#include "sim/sample/step_completion.h"
#include "sim/sample/time_step.h"
#include "sim/sample/wall_state.h"
#include "wallctl/control_law.h"

static const char path[] = "test_checkpoint.h5";

struct model {
    int dimension;
    const char *law; /* of the material, in libconfig syntax */
    double mu;
};

#define DASHPOTS   "gamma_n_kg_per_s = 0.1; kt_n_per_m = 2e4; gamma_t_kg_per_s = 0.02;"
#define LINEAR     "law = \"linear\"; kn_n_per_m = 1e5; " DASHPOTS
#define RESISTS    " mu_rolling = 0.1; kr_n_per_m = 2e4; gamma_r_kg_per_s = 0.01; mu_torsion = 0.05; ko_n_per_m = 1e4;"
#define ROLLING    LINEAR RESISTS
#define HYSTERETIC "law = \"hysteretic\"; k1_n_per_m = 5e4; k2_n_per_m = 1e5; kc_n_per_m = 5e4; " DASHPOTS
#define ELASTOPLASTIC                                                                                                  \
    "law = \"elastoplastic\"; k1_n_per_m = 5e4; kp_n_per_m = 1e5; phi_f = 0.05; kc_n_per_m = 2e4; " DASHPOTS
#define HERTZ "law = \"hertz\"; youngs_modulus_pa = 1e8; poisson_ratio = 0.25; restitution = 0.5;"

static const struct model models[] = {
    {2, LINEAR, 0.0}, {2, LINEAR, 0.4},     {2, HYSTERETIC, 0.0}, {2, HYSTERETIC, 0.4},    {3, LINEAR, 0.0},
    {3, LINEAR, 0.4}, {3, HYSTERETIC, 0.0}, {3, HYSTERETIC, 0.4}, {2, ROLLING, 0.4},       {3, ROLLING, 0.4},
    {2, HERTZ, 0.4},  {3, HERTZ, 0.4},      {3, HERTZ, 0.0},      {2, HERTZ RESISTS, 0.4}, {3, ELASTOPLASTIC, 0.4},
};
enum { N_MODELS = sizeof models / sizeof *models, PARTICLES = 64, STAGE_STEPS = 600 };

/* Two stages: confined while particles still fly about, then sheared. `more` is added to the scene, and wins. */
static struct scene *scene_make(const struct model *model, int count, const char *sample, const char *more)
{
    char text[4096];
    const char *pressure = model->dimension == 2 ? "2e3" : "2e5"; /* about 30 N on a wall */
    struct scene *scene = calloc(1, sizeof *scene);
    assert_non_null(scene);
    snprintf(text, sizeof text,
             "name = \"checkpoint\"; dimension = %d; seed = 3; %s\n"
             "sample = { count = %d; radius_min_m = 0.5e-3; radius_max_m = 1.5e-3; density_kg_per_m3 = 2000.0;\n"
             "  speed_m_per_s = 0.5; %s };\n"
             "material = { %s mu_s = %g; gamma_b_kg_per_s = 0.02; };\n"
             "walls = { x = { mode = \"stress\"; pressure_pa = %s; mass_kg = 1e-3; damping_kg_per_s = 5.0; };\n"
             "  %s z = { mode = \"stress\"; pressure_pa = %s; mass_kg = 1e-3; damping_kg_per_s = 5.0; }; };\n"
             "stages = ( { name = \"confine\"; dt_s = 2e-6; duration_s = 1.2e-3; },\n"
             "  { name = \"shear\"; dt_s = 1e-6; duration_s = 6e-4;\n"
             "    walls = { z = { mode = \"strain\"; strain = 0.05; frequency_hz = 800.0; }; }; } );\n",
             model->dimension, more, count, sample, model->law, model->mu, pressure,
             model->dimension == 3
                 ? "y = { mode = \"stress\"; pressure_pa = 2e5; mass_kg = 1e-3; damping_kg_per_s = 5.0; };"
                 : "",
             pressure);
    if (scene_parse(scene, text, "test") != STATUS_OK)
        fail_msg("%s", status_message());
    return scene;
}

static void scene_drop(struct scene *scene)
{
    scene_free(scene);
    free(scene);
}

static void must(enum status status)
{
    if (status != STATUS_OK)
        fail_msg("%s", status_message());
}

static void assert_close(const char *what, double value, double expected, double tolerance)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%s: %.17g instead of %.17g", what, value, expected);
}

/* Exchanges and steps until `step`, or to the end of the protocol. */
static void go_on(struct sample *sample, int64_t step)
{
    while (sample->step < step) {
        struct wall_state state;
        struct wall_command command;
        sample_wall_state(sample, &state);
        must(wallctl_law(sample->scene, &state, &command));
        if (command.finished)
            return;
        must(sample_command(sample, &command));
        for (int k = 0; k < command.n_steps; k++)
            must(sample_step(sample));
    }
}

static void assert_equal(struct sample *a, struct sample *b)
{
    char difference[128];
    if (!checkpoint_equal(a, b, difference, sizeof difference))
        fail_msg("%s differs", difference);
    assert_true(sample_hash(sample_complete(a)) == sample_hash(sample_complete(b)));
}

static const struct run_progress progress = {.run_id = 12,
                                             .fraction_done = 0.25,
                                             .kinetic_j = 1.0 / 3,
                                             .energy_step = 17,
                                             .exchanges = 99,
                                             .record_total = {1, 2, 3, 4, 5, 6, 0},
                                             .last_frame_step = -1};

static void resume_at(const struct model *model, int64_t step, const char *more)
{
    struct scene *scene = scene_make(model, PARTICLES, "", more);
    struct sample *whole, *resumed;
    struct run_progress taken;
    must(sample_from_scene(&whole, scene));
    go_on(whole, step);
    must(checkpoint_write(path, whole, &progress));
    must(checkpoint_resume(path, scene, &resumed, &taken));
    assert_memory_equal(&taken, &progress, sizeof taken);
    assert_equal(whole, resumed);
    struct measurement before, after;
    must(measure(sample_complete(whole), &before)); /* forces of the last step, too, are there */
    must(measure(sample_complete(resumed), &after));
    assert_memory_equal(&before, &after, sizeof before);
    int64_t rebuilds = whole->verlet.rebuilds;
    go_on(whole, INT64_MAX);
    go_on(resumed, INT64_MAX);
    assert_true(step >= 2 * STAGE_STEPS || whole->verlet.rebuilds > rebuilds); /* histories went through a rebuild */
    assert_int_equal(whole->step, 2 * STAGE_STEPS);
    assert_equal(whole, resumed);
    sample_free(whole);
    sample_free(resumed);
    scene_drop(scene);
}

/* Before the first command, within each stage, at the end of each (before the next command), right after a start. */
static void test_same_bits(void **state)
{
    static const int64_t steps[] = {0, 1, 251, STAGE_STEPS, STAGE_STEPS + 1, 2 * STAGE_STEPS - 211, 2 * STAGE_STEPS};
    (void)state;
    for (int m = 0; m < N_MODELS; m++)
        for (size_t k = 0; k < sizeof steps / sizeof *steps; k++)
            for (int mixed = 0; mixed < 2; mixed++) {
                char more[100];
                snprintf(more, sizeof more, "%s %s", k % 2 ? "" : "neighbor = { renumber_steps = 100; };",
                         mixed ? "precision = \"mixed\";" : "");
                resume_at(&models[m], steps[k], more);
            }
}

/* The sample of `model` after its first stage, in the file. */
static struct sample *prepare(const struct model *model, bool mixed, struct scene **scene)
{
    struct sample *sample;
    *scene = scene_make(model, PARTICLES, "", mixed ? "precision = \"mixed\";" : "");
    must(sample_from_scene(&sample, *scene));
    go_on(sample, STAGE_STEPS);
    must(checkpoint_write(path, sample, &progress));
    return sample;
}

/* Column c of contact k as it is now: springs are kept half a step ahead in a run. */
static double value_now(struct sample *sample, int c, int k)
{
    const struct contact_law_constants *law = &sample->law;
    const bool mindlin = sample->pairs.model.traits & NORMAL_MINDLIN;
    struct contact_geometry g;
    struct contact_forces f;
    if (!contact_state_at(sample_complete(sample), 0, k, &g, &f))
        return contact_list_whole(&sample->pairs, c, k);
    for (int d = 0; d < contact_model_springs(&sample->pairs.model); d++) {
        if (c == HISTORY_SPRING + d || c == HISTORY_FORCE + d)
            return f.spring[d] * (mindlin ? 1 : law->inv_kt);
        if (c == HISTORY_ROLLING + d)
            return f.rolling[d] * law->rolling.inv_k;
    }
    return c == HISTORY_TORSION ? f.torsion * law->torsion.inv_k : contact_list_whole(&sample->pairs, c, k);
}

/* What contact k of another sample is to remember in column c, of contact `old` of `from`: the same if that remembers
 * it too; else a largest overlap is the overlap, and all else nothing. */
static double history_expected(struct sample *from, int c, int old)
{
    if (history_has(&from->pairs.model, c))
        return value_now(from, c, old);
    return c == HISTORY_MAX_OVERLAP ? fmax(contact_geometry_at(from, 0, old).overlap, 0) : 0;
}

/* Returns how many values are not 0. */
static int check_history(struct sample *from, const struct sample *to)
{
    /* a float has half a unit in the last place, 6e-8; with what rounding left, the square of that */
    const double rounding = !to->pairs.model.mixed    ? (from->pairs.model.mixed ? 1e-14 : 0)
                            : from->pairs.model.mixed ? 1e-14
                                                      : 6e-8;
    int values = 0;
    for (int k = 0; k < to->pairs.count; k++) {
        int i = to->pairs.i[k], j = to->pairs.j[k], old = 0;
        while (old < from->pairs.count && (from->pairs.i[old] != i || from->pairs.j[old] != j))
            old++;
        for (int c = 0; old < from->pairs.count && c < HISTORY_COLUMNS; c++) {
            if (!history_has(&to->pairs.model, c) || history_field(c)->is_rest)
                continue;
            const double expected = history_expected(from, c, old), value = contact_list_whole(&to->pairs, c, k);
            const bool starts = !history_has(&from->pairs.model, c); /* as a float */
            const double allowed = starts && to->pairs.model.mixed ? 6e-8 : rounding;
            assert_close(history_field(c)->name, value, expected, allowed * fabs(expected));
            values += value != 0;
        }
    }
    return values;
}

/* Starts a run of `model` with that sample, and goes through it. */
static void start_from(struct sample *from, const struct model *model, bool mixed, uint64_t *hash)
{
    char start[128];
    snprintf(start, sizeof start, "initial = \"checkpoint\"; checkpoint = \"%s\";", path);
    struct scene *scene = scene_make(model, PARTICLES, start, mixed ? "precision = \"mixed\";" : "");
    struct sample *sample;
    must(sample_from_scene(&sample, scene));
    assert_int_equal(sample->step, 0);
    assert_int_equal(sample->stage, -1);
    size_t size = PARTICLES * sizeof(double);
    for (int c = 0; c < model->dimension; c++) {
        assert_memory_equal(sample->particles.x[c], from->particles.x[c], size);
        assert_memory_equal(sample->particles.v[c], from->particles.v[c], size);
    }
    assert_memory_equal(sample->particles.inv_mass, from->particles.inv_mass, size);
    for (int w = 0; w < sample->n_walls; w++)
        assert_true(sample->walls[w].x == from->walls[w].x && sample->walls[w].v == 0);
    const int values = check_history(from, sample);
    const bool same_law = from->scene->material.law == scene->material.law;
    assert_true(!same_law || !(model->mu > 0 && from->pairs.model.frictional) || values > 0);
    go_on(sample, INT64_MAX);
    assert_int_equal(sample->step, 2 * STAGE_STEPS);
    struct measurement after;
    must(measure(sample_complete(sample), &after)); /* and energies are finite */
    *hash = sample_hash(sample_complete(sample));
    sample_free(sample);
    scene_drop(scene);
}

/* Every model's sample serves every scene of its dimension, whatever its law and precision, and each scene goes its own
 * way, always the same. */
static void test_shared_preparation(void **state)
{
    (void)state;
    for (int m = 0; m < N_MODELS; m++) {
        struct scene *scene;
        struct sample *prepared = prepare(&models[m], m / 2 % 2, &scene);
        uint64_t hash[N_MODELS] = {0}, again;
        for (int k = 0; k < N_MODELS; k++) {
            if (models[k].dimension != models[m].dimension)
                continue;
            start_from(prepared, &models[k], (m + k) % 2, &hash[k]);
            for (int other = 0; other < k; other++)
                assert_true(hash[k] != hash[other]);
        }
        start_from(prepared, &models[m], 0, &again);
        assert_true(again == hash[m]);
        sample_free(prepared);
        scene_drop(scene);
    }
}

static void expect_no_start(const struct model *model, int count, const char *text)
{
    char start[128];
    struct sample *sample;
    snprintf(start, sizeof start, "initial = \"checkpoint\"; checkpoint = \"%s\";", path);
    struct scene *scene = scene_make(model, count, start, "");
    assert_int_equal(sample_from_scene(&sample, scene), STATUS_CONFIG);
    assert_null(sample);
    if (!strstr(status_message(), text))
        fail_msg("\"%s\" does not say \"%s\"", status_message(), text);
    scene_drop(scene);
}

static void expect_no_resume(const struct model *model, const char *more, const char *text)
{
    struct scene *scene = scene_make(model, PARTICLES, "", more);
    struct sample *sample;
    struct run_progress taken;
    assert_int_equal(checkpoint_resume(path, scene, &sample, &taken), STATUS_CONFIG);
    assert_null(sample);
    if (!strstr(status_message(), text))
        fail_msg("\"%s\" does not say \"%s\"", status_message(), text);
    scene_drop(scene);
}

static void test_other_scenes(void **state)
{
    struct scene *scene, *same;
    struct model other = models[1];
    struct sample *resumed, *sample = prepare(&models[1], false, &scene);
    struct run_progress taken;
    (void)state;
    expect_no_start(&models[1], PARTICLES + 1, "holds 64 particles, the scene says sample.count = 65");
    expect_no_start(&models[5], PARTICLES, "dimension 2, the scene says 3");
    other.mu = 0.5;
    expect_no_resume(&other, "", "material.mu_s was 0.4");
    expect_no_resume(&models[1], "neighbor = { skin_ratio = 0.2; };", "neighbor.skin_ratio was 0.0,");
    expect_no_resume(&models[1], "gravity_m_per_s2 = [0.0, 0.0, -9.81];", "gravity_m_per_s2 was []");
    expect_no_resume(&models[5], "", "dimension was 2L, is now 3L");
    other = models[1];
    other.law = LINEAR " gamma_br_kg_per_s = 1.0;";
    expect_no_resume(&other, "", "material.gamma_br_kg_per_s");
    expect_no_resume(&models[3], "", "material.law was \"linear\", is now \"hysteretic\"");
    expect_no_resume(&models[10], "", "material.law was \"linear\", is now \"hertz\"");
    expect_no_resume(&models[8], "", "material.mu_rolling was 0.0, is now 0.1");
    same = scene_make(&models[1], PARTICLES, "", "checkpoint_interval_s = 5.0; coupling = { timeout_s = 9.0; };");
    must(checkpoint_resume(path, same, &resumed, &taken)); /* how often, and how patiently, is free */
    sample_free(resumed);
    sample_free(sample);
    scene_drop(same);
    scene_drop(scene);
}

static unsigned char *file_read(const char *name, size_t *size)
{
    struct stat information;
    FILE *file = fopen(name, "rb");
    assert_non_null(file);
    assert_int_equal(fstat(fileno(file), &information), 0);
    *size = (size_t)information.st_size;
    unsigned char *bytes = malloc(*size);
    assert_non_null(bytes);
    assert_int_equal(fread(bytes, 1, *size, file), *size);
    assert_int_equal(fclose(file), 0);
    return bytes;
}

static void file_write(const char *name, const unsigned char *bytes, size_t size)
{
    FILE *file = fopen(name, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static void expect_failure(const struct scene *scene, enum status expected)
{
    struct sample *sample;
    struct run_progress taken;
    enum status status = checkpoint_resume(path, scene, &sample, &taken);
    if (status != expected)
        fail_msg("status %d instead of %d: %s", status, expected, status_message());
    assert_null(sample);
    assert_non_null(strstr(status_message(), path));
}

static void test_damage(void **state)
{
    struct scene *scene;
    struct sample *sample = prepare(&models[3], false, &scene);
    size_t size;
    unsigned char *bytes = file_read(path, &size);
    (void)state;
    for (size_t cut = 0; cut < size; cut += 1 + size / 50) {
        file_write(path, bytes, cut);
        expect_failure(scene, STATUS_FORMAT);
    }
    for (size_t at = 512; at < size; at += 1 + size / 50) {
        bytes[at] ^= 0x10;
        file_write(path, bytes, size);
        expect_failure(scene, STATUS_FORMAT);
        bytes[at] ^= 0x10;
    }
    memcpy(bytes, "Shakedown checkpoint, format 2", 30);
    file_write(path, bytes, size);
    expect_failure(scene, STATUS_FORMAT);
    assert_non_null(strstr(status_message(), "format 2"));
    file_write(path, (const unsigned char *)"name = \"a scene\";\n", 18);
    expect_failure(scene, STATUS_FORMAT);
    assert_int_equal(unlink(path), 0);
    expect_failure(scene, STATUS_IO);
    free(bytes);
    sample_free(sample);
    scene_drop(scene);
}

/* What fails leaves the old checkpoint, and nothing beside it. */
/* Takes a member out of the file. */
static void forget(const char *member)
{
    enum { HEADER = 512 };
    static const char bare[] = "test_checkpoint_bare.h5";
    size_t size;
    unsigned char *bytes = file_read(path, &size);
    file_write(bare, bytes + HEADER, size - HEADER);
    free(bytes);
    hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    assert_true(H5Pset_fapl_core(access, 1 << 20, 0) >= 0); /* in memory, as checkpoint_image_save has it */
    hid_t file = H5Fopen(bare, H5F_ACC_RDWR, access);
    assert_true(H5Ldelete(file, member, H5P_DEFAULT) >= 0);
    must(checkpoint_image_save(file, path));
    H5Pclose(access);
    H5Fclose(file);
    assert_int_equal(unlink(bare), 0);
}

/* A file that lacks what came later is no run to go on with, but a sample to start from. */
static void test_older_files(void **state)
{
    static const char *const later[] = {"sample/kicked_s", "walls/0/touching", "particles/v_rest"};
    static const char mixed[] = "precision = \"mixed\";";
    char start[128];
    struct run_progress taken;
    struct sample *resumed, *sample, *started;
    (void)state;
    snprintf(start, sizeof start, "initial = \"checkpoint\"; checkpoint = \"%s\";", path);
    struct scene *scene = scene_make(&models[3], PARTICLES, "", mixed);
    struct scene *next = scene_make(&models[3], PARTICLES, start, mixed);
    must(sample_from_scene(&sample, scene));
    go_on(sample, STAGE_STEPS);
    for (int k = 0; k < 3; k++) {
        must(checkpoint_write(path, sample, &progress));
        forget(later[k]);
        assert_int_equal(checkpoint_resume(path, scene, &resumed, &taken), STATUS_FORMAT);
        assert_null(resumed);
        assert_non_null(strstr(status_message(), later[k]));
        assert_non_null(strstr(status_message(), "an older version wrote it"));
        must(sample_from_scene(&started, next));
        for (int c = 0; c < 2; c++)
            assert_memory_equal(started->particles.x[c], sample->particles.x[c], PARTICLES * sizeof(double));
        go_on(started, INT64_MAX);
        assert_int_equal(started->step, 2 * STAGE_STEPS);
        sample_free(started);
    }
    sample_free(sample);
    scene_drop(scene);
    scene_drop(next);
}

static void test_full_disk(void **state)
{
    struct scene *scene;
    struct sample *sample = prepare(&models[1], false, &scene);
    struct rlimit before, limit;
    size_t size, now;
    unsigned char *bytes = file_read(path, &size);
    (void)state;
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    limit = before;
    limit.rlim_cur = size / 2;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
    go_on(sample, STAGE_STEPS + 10);
    enum status status = checkpoint_write(path, sample, &progress);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    assert_int_equal(status, STATUS_IO);
    unsigned char *after = file_read(path, &now);
    assert_int_equal(now, size);
    assert_memory_equal(after, bytes, size);
    assert_int_not_equal(access("test_checkpoint.h5.new", F_OK), 0);
    assert_int_equal(checkpoint_write("no/such/folder.h5", sample, &progress), STATUS_IO);
    free(after);
    free(bytes);
    sample_free(sample);
    scene_drop(scene);
}

/* A shared checkpoint stays what it was when the first name gets a new one. */
static void test_share(void **state)
{
    static const char copy[] = "test_checkpoint_copy.h5";
    struct scene *scene;
    struct sample *sample = prepare(&models[0], false, &scene);
    size_t size, copy_size;
    unsigned char *bytes = file_read(path, &size);
    (void)state;
    must(checkpoint_share(path, copy));
    must(checkpoint_share(path, copy)); /* again */
    assert_int_not_equal(access("test_checkpoint_copy.h5.new", F_OK), 0);
    go_on(sample, STAGE_STEPS + 10);
    must(checkpoint_write(path, sample, &progress));
    unsigned char *shared = file_read(copy, &copy_size);
    assert_int_equal(copy_size, size);
    assert_memory_equal(shared, bytes, size);
    assert_int_equal(unlink(copy), 0);
    free(shared);
    free(bytes);
    sample_free(sample);
    scene_drop(scene);
}

static int remove_file(void **state)
{
    (void)state;
    (void)unlink(path); /* not there if a test failed early */
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same_bits),    cmocka_unit_test(test_shared_preparation),
        cmocka_unit_test(test_other_scenes), cmocka_unit_test(test_damage),
        cmocka_unit_test(test_full_disk),    cmocka_unit_test(test_share),
        cmocka_unit_test(test_older_files),
    };
    return cmocka_run_group_tests(tests, NULL, remove_file);
}
