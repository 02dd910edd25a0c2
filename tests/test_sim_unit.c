/* Parts of the simulator: random numbers, starting positions, neighbour lists, scene files, and the sizes of records.
 * Usage: test_sim_unit SCENE... (scenes whose effective configuration must read back). */
#include "common/scene_file.h"
#include "sim_fixture.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/record_sender.h"
#include "shakedown_frame_contacts_t.h"
#include "sim/base/random.h"
#include "sim/measure/time_remaining.h"
#include "sim/run/records.h"
#include "sim/sample/step_completion.h"
#include "sim/sample/time_step.h"

static char **scene_files;
static int n_scene_files;

/* ---- random numbers ---- */

/* First outputs of xoshiro256** seeded by splitmix64 of 0, from an independent implementation; a number is the top 53
 * bits. */
static void random_numbers_are_the_generator(void **state)
{
    struct random random;
    (void)state;
    random_init(&random, 0);
    assert_true(random.state[0] == 0xe220a8397b1dcdafu);
    assert_true(random_uniform(&random) == (double)(0x99ec5f36cb75f2b4u >> 11) * 0x1p-53);
    assert_true(random_uniform(&random) == (double)(0xbf6e1f784956452au >> 11) * 0x1p-53);
}

/* n = 1e5: mean within 5 standard errors sd/sqrt(n), variance within 5 sd of its own, sqrt(2/n) for a normal and
 * sqrt(0.8/n) of the value for a uniform distribution. */
static void random_moments(void **state)
{
    enum { N = 100000 };
    struct random random;
    double mean = 0, square = 0, uniform = 0, lowest = 1, highest = 0;
    (void)state;
    random_init(&random, 42);
    for (int k = 0; k < N; k++) {
        double u = random_uniform(&random), x = random_normal(&random);
        uniform += u / N;
        lowest = fmin(lowest, u);
        highest = fmax(highest, u);
        mean += x / N;
        square += x * x / N;
    }
    assert_close("uniform mean", uniform, 0.5, 5 * sqrt(1.0 / 12 / N));
    assert_true(lowest >= 0 && highest < 1);
    assert_close("normal mean", mean, 0, 5 / sqrt(N));
    assert_close("normal variance", square, 1, 5 * sqrt(2.0 / N));
}

/* ---- starting positions ---- */

static struct fixture placed(int dimension, int count, const char *sample)
{
    char text[1024];
    snprintf(text, sizeof text,
             "dimension = %d;\nsample = { count = %d; density_kg_per_m3 = 2000.0; %s };\n"
             "material = { kn_n_per_m = 1e5; };\nstages = ( { name = \"a\"; dt_s = 1e-6; duration_s = 1.0; } );\n",
             dimension, count, sample);
    return fixture_from_text(text);
}

/* Nothing touches anything, and everything is inside. */
static void check_apart(const struct sample *sample)
{
    const struct particles *p = &sample->particles;
    for (int i = 0; i < p->count; i++) {
        for (int c = 0; c < p->dimension; c++)
            assert_true(p->x[c][i] - p->radius[i] >= sample->walls[2 * c].x &&
                        p->x[c][i] + p->radius[i] <= sample->walls[2 * c + 1].x);
        for (int j = 0; j < i; j++) {
            double d2 = 0, reach = p->radius[i] + p->radius[j];
            for (int c = 0; c < p->dimension; c++)
                d2 += (p->x[c][i] - p->x[c][j]) * (p->x[c][i] - p->x[c][j]);
            assert_true(d2 >= reach * reach);
        }
    }
}

static void starts_do_not_overlap(void **state)
{
    static const char *const start[] = {
        "radius_min_m = 0.5e-3; radius_max_m = 1.5e-3;",
        "radius_min_m = 0.5e-3; radius_max_m = 1.5e-3; initial = \"random\"; solid_fraction = 0.3; aspect_ratio = 2.0;",
        "radius_min_m = 0.1e-3; radius_max_m = 1e-3; initial = \"random\"; solid_fraction = 0.25;"};
    static const int count[] = {1, 2, 60, 400};
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++)
        for (int s = 0; s < 3; s++)
            for (int n = 0; n < 4; n++) {
                if (s > 0 && count[n] < 60) /* a box with room for one or two is too small to find it */
                    continue;
                struct fixture f = placed(dimension, count[n], start[s]);
                check_apart(f.sample);
                fixture_close(&f);
            }
}

