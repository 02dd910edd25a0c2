/* Frames hold what contacts remember: for each law run.h5 has the fields of its history, with the values of the state.
 * The log is made by the simulator's records, run.h5 by the recorder. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "recorder/log_conversion.h"
#include "sim/grains/particle_order.h"
#include "sim/run/records.h"
#include "sim/sample/contact_state.h"
#include "sim/sample/step_completion.h"
#include "sim_fixture.h"
#include "test_recorder_read.h"
#include "test_recorder_synthetic.h"

#define CONTACTS "/connectivity/contacts"

struct shown {
    const char *name, *unit;
    int column, width; /* width 1 or 3 */
};

/* Fields that a law is to show. */
static const struct law_case {
    const char *name, *material;
    struct shown shown[5]; /* name NULL: the end */
} law_cases[] = {
    {"linear", "kn_n_per_m = 1e5;", {{0}}},
    {"linear, friction", "kn_n_per_m = 1e5; mu_s = 0.3; kt_n_per_m = 2e4;", {{"spring", "m", HISTORY_SPRING, 3}, {0}}},
    {"hysteretic, friction",
     "law = \"hysteretic\"; k1_n_per_m = 1e5; k2_n_per_m = 2e5; kc_n_per_m = 5e4; mu_s = 0.3; kt_n_per_m = 2e4;",
     {{"max_overlap", "m", HISTORY_MAX_OVERLAP, 1}, {"spring", "m", HISTORY_SPRING, 3}, {0}}},
    {"elastoplastic",
     "law = \"elastoplastic\"; k1_n_per_m = 1e5; kp_n_per_m = 2e5; phi_f = 0.05;",
     {{"max_overlap", "m", HISTORY_MAX_OVERLAP, 1}, {0}}},
    {"hertz, friction",
     "law = \"hertz\"; youngs_modulus_pa = 1e8; poisson_ratio = 0.3; mu_s = 0.3;",
     {{"tangential_force", "N", HISTORY_FORCE, 3}, {"contact_radius", "m", HISTORY_CONTACT_RADIUS, 1}, {0}}},
    {"linear, rolling alone",
     "kn_n_per_m = 1e5; mu_s = 0.3; kt_n_per_m = 2e4; mu_rolling = 0.2; kr_n_per_m = 2e4;",
     {{"spring", "m", HISTORY_SPRING, 3}, {"rolling_spring", "m", HISTORY_ROLLING, 3}, {0}}},
    {"linear, rolling and torsion",
     "kn_n_per_m = 1e5; mu_s = 0.3; kt_n_per_m = 2e4; mu_rolling = 0.2; kr_n_per_m = 2e4; mu_torsion = 0.1; "
     "ko_n_per_m = 2e4;",
     {{"spring", "m", HISTORY_SPRING, 3},
      {"rolling_spring", "m", HISTORY_ROLLING, 3},
      {"torsion_spring", "m", HISTORY_TORSION, 1},
      {0}}},
};

/* Particles that move and touch many others, 20 steps on, some of them after a renumbering. */
static struct fixture moving(int dimension, bool mixed, bool recorded, const char *material)
{
    char text[2048];
    snprintf(
        text, sizeof text,
        "dimension = %d; precision = \"%s\"; neighbor = { renumber_steps = 8; };\nrecord = { contact_history = %s; "
        "};\n"
        "sample = { count = 64; radius_min_m = 1e-3; radius_max_m = 1e-3; density_kg_per_m3 = 2000.0; gap_ratio = "
        "0.01; speed_m_per_s = 0.1; };\n"
        "material = { %s };\nstages = ( { name = \"a\"; dt_s = 1e-7; duration_s = 1.0; } );\n",
        dimension, mixed ? "mixed" : "double", recorded ? "true" : "false", material);
    struct fixture f = fixture_from_text(text);
    struct particles *p = &f.sample->particles;
    for (int k = 0; k < p->count; k++) {
        p->radius[k] = 1.02e-3; /* the lattice's spacing is 2.02 mm */
        for (int c = 0; c < p->n_rotations; c++)
            p->omega[c][k] = 10.0 * ((k + c) % 7 - 3);
    }
    fixture_start(&f);
    fixture_steps(&f, 20);
    return f;
}