static void gaussian_radii_keep_their_cuts(void **state)
{
    enum { N = 4000 };
    struct fixture f = placed(2, N,
                              "radius_distribution = \"gaussian\"; radius_mean_m = 5e-3; radius_sd_m = 1e-3; "
                              "radius_min_m = 3e-3; radius_max_m = 7e-3;");
    double mean = 0;
    (void)state;
    for (int i = 0; i < N; i++) {
        double a = f.sample->particles.radius[i];
        assert_true(a >= 3e-3 && a <= 7e-3);
        mean += a / N;
    }
    assert_close("mean radius", mean, 5e-3, 5 * 1e-3 / sqrt(N)); /* cuts at +-2 sd leave the mean, five errors */
    fixture_close(&f);
}

/* Height over width: the lattice rounds to whole cells, the random box does not. */
static void boxes_have_their_aspect(void **state)
{
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++) {
        struct fixture lattice =
            placed(dimension, 4000, "radius_min_m = 1e-3; radius_max_m = 1e-3; aspect_ratio = 2.0;");
        struct fixture random = placed(dimension, 500,
                                       "radius_min_m = 1e-3; radius_max_m = 1e-3; aspect_ratio = 2.0; initial = "
                                       "\"random\"; solid_fraction = 0.2;");
        int last = dimension - 1;
        double cells = sample_box_length_m(lattice.sample, 0) / 2.02e-3;
        double ratio = sample_box_length_m(lattice.sample, last) / sample_box_length_m(lattice.sample, 0);
        assert_close("lattice", ratio, 2, 2 * dimension / cells); /* one cell more across takes that much off */
        ratio = sample_box_length_m(random.sample, last) / sample_box_length_m(random.sample, 0);
        assert_close("random", ratio, 2, 4 * DBL_EPSILON);
        fixture_close(&lattice);
        fixture_close(&random);
    }
}

static void no_room_is_an_error(void **state)
{
    static const char *const text =
        "dimension = %d;\nsample = { count = %d; radius_min_m = 1e-3; radius_max_m = 1e-3; density_kg_per_m3 = 2000.0; "
        "initial = \"random\"; solid_fraction = 0.6; };\nmaterial = { kn_n_per_m = 1e5; };\n"
        "stages = ( { name = \"a\"; dt_s = 1e-6; duration_s = 1.0; } );\n";
    char buffer[1024];
    struct sample *sample;
    (void)state;
    snprintf(buffer, sizeof buffer, text, 3, 1000); /* random addition jams at 0.38 in 3D */
    struct scene *scene = fixture_scene_of(buffer);
    assert_int_equal(sample_create(&sample, scene), STATUS_LIMIT);
    assert_non_null(strstr(status_message(), "no room for particle"));
    fixture_scene_free(scene);
    snprintf(buffer, sizeof buffer, text, 2, 1);
    scene = fixture_scene_of(buffer);
    scene->sample.aspect_ratio = 100;
    assert_int_equal(sample_create(&sample, scene), STATUS_LIMIT);
    assert_non_null(strstr(status_message(), "smaller than the largest particle"));
    fixture_scene_free(scene);
}

/* ---- neighbour lists ---- */

/* A gas in a box, hysteretic and frictional, that loses little. */
static struct fixture gas(int dimension, int count, double skin_ratio)
{
    char text[1024];
    snprintf(
        text, sizeof text,
        "dimension = %d;\nsample = { count = %d; radius_min_m = 0.2e-3; radius_max_m = 1.5e-3; density_kg_per_m3 = "
        "2000.0; speed_m_per_s = 1.0; gap_ratio = 0.05; };\n"
        "material = { law = \"hysteretic\"; k1_n_per_m = 8e4; k2_n_per_m = 1e5; kc_n_per_m = 2e4; mu_s = 0.3; "
        "kt_n_per_m = 2e4; gamma_t_kg_per_s = 0.01; };\nneighbor = { skin_ratio = %g; };\n"
        "stages = ( { name = \"a\"; dt_s = 5e-7; duration_s = 1.0; } );\n",
        dimension, count, skin_ratio);
    struct fixture f = fixture_from_text(text);
    fixture_start(&f);
    return f;
}

static bool listed(const struct contact_list *list, int i, int j)
{
    int lo = 0, hi = list->count;
    while (lo < hi) {
        int middle = (lo + hi) / 2;
        bool before = list->i[middle] < i || (list->i[middle] == i && list->j[middle] < j);
        lo = before ? middle + 1 : lo;
        hi = before ? hi : middle;
    }
    return lo < list->count && list->i[lo] == i && list->j[lo] == j;
}

/* Lists rise strictly; every touching pair and wall contact is in them. Returns the number of touching pairs. */
static int check_lists(const struct sample *sample)
{
    const struct particles *p = &sample->particles;
    const struct contact_list *pairs = &sample->pairs;
    int touching = 0;
    for (int k = 0; k < pairs->count; k++) {
        assert_true(pairs->i[k] < pairs->j[k] && pairs->j[k] < p->count);
        if (k > 0)
            assert_true(pairs->i[k - 1] < pairs->i[k] ||
                        (pairs->i[k - 1] == pairs->i[k] && pairs->j[k - 1] < pairs->j[k]));
    }
    for (int i = 0; i < p->count; i++) {
        for (int j = i + 1; j < p->count; j++) {
            double d2 = 0, reach = p->radius[i] + p->radius[j];
            for (int c = 0; c < p->dimension; c++)
                d2 += (p->x[c][i] - p->x[c][j]) * (p->x[c][i] - p->x[c][j]);
            touching += d2 < reach * reach;
            assert_true(!(d2 < reach * reach) || listed(pairs, i, j));
        }
        for (int w = 0; w < sample->n_walls; w++) {
            const struct wall *wall = &sample->walls[w];
            bool near = p->radius[i] > wall->inward * (p->x[wall->axis][i] - wall->x);
            assert_true(!near || listed(&wall->contacts, i, wall->contacts.count ? wall->contacts.j[0] : 0));
        }
    }
    return touching;
}

static void lists_are_complete_through_motion(void **state)
{
    static const int count[] = {1, 2, 3, 5, 9, 60};
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++)
        for (int n = 0; n < 6; n++) {
            struct fixture f = gas(dimension, count[n], 0.1);
            int64_t before = f.sample->verlet.rebuilds;
            int touching = 0;
            for (int k = 0; k < 4000; k++) {
                fixture_steps(&f, 1);
                touching += check_lists(f.sample);
            }
            assert_true(f.sample->verlet.rebuilds > before + 1);
            assert_true(count[n] < 60 || touching > 100);
            fixture_close(&f);
        }
}

/* The skin decides when lists are built anew and in what order forces are summed up, nothing else: histories are
 * carried over whole. Rounding of 1e-16 grows at each collision by about the free path over the radius, some ten. */
static void the_skin_changes_nothing(void **state)
{
    static const double skin[] = {0.02, 0.1, 0.7, 5};
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++) {
        double first[3][60], worst = 0;
        int64_t rebuilds = INT64_MAX;
        for (int k = 0; k < 4; k++) {
            struct fixture f = gas(dimension, 60, skin[k]);
            fixture_steps(&f, 6000);
            for (int c = 0; c < dimension; c++)
                for (int i = 0; i < 60; i++) {
                    double x = f.sample->particles.x[c][i];
                    first[c][i] = k == 0 ? x : first[c][i];
                    worst = fmax(worst, fabs(x - first[c][i]));
                }
            assert_true(f.sample->verlet.rebuilds < rebuilds || f.sample->verlet.rebuilds < 4);
            rebuilds = f.sample->verlet.rebuilds;
            fixture_close(&f);
        }
        print_message("%dD: positions differ by %.2g m\n", dimension, worst);
        assert_true(worst < 1e-12);
    }
}