/* Starts and frames as a run records them, into a log, and from that run.h5. */
static void record(struct sample *sample, const char *directory)
{
    char log[80], url[128];
    struct bus bus;
    struct record_sender *stream;
    struct records records;
    struct record_receiver *recording;
    snprintf(log, sizeof log, "%s/in.lcm", directory);
    snprintf(url, sizeof url, "file://%s?mode=w", log);
    must(bus_open(&bus, url));
    must(record_sender_create(&stream, &bus, 1, 1));
    records_init(&records, stream, 1);
    must(records_send_start(&records, sample, NULL, NULL));
    must(records_send_frame(&records, sample_complete(sample)));
    must(bus_flush(&bus));
    record_sender_free(stream);
    bus_close(&bus);
    const struct record_receiver_options options = {.directory = directory, .any_run = true, .from_log = true};
    must(record_receiver_create(&recording, &options));
    assert_int_equal(convert_log(recording, log), STATUS_INCOMPLETE); /* no END */
    assert_int_equal(record_receiver_drops(recording)->malformed, 0);
    record_receiver_free(recording);
    assert_int_equal(unlink(log), 0);
}

/* The member of list l that is between ids i and j (j < 0: the wall's). */
static int member_of(const struct sample *sample, int l, int i, int j)
{
    const struct contact_list *list = sample_list(sample, l);
    const int32_t *id = sample->particles.id;
    for (int k = 0; k < list->count; k++) {
        const int a = id[list->i[k]], b = l ? j : id[list->j[k]];
        if ((a == i && b == j) || (a == j && b == i))
            return k;
    }
    fail_msg("no contact of %d and %d", i, j);
    return -1;
}

/* What run.h5 is to say of a field of the contact of i and j: that of i against j, in 2D a tangent along (-n_z, 0, n_x)
 * and a rotation about +y where the simulator's is about x cross z = -y. Returns whether the list has j before i. */
static bool expected(const struct sample *sample, const struct shown *shown, int i, int j, double value[3])
{
    const int l = j < 0 ? -j : 0, k = member_of(sample, l, i, j);
    const struct contact_list *list = sample_list(sample, l);
    const bool turned = sample->particles.id[list->i[k]] != i;
    const double sign = turned ? -1 : 1;
    const struct contact_geometry g = contact_geometry_at(sample, l, k);
    const double first = contact_list_whole(list, shown->column, k);
    value[0] = value[1] = value[2] = 0;
    if (shown->width == 1) {
        value[0] = first;
    } else if (sample->particles.dimension == 3) {
        for (int c = 0; c < 3; c++)
            value[c] = sign * contact_list_whole(list, shown->column + c, k);
    } else if (shown->column == HISTORY_ROLLING) {
        value[1] = -sign * first;
    } else {
        value[0] = -sign * g.n[1] * first;
        value[2] = sign * g.n[0] * first;
    }
    return turned;
}

/* Returns how many contacts were the other way round in the list. */
static int check_field(hid_t file, const struct sample *sample, const struct shown *shown)
{
    char path[128];
    snprintf(path, sizeof path, CONTACTS "/history/%s", shown->name);
    const long rows = read_rows(file, path);
    assert_int_equal(rows, read_rows(file, CONTACTS "/pair"));
    assert_true(read_text_is(file, path, "unit_si", shown->unit));
    double *value = read_values(file, path), *pair = read_values(file, CONTACTS "/pair");
    int turned = 0, other_than_zero = 0;
    for (long row = 0; row < rows; row++) {
        double right[3];
        turned += expected(sample, shown, (int)pair[2 * row], (int)pair[2 * row + 1], right);
        for (int c = 0; c < shown->width; c++) {
            other_than_zero += right[c] != 0;
            assert_true(value[shown->width * row + c] == right[c]);
        }
    }
    assert_true(rows > 64 && other_than_zero > rows / 2);
    free(value);
    free(pair);
    return turned;
}