/* Kick and drift in one pass or one after the other: the same bits, lists built meanwhile or not. */
static void open_steps_change_nothing(void **state)
{
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++) {
        struct fixture a = gas(dimension, 60, 0.1), b = gas(dimension, 60, 0.1);
        for (int k = 0; k < 3000; k++) {
            must(sample_step(a.sample));
            must(sample_step_open(b.sample));
            assert_true(b.sample->open && !a.sample->open);
        }
        assert_true(sample_hash(sample_complete(a.sample)) == sample_hash(sample_complete(b.sample)));
        assert_true(a.sample->ledger.background == b.sample->ledger.background);
        assert_true(b.sample->verlet.rebuilds > 1);
        fixture_close(&a);
        fixture_close(&b);
    }
}

/* ---- scenes ---- */

static char *printed(const struct scene *scene)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    scene_print(out, scene);
    assert_int_equal(fclose(out), 0);
    return text;
}

static struct scene *loaded(const char *path, const char *const *overrides, int n)
{
    struct scene *scene = calloc(1, sizeof *scene);
    assert_non_null(scene);
    must(scene_load(scene, path, overrides, n));
    return scene;
}

/* Equal but for the text, its name and its lines. */
static bool same_scene(const struct scene *a, const struct scene *b)
{
    struct scene *x = malloc(sizeof *x), *y = malloc(sizeof *y);
    assert_true(x && y);
    memcpy(x, a, sizeof *x);
    memcpy(y, b, sizeof *y);
    x->text = y->text = NULL;
    x->source = y->source = NULL;
    x->stage = y->stage = NULL;
    x->prepared = y->prepared = NULL; /* its stages are there */
    bool same = memcmp(x, y, sizeof *x) == 0;
    for (int k = 0; k < a->n_stages && same; k++) {
        struct scene_stage *stage = malloc(sizeof *stage);
        assert_non_null(stage);
        memcpy(stage, &a->stage[k], sizeof *stage);
        stage->line = b->stage[k].line;
        same = memcmp(stage, &b->stage[k], sizeof *stage) == 0;
        free(stage);
    }
    free(x);
    free(y);
    return same;
}

/* As a user would: saved, then loaded, tables of grains and all. */
static struct scene *saved_and_loaded(const char *text)
{
    char path[] = "/tmp/shakedown-effective-XXXXXX";
    const int file = mkstemp(path);
    assert_true(file >= 0);
    assert_int_equal(write(file, text, strlen(text)), strlen(text));
    assert_int_equal(close(file), 0);
    struct scene *scene = loaded(path, NULL, 0);
    assert_int_equal(unlink(path), 0);
    return scene;
}

static void effective_configurations_read_back(void **state)
{
    (void)state;
    assert_true(n_scene_files > 0);
    for (int k = 0; k < n_scene_files; k++) {
        struct scene *scene = loaded(scene_files[k], NULL, 0);
        char *text = printed(scene);
        struct scene *again = saved_and_loaded(text);
        if (!same_scene(scene, again))
            fail_msg("%s does not read back", scene_files[k]);
        char *once_more = printed(again);
        assert_string_equal(text, once_more);
        free(once_more);
        free(text);
        fixture_scene_free(scene);
        fixture_scene_free(again);
    }
}

/* Of what nobody set the effective configuration says what means something, and no more. */
static void effective_configurations_say_what_counts(void **state)
{
    static const struct {
        const char *material, *more; /* of a scene in 2D */
        const char *said[4], *unsaid[8];
    } cases[] = {
        {"kn_n_per_m = 1e5;",
         "",
         {"  law = \"linear\";", "  gap_ratio = 0.01", "  mu_s = 0.0;"},
         {"walls = {", "k1_n_per_m", "youngs_modulus_pa", "kt_n_per_m", "mu_rolling", "radius_sd_m", "gravity"}},
        {"kn_n_per_m = 1e5; mu_s = 0.3; kt_n_per_m = 2e4;",
         "",
         {"  mu_rolling = 0.0;", "  wall_friction = 1.0;"},
         {"kr_n_per_m", "ko_n_per_m", "walls = {"}},
        {"law = \"hertz\"; youngs_modulus_pa = 1e8;",
         "walls = { x = { material = { youngs_modulus_pa = 2e8; }; }; };",
         {"  poisson_ratio = 0.0;", "  restitution = 1.0;", "walls = {", "      youngs_modulus_pa = 2"},
         {"kn_n_per_m", "gamma_n_kg_per_s", "particles", "  y = {", "  z = {", "phi_f"}},
    };
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        char scene_text[1024];
        snprintf(
            scene_text, sizeof scene_text,
            "dimension = 2; %s material = { %s };\nsample = { count = 4; radius_min_m = 1e-3; radius_max_m = 1e-3; "
            "density_kg_per_m3 = 2000; };\nstages = ( { name = \"a\"; dt_s = 1e-6; duration_s = 1e-3; } );",
            cases[k].more, cases[k].material);
        struct scene *scene = fixture_scene_of(scene_text);
        char *text = printed(scene);
        for (int n = 0; n < 4 && cases[k].said[n]; n++)
            if (!strstr(text, cases[k].said[n]))
                fail_msg("%s is not in\n%s", cases[k].said[n], text);
        for (int n = 0; n < 8 && cases[k].unsaid[n]; n++)
            if (strstr(text, cases[k].unsaid[n]))
                fail_msg("%s is in\n%s", cases[k].unsaid[n], text);
        free(text);
        fixture_scene_free(scene);
    }
}

static void overrides_reach_their_keys(void **state)
{
    static const char *const overrides[] = {"seed=3000000000L",
                                            "material.gamma_n_kg_per_s=0.125",
                                            "stages.0.dt_s=1e-7",
                                            "stages.0.walls.x.mode=fixed",
                                            "name=other",
                                            "record.event_log=true",
                                            "gravity_m_per_s2=[0.0, 0.0, -9.81]"};
    (void)state;
    struct scene *scene = loaded(scene_files[0], overrides, 7);
    assert_true(scene->seed == 3000000000);
    assert_true(scene->material.gamma_n_kg_per_s == 0.125 && scene->stage[0].material.gamma_n_kg_per_s == 0.125);
    assert_true(scene->stage[0].dt_s == 1e-7);
    assert_int_equal(scene->stage[0].axis[AXIS_X].mode, WALL_FIXED);
    assert_string_equal(scene->name, "other");
    assert_true(scene->record.event_log);
    assert_int_equal(scene->gravity_m_per_s2.count, 3);
    assert_true(scene->gravity_m_per_s2.value[2] == -9.81);
    fixture_scene_free(scene);
}

/* ---- records ---- */

struct sizes {
    int64_t messages, largest, contacts;
};

static void read_sizes(const char *path, struct sizes *sizes)
{
    lcm_eventlog_t *log = lcm_eventlog_create(path, "r");
    assert_non_null(log);
    for (lcm_eventlog_event_t *event; (event = lcm_eventlog_read_next_event(log)); lcm_eventlog_free_event(event)) {
        sizes->messages++;
        sizes->largest = event->datalen > sizes->largest ? event->datalen : sizes->largest;
        if (strncmp(event->channel, "FRAME_CONTACTS", (size_t)event->channellen) != 0)
            continue;
        shakedown_frame_contacts_t chunk;
        assert_true(shakedown_frame_contacts_t_decode(event->data, 0, event->datalen, &chunk) >= 0);
        assert_int_equal(chunk.n_values, 3 * chunk.count);
        sizes->contacts += chunk.count;
        shakedown_frame_contacts_t_decode_cleanup(&chunk);
    }
    lcm_eventlog_destroy(log);
}

/* 3D, frictional, particles grown on their lattice until each touches many: chunks fill up, none is too large. */
static void chunks_fit_into_messages(void **state)
{
    struct fixture_options options = {
        .dimension = 3, .count = 8000, .dt_s = 1e-7, .material = "kn_n_per_m = 1e5; mu_s = 0.3; kt_n_per_m = 1e4;"};
    char path[] = "/tmp/shakedown-chunks-XXXXXX", url[64];
    struct fixture f = fixture_open(&options);
    struct bus bus;
    struct record_sender *stream;
    struct records records;
    struct sizes sizes = {0};
    (void)state;
    for (int i = 0; i < options.count; i++)
        f.sample->particles.radius[i] = 0.15; /* the lattice's spacing is 0.202 m */
    fixture_start(&f);
    int file = mkstemp(path);
    assert_true(file >= 0 && close(file) == 0);
    snprintf(url, sizeof url, "file://%s?mode=w", path);
    must(bus_open(&bus, url));
    must(record_sender_create(&stream, &bus, 1, 1));
    records_init(&records, stream, 1);
    must(records_send_frame(&records, sample_complete(f.sample)));
    must(bus_flush(&bus));
    record_sender_free(stream);
    bus_close(&bus);
    read_sizes(path, &sizes);
    assert_int_equal(unlink(path), 0);
    assert_true(sizes.contacts > 9 * 7000); /* neighbours at 1 and sqrt 2 spacings: 18 each, but at the border */
    assert_true(sizes.largest <= BUS_MESSAGE_MAX && sizes.largest > BUS_MESSAGE_MAX * 9 / 10);
    assert_true(sizes.messages > 100);
    fixture_close(&f);
}