/* Members of the group of histories; none without the group. */
static int fields_in(hid_t file)
{
    H5G_info_t info;
    if (H5Lexists(file, CONTACTS "/history", H5P_DEFAULT) <= 0)
        return 0;
    assert_true(H5Gget_info_by_name(file, CONTACTS "/history", &info, H5P_DEFAULT) >= 0);
    return (int)info.nlinks;
}

static void check_law(const struct law_case *law, int dimension, bool mixed)
{
    char directory[64];
    int n = 0, turned = 0;
    struct fixture f = moving(dimension, mixed, true, law->material);
    print_message("%s, %dD, %s\n", law->name, dimension, mixed ? "mixed" : "double");
    synthetic_directory(directory);
    record(f.sample, directory);
    hid_t file = read_open(directory);
    for (const struct shown *shown = law->shown; shown->name; shown++) {
        if (dimension == 2 && shown->column == HISTORY_TORSION) /* 3D only */
            continue;
        turned += check_field(file, f.sample, shown);
        n++;
    }
    assert_int_equal(fields_in(file), n);
    assert_true(n == 0 || turned > 0);
    assert_true(H5Fclose(file) >= 0);
    synthetic_directory_remove(directory);
    fixture_close(&f);
}

static void frames_hold_the_state(void **state)
{
    (void)state;
    for (size_t k = 0; k < sizeof law_cases / sizeof *law_cases; k++)
        for (int run = 0; run < 4; run++)
            check_law(&law_cases[k], 2 + run % 2, run >= 2);
}

/* record.contact_history = false: the rest of the frame alone. */
static void histories_can_be_left_out(void **state)
{
    char directory[64];
    struct fixture f = moving(3, false, false, law_cases[6].material);
    (void)state;
    synthetic_directory(directory);
    record(f.sample, directory);
    hid_t file = read_open(directory);
    assert_int_equal(fields_in(file), 0);
    assert_true(read_rows(file, CONTACTS "/tangential_force") > 64);
    assert_true(H5Fclose(file) >= 0);
    synthetic_directory_remove(directory);
    fixture_close(&f);
}

/* Two particles that stick, one moved along z on the other: i against j, so that the spring of 0 against 1 is the way
 * that 0 went, v t of the half steps, and the force on it goes the other way, kt times that. */
static void spring_is_the_way_that_i_went(void **state)
{
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++) {
        const double speed = 1e-3, dt_s = 1e-7, kt = 2e4;
        const int steps = 10;
        const struct fixture_options options = {
            .dimension = dimension, .dt_s = dt_s, .material = "kn_n_per_m = 1e5; mu_s = 100; kt_n_per_m = 2e4;"};
        char directory[64];
        struct fixture f = fixture_pair(&options, 1e-5, 0);
        f.sample->particles.v[dimension - 1][0] = speed;
        must(sample_build_lists(f.sample));
        fixture_steps(&f, steps);
        synthetic_directory(directory);
        record(f.sample, directory);
        hid_t file = read_open(directory);
        double *spring = read_values(file, CONTACTS "/history/spring");
        double *force = read_values(file, CONTACTS "/tangential_force");
        double *pair = read_values(file, CONTACTS "/pair");
        assert_true(read_rows(file, CONTACTS "/pair") == 1 && pair[0] == 0 && pair[1] == 1);
        /* one step more or less, as the spring is half a step ahead; the force slows the motion by (kt/m) t^2/2, 1e-3,
         * and the pair turns by v t/(2 a), 1e-6 */
        assert_close("spring", spring[2], speed * dt_s * steps, speed * dt_s + 2e-3 * speed * dt_s * steps);
        assert_close("across", spring[1], 0, 0);
        assert_close("along n", spring[0], 0, 1e-5 * spring[2]);
        assert_close("force", force[2], -kt * spring[2], kt * speed * dt_s);
        assert_true(force[2] < 0);
        free(spring);
        free(force);
        free(pair);
        assert_true(H5Fclose(file) >= 0);
        synthetic_directory_remove(directory);
        fixture_close(&f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_hold_the_state),
        cmocka_unit_test(histories_can_be_left_out),
        cmocka_unit_test(spring_is_the_way_that_i_went),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