/* ---- the time left ---- */

/* Three stages of 1000 steps each; what the middle one is told, and the last. */
static struct scene *outlook_scene(const char *middle, const char *last)
{
    char text[1024];
    snprintf(text, sizeof text,
             "dimension = 2; sample = { count = 4; radius_min_m = 1e-3; radius_max_m = 1e-3;"
             " density_kg_per_m3 = 2e3; };\nmaterial = { kn_n_per_m = 1e3; };\n"
             "stages = ( { name = \"a\"; dt_s = 1e-6; duration_s = 1e-3; },\n"
             "           { name = \"b\"; dt_s = 2e-6; duration_s = 2e-3; %s },\n"
             "           { name = \"c\"; dt_s = 1e-6; duration_s = 1e-3; %s } );\n",
             middle, last);
    return fixture_scene_of(text);
}

static void expect_left(const struct time_remaining *remaining, const struct scene *scene, int stage,
                        int64_t stage_step, double expected, enum time_remaining_kind kind)
{
    enum time_remaining_kind got;
    double steps = time_remaining_steps(remaining, scene, stage, stage_step, &got);
    assert_close("steps left", steps, expected, 1e-9 * expected);
    assert_int_equal(got, kind);
}

/* Samples at every 10th step in [from, to] of exp(-step/50) times 1 + swing sin(step/7). */
static struct time_remaining decay(int from, int to, double swing)
{
    struct time_remaining remaining = {0};
    for (int step = from; step <= to; step += 10)
        time_remaining_add(&remaining, step, exp(-step / 50.0) * (1 + swing * sin(step / 7.0)));
    return remaining;
}

static void lengths_that_are_known(void **state)
{
    const struct time_remaining none = {0};
    struct scene *scene = outlook_scene("", "");
    (void)state;
    expect_left(&none, scene, -1, 0, 3000, TIME_REMAINING_KNOWN);
    expect_left(&none, scene, 1, 250, 1750, TIME_REMAINING_KNOWN);
    expect_left(&none, scene, 2, 999, 1, TIME_REMAINING_KNOWN);
    fixture_scene_free(scene);
}

/* A pure decay meets exp(-10) at step 500 to rounding: sums of 20 terms. */
static void a_decay_is_extrapolated(void **state)
{
    struct scene *scene = outlook_scene("until_energy_ratio = 4.5399929762484854e-5;", "");
    struct time_remaining pure = decay(10, 200, 0), three = decay(10, 30, 0);
    (void)state;
    expect_left(&pure, scene, 1, 200, 300 + 1000, TIME_REMAINING_EXTRAPOLATED);
    expect_left(&pure, scene, 1, 207, 293 + 1000, TIME_REMAINING_EXTRAPOLATED);
    expect_left(&three, scene, 1, 30, 970 + 1000, TIME_REMAINING_AT_MOST); /* too few */
    expect_left(&pure, scene, 0, 200, 2800, TIME_REMAINING_AT_MOST);       /* the stage before has a length */
    fixture_scene_free(scene);
}

/* With a swing by half: ln 1.5 and ln 0.5 of the last ratio are 20 and 35 steps of a decay by 50; the slope is off by
 * less than a fifth from 200 steps on, where the swing has gone round four times. */
static void a_swing_does_little(void **state)
{
    struct scene *scene = outlook_scene("until_energy_ratio = 4.5399929762484854e-5;", "");
    (void)state;
    for (int step = 200; step < 450; step += 10) {
        struct time_remaining swinging = decay(10, step, 0.5);
        enum time_remaining_kind kind;
        double end = step + time_remaining_steps(&swinging, scene, 1, step, &kind) - 1000;
        assert_int_equal(kind, TIME_REMAINING_EXTRAPOLATED);
        assert_close("end of the stage", end, 500, 35 + 0.2 * (500 - step) + 10);
    }
    fixture_scene_free(scene);
}

/* No trend, or one away from it; met already; the limits of time on both sides; the stress. */
static void what_cannot_be_told_is_a_limit(void **state)
{
    struct scene *scene = outlook_scene("until_energy_ratio = 1e-5;", "");
    struct time_remaining growing = {0}, still = {0}, fast = decay(10, 200, 0), strange = decay(10, 200, 0);
    (void)state;
    for (int k = 1; k <= 20; k++) {
        time_remaining_add(&growing, 10 * k, exp(k));
        time_remaining_add(&still, 10 * k, 1e-3 * (1 + 0.1 * (k % 2)));
    }
    expect_left(&growing, scene, 1, 200, 1800, TIME_REMAINING_AT_MOST);
    expect_left(&still, scene, 1, 200, 1800, TIME_REMAINING_AT_MOST);
    time_remaining_add(&strange, 201, NAN);
    time_remaining_add(&strange, 202, INFINITY);
    time_remaining_add(&strange, 203, 0);
    assert_true(strange.samples == fast.samples && strange.last_step == fast.last_step && strange.sl == fast.sl);
    fixture_scene_free(scene);
    scene = outlook_scene("until_energy_ratio = 1e-300;", "");
    expect_left(&fast, scene, 1, 200, 1800, TIME_REMAINING_EXTRAPOLATED); /* not beyond the limit */
    fixture_scene_free(scene);
    scene = outlook_scene("until_energy_ratio = 0.1; min_duration_s = 1e-3; until_stress_error = 1e-2;"
                          " walls = { z = { mode = \"stress\"; pressure_pa = 1.0; mass_kg = 1.0; }; };",
                          "");
    expect_left(&fast, scene, 1, 200, 300 + 1000, TIME_REMAINING_EXTRAPOLATED);
    expect_left(&fast, scene, 1, 510, 490 + 1000, TIME_REMAINING_AT_MOST); /* it waits for the stress */
    fixture_scene_free(scene);
    scene = outlook_scene(
        "until_stress_error = 1e-2; walls = { z = { mode = \"stress\"; pressure_pa = 1.0; mass_kg = 1.0; }; };", "");
    expect_left(&fast, scene, 1, 200, 1800, TIME_REMAINING_AT_MOST);
    fixture_scene_free(scene);
    scene = outlook_scene("until_energy_ratio = 4.5399929762484854e-5;", "until_energy_ratio = 1e-5;");
    expect_left(&fast, scene, 1, 200, 300 + 1000, TIME_REMAINING_AT_MOST); /* of the last stage nothing is known */
    fixture_scene_free(scene);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_numbers_are_the_generator),
        cmocka_unit_test(random_moments),
        cmocka_unit_test(starts_do_not_overlap),
        cmocka_unit_test(gaussian_radii_keep_their_cuts),
        cmocka_unit_test(boxes_have_their_aspect),
        cmocka_unit_test(no_room_is_an_error),
        cmocka_unit_test(lists_are_complete_through_motion),
        cmocka_unit_test(open_steps_change_nothing),
        cmocka_unit_test(the_skin_changes_nothing),
        cmocka_unit_test(effective_configurations_read_back),
        cmocka_unit_test(effective_configurations_say_what_counts),
        cmocka_unit_test(overrides_reach_their_keys),
        cmocka_unit_test(chunks_fit_into_messages),
        cmocka_unit_test(lengths_that_are_known),
        cmocka_unit_test(a_decay_is_extrapolated),
        cmocka_unit_test(a_swing_does_little),
        cmocka_unit_test(what_cannot_be_told_is_a_limit),
    };
    scene_files = argv + 1;
    n_scene_files = argc - 1;
    return cmocka_run_group_tests(tests, NULL, NULL);
}
