/* The recorder without a bus: decoding, what comes early or twice, run.h5, run.xdmf. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "common/coupling.h"
#include "common/history_kind.h"
#include "common/message.h"
#include "recorder/frame_observables.h"
#include "recorder/log_conversion.h"
#include "test_recorder_read.h"
#include "test_recorder_synthetic.h"

/* A run, a directory, and a recording into it. */
struct bench {
    char directory[64];
    struct synthetic_run run;
    struct record_receiver *recording;
};

static void bench_open(struct bench *bench, const struct synthetic_options *options)
{
    synthetic_directory(bench->directory);
    synthetic_create(&bench->run, options);
    const struct record_receiver_options recording = {
        .directory = bench->directory, .run_id = options->run_id, .remake = convert_into};
    assert_int_equal(record_receiver_create(&bench->recording, &recording), STATUS_OK);
}

/* With so many exchanges recorded. */
static void bench_open_walls(struct bench *bench, int n_exchanges)
{
    struct synthetic_options options = synthetic_default;
    options.walls = true;
    options.n_wall_states = n_exchanges;
    bench_open(bench, &options);
}

static void bench_close(struct bench *bench)
{
    record_receiver_free(bench->recording);
    synthetic_free(&bench->run);
    synthetic_directory_remove(bench->directory);
}

static enum recording_answer give_bytes(struct bench *bench, int kind, const void *data, size_t size)
{
    enum recording_answer answer;
    assert_int_equal(record_receiver_take(bench->recording, kind, data, size, &answer), STATUS_OK);
    return answer;
}

static enum recording_answer give(struct bench *bench, const struct synthetic_message *message)
{
    return give_bytes(bench, message->kind, message->data, message->size);
}

static void give_all(struct bench *bench)
{
    for (size_t k = 0; k < bench->run.count; k++)
        give(bench, &bench->run.messages[k]);
}

/* The place of the n-th message of a kind. */
static size_t find(const struct synthetic_run *run, int kind, int n)
{
    for (size_t k = 0; k < run->count; k++) {
        if (run->messages[k].kind == kind && n-- == 0)
            return k;
    }
    fail_msg("no such message");
    return 0;
}

static void check_samples(hid_t file, const struct synthetic_options *options)
{
    double *strain = read_values(file, "/samples/strain/value");
    double *step = read_values(file, "/samples/strain/step");
    double *time_s = read_values(file, "/samples/stage/time");
    double *contacts = read_values(file, "/samples/n_contacts/value");
    double *last = read_values(file, "/samples/interface_residual_j/value");
    assert_int_equal(read_rows(file, "/samples/strain/value"), options->n_samples);
    for (int s = 0; s < options->n_samples; s++) {
        for (int axis = 0; axis < options->dimension; axis++)
            assert_true(strain[s * options->dimension + axis] == synthetic_strain(s, axis));
        assert_true(step[s] == 10 * s && time_s[s] == 1e-3 * s && contacts[s] == 100 + s && last[s] == -1.0 - s);
    }
    free(strain);
    free(step);
    free(time_s);
    free(contacts);
    free(last);
}

static void check_frames(hid_t file, const struct synthetic_options *options)
{
    double *position = read_values(file, "/particles/trajectory/position/value");
    double *velocity = read_values(file, "/particles/trajectory/velocity/value");
    double *edges = read_values(file, "/particles/trajectory/box/edges/value");
    double *lo = read_values(file, "/frames/box_lo");
    int n = options->n_particles, d = options->dimension;
    double thickness = 2.0 * (1e-3 + 96e-6); /* 2D: twice the largest radius */
    assert_int_equal(read_rows(file, "/particles/trajectory/position/value"), options->n_frames);
    for (int k = 0; k < options->n_frames * n; k++) {
        const double *row = position + 3 * k;
        assert_true(row[0] == synthetic_position(k / n, k % n, 0));
        assert_true(row[1] == (d == 3 ? synthetic_position(k / n, k % n, 1) : 0.0));
        assert_true(row[2] == synthetic_position(k / n, k % n, d - 1));
        assert_true(velocity[3 * k] == -row[0] && velocity[3 * k + 2] == -row[2]);
    }
    for (int f = 0; f < options->n_frames; f++) {
        assert_true(edges[9 * f] == 2.0 && edges[9 * f + 8] == 4.0 && edges[9 * f + 1] == 0.0);
        assert_true(fabs(edges[9 * f + 4] - (d == 3 ? 3.0 : thickness)) < 1e-15); /* one rounding of the sum */
        assert_true(lo[3 * f] == -1.0 && lo[3 * f + 2] == -3.0);
        assert_true(lo[3 * f + 1] == (d == 3 ? -2.0 : -0.5 * thickness));
    }
    free(position);
    free(velocity);
    free(edges);
    free(lo);
}

/* The frames' samples: frame f is at step 100 f, sample s at step 10 s. */
static void check_observables(hid_t file, const struct synthetic_options *options)
{
    double *strain = read_values(file, "/observables/strain/value");
    double *step = read_values(file, "/observables/strain/step");
    const int rows = options->n_samples > 0 ? options->n_frames : 0;
    assert_int_equal(read_rows(file, "/observables/strain/value"), rows);
    assert_int_equal(read_rows(file, "/observables/stage/time"), rows);
    for (int f = 0; f < rows; f++) {
        const int sample = 10 * f < options->n_samples ? 10 * f : options->n_samples - 1;
        assert_true(step[f] == 10 * sample);
        for (int axis = 0; axis < options->dimension; axis++)
            assert_true(strain[f * options->dimension + axis] == synthetic_strain(sample, axis));
    }
    free(strain);
    free(step);
}

static void check_contacts(hid_t file, const struct synthetic_run *run)
{
    double *offset = read_values(file, "/connectivity/contacts/offset");
    double *overlap = read_values(file, "/connectivity/contacts/overlap");
    double *pair = read_values(file, "/connectivity/contacts/pair");
    double *normal = read_values(file, "/connectivity/contacts/normal");
    assert_int_equal(read_rows(file, "/connectivity/contacts/offset"), run->options.n_frames + 1);
    assert_true(offset[0] == 0.0);
    for (int f = 0; f < run->options.n_frames; f++) {
        long start = (long)offset[f];
        assert_int_equal((long)offset[f + 1] - start, synthetic_contacts(run, f));
        for (int c = 0; c < synthetic_contacts(run, f); c++) {
            assert_true(overlap[start + c] == synthetic_overlap(f, c));
            assert_true(pair[2 * (start + c)] == c % (run->options.n_particles - 1));
            assert_true(normal[3 * (start + c) + 2] == run->options.dimension - 0.5);
        }
    }
    free(offset);
    free(overlap);
    free(pair);
    free(normal);
}

static void check_walls(hid_t file, const struct synthetic_options *options)
{
    double *force = read_values(file, "/walls/state/force_n");
    double *step = read_values(file, "/walls/command/step");
    int n_walls = 2 * options->dimension;
    assert_int_equal(read_rows(file, "/walls/state/force_n"), options->n_wall_states);
    assert_int_equal(read_rows(file, "/walls/command/step"), options->n_wall_states);
    for (int k = 0; k < options->n_wall_states; k++) {
        assert_true(step[k] == 5 * k);
        for (int w = 0; w < n_walls; w++)
            assert_true(force[k * n_walls + w] == synthetic_wall_force(k, w));
    }
    free(force);
    free(step);
}

/* Everything of the synthetic run is in the file, once, and the file says that it is complete. */
static void check_notes(hid_t file)
{
    static const char *const lines[] = {"only;note;at rest", "on,ly;doubtful;residual 2 %"};
    hid_t set = H5Dopen2(file, "/notes", H5P_DEFAULT), type = H5Dget_type(set), space = H5Dget_space(set);
    assert_int_equal(H5Sget_simple_extent_npoints(space), 2);
    const size_t size = H5Tget_size(type);
    char *texts = calloc(2, size);
    assert_non_null(texts);
    assert_true(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, texts) >= 0);
    for (size_t k = 0; k < 2; k++)
        assert_string_equal(texts + k * size, lines[k]);
    free(texts);
    assert_true(H5Sclose(space) >= 0 && H5Tclose(type) >= 0 && H5Dclose(set) >= 0);
}

static void check_run(const struct bench *bench)
{
    const struct synthetic_options *options = &bench->run.options;
    hid_t file = read_open(bench->directory);
    check_samples(file, options);
    check_observables(file, options);
    check_frames(file, options);
    check_contacts(file, &bench->run);
    if (options->walls)
        check_walls(file, options);
    else
        assert_int_equal(read_rows(file, "/walls/state/step"), -1);
    assert_true(read_attribute(file, "/", "complete") == 1.0);
    double *complete = read_values(file, "/run/complete"), *seed = read_values(file, "/run/seed");
    double *status = read_values(file, "/run/status");
    assert_true(*complete == 1.0 && *seed == 7.0 && *status == 0.0);
    free(complete);
    free(seed);
    free(status);
    assert_true(read_attribute(file, "/", "state_hash") == 0x1234);
    assert_true(read_attribute(file, "/parameters", "n_particles") == options->n_particles);
    assert_true(read_attribute(file, "/parameters", "run_id") == (double)options->run_id);
    assert_true(read_text_is(file, "/parameters", "scene_text", "# \xc3\xbc"));
    assert_true(read_text_is(file, "/", "reason", ""));
    check_notes(file);
    assert_true(H5Fclose(file) >= 0);
}

static void finish_complete(struct bench *bench)
{
    assert_true(record_receiver_end_matches(bench->recording));
    assert_int_equal(record_receiver_finish(bench->recording), STATUS_OK);
    assert_true(record_receiver_is_complete(bench->recording));
    check_run(bench);
}

static void run_round_trip(const struct synthetic_options *options)
{
    struct bench bench;
    bench_open(&bench, options);
    give_all(&bench);
    finish_complete(&bench);
    bench_close(&bench);
}

static void test_round_trip(void **state)
{
    (void)state;
    struct synthetic_options options = synthetic_default;
    run_round_trip(&options);
    options.n_samples = 700; /* more than two blocks */
    options.walls = true;
    options.n_wall_states = 3000; /* not a whole number of blocks */
    run_round_trip(&options);
    options.dimension = 3;
    options.frictional = true;
    run_round_trip(&options);
    options.n_frames = options.n_samples = options.n_wall_states = 0;
    run_round_trip(&options);
}

static void test_friction_columns(void **state)
{
    struct bench bench;
    struct synthetic_options options = synthetic_default;
    (void)state;
    options.frictional = true;
    bench_open(&bench, &options);
    give_all(&bench);
    finish_complete(&bench);
    hid_t file = read_open(bench.directory);
    double *spin = read_values(file, "/particles/trajectory/angular_velocity/value");
    double *sliding = read_values(file, "/connectivity/contacts/sliding");
    /* The generator's k-th value, which is about y in 2D. */
    assert_true(spin[3 * 7] == 0.0 && spin[3 * 7 + 1] == -synthetic_position(0, 3, 1) && spin[3 * 7 + 2] == 0.0);
    assert_true(sliding[0] == 0.0 && sliding[1] == 1.0);
    free(spin);
    free(sliding);
    assert_true(H5Fclose(file) >= 0);
    bench_close(&bench);
}

/* Numbers, vectors and rotations that contacts remember, in 2D and 3D. */
static void check_history(int dimension)
{
    struct bench bench;
    struct synthetic_options options = synthetic_default;
    options.frictional = true;
    options.dimension = dimension;
    bench_open(&bench, &options);
    give_all(&bench);
    finish_complete(&bench);
    hid_t file = read_open(bench.directory);
    double *depth = read_values(file, "/connectivity/contacts/history/depth");
    double *overlap = read_values(file, "/connectivity/contacts/overlap");
    double *way = read_values(file, "/connectivity/contacts/history/way");
    double *normal = read_values(file, "/connectivity/contacts/normal");
    double *roll = read_values(file, "/connectivity/contacts/history/roll");
    const long rows = read_rows(file, "/connectivity/contacts/overlap");
    assert_true(rows > 100 && read_rows(file, "/connectivity/contacts/history/depth") == rows);
    assert_true(read_text_is(file, "/connectivity/contacts/history/way", "unit_si", "N"));
    for (long k = 0; k < rows; k++) {
        assert_true(depth[k] == overlap[k]);
        for (int c = 0; c < 3; c++)
            assert_true(way[3 * k + c] == normal[3 * k + c]);
        for (int c = 0; c < 3; c++)
            assert_true(roll[3 * k + c] == (dimension == 3 ? -(c + 0.5) : c == 1 ? -0.5 : 0.0));
    }
    free(depth);
    free(overlap);
    free(way);
    free(normal);
    free(roll);
    assert_true(H5Fclose(file) >= 0);
    bench_close(&bench);
}

static void test_history(void **state)
{
    (void)state;
    check_history(2);
    check_history(3);
}

/* Encodes and decodes. */
static enum status decoded(shakedown_run_info_t *info)
{
    unsigned char bytes[4096];
    union message message;
    const int size = shakedown_run_info_t_encode(bytes, 0, sizeof bytes, info);
    assert_true(size > 0);
    const enum status status = message_decode(RECORD_RUN_INFO, bytes, (size_t)size, &message);
    if (status == STATUS_OK)
        message_free(RECORD_RUN_INFO, &message);
    return status;
}

/* Names become those of datasets: neither paths nor twice the same. */
static void test_bad_history(void **state)
{
    static const char *const bad_names[] = {
        "", "../walls", "a/b", "spring ", "other", "a_name_that_is_longer_than_any_that_a_law_may_have"};
    char *name[] = {"spring", "other"}, *unit[] = {"m", "N"};
    int8_t kind[] = {HISTORY_TANGENT, HISTORY_NUMBER};
    shakedown_run_info_t info = {.name = "",
                                 .version = "",
                                 .kernel_set = "",
                                 .scene_text = "",
                                 .effective_config = "",
                                 .controller = "",
                                 .dimension = 3,
                                 .n_particles = 1,
                                 .n_history = 2,
                                 .history_name = name,
                                 .history_unit = unit,
                                 .history_kind = kind};
    struct bench bench;
    (void)state;
    assert_int_equal(decoded(&info), STATUS_OK);
    for (size_t k = 0; k < sizeof bad_names / sizeof *bad_names; k++) {
        name[0] = (char *)(uintptr_t)bad_names[k];
        assert_int_equal(decoded(&info), STATUS_FORMAT);
    }
    name[0] = "spring";
    kind[1] = HISTORY_KINDS;
    assert_int_equal(decoded(&info), STATUS_FORMAT);
    kind[1] = HISTORY_NUMBER;
    unit[0] = "a unit that no law has";
    assert_int_equal(decoded(&info), STATUS_FORMAT);

    /* a chunk that says less than RUN_INFO promised is no part of the run */
    struct synthetic_options options = synthetic_default;
    options.frictional = true;
    bench_open(&bench, &options);
    const size_t at = find(&bench.run, RECORD_FRAME_CONTACTS, 1);
    for (size_t k = 0; k < at; k++)
        give(&bench, &bench.run.messages[k]);
    union message chunk;
    unsigned char bytes[BUS_MESSAGE_MAX];
    const struct synthetic_message *whole = &bench.run.messages[at];
    assert_int_equal(message_decode(whole->kind, whole->data, whole->size, &chunk), STATUS_OK);
    assert_true(chunk.frame_contacts.n_history > 0);
    chunk.frame_contacts.n_history--;
    const int size = shakedown_frame_contacts_t_encode(bytes, 0, sizeof bytes, &chunk.frame_contacts);
    give_bytes(&bench, whole->kind, bytes, (size_t)size);
    assert_int_equal(record_receiver_drops(bench.recording)->malformed, 1);
    chunk.frame_contacts.n_history++;
    message_free(whole->kind, &chunk);
    give_all(&bench);
    finish_complete(&bench);
    bench_close(&bench);
}

static void test_gaps_and_repeats(void **state)
{
    struct bench bench;
    uint64_t random = 1;
    (void)state;
    bench_open(&bench, &synthetic_default);
    /* A sender that repeats everything over a bus that loses one of four messages and doubles one of four. */
    for (int round = 0; round < 200 && !record_receiver_end_matches(bench.recording); round++) {
        int64_t seen[RECORD_CHANNELS] = {0};
        struct record_receiver_ack ack;
        record_receiver_ack(bench.recording, &ack);
        for (size_t k = 0; k < bench.run.count; k++) {
            const struct synthetic_message *message = &bench.run.messages[k];
            uint64_t dice = synthetic_random(&random) % 4;
            if (seen[message->kind]++ < ack.next_seq[message->kind] || dice == 0)
                continue;
            give(&bench, message);
            if (dice == 1)
                give(&bench, message);
        }
    }
    assert_true(record_receiver_drops(bench.recording)->repeated > 0);
    assert_true(record_receiver_drops(bench.recording)->early > 0);
    assert_int_equal(record_receiver_drops(bench.recording)->malformed, 0);
    finish_complete(&bench);
    bench_close(&bench);
}

static void test_answers(void **state)
{
    struct bench bench;
    (void)state;
    bench_open(&bench, &synthetic_default);
    const struct synthetic_message *messages = bench.run.messages;
    size_t sample = find(&bench.run, RECORD_SAMPLE, 0);
    assert_int_equal(give(&bench, &messages[sample]), ANSWER_NOW); /* before RUN_INFO */
    assert_int_equal(give(&bench, &messages[0]), ANSWER_NOW);
    assert_int_equal(give(&bench, &messages[find(&bench.run, RECORD_FRAME_PARTICLES, 0)]), ANSWER_NOW); /* no radii */
    assert_int_equal(give(&bench, &messages[sample]), ANSWER_NOW); /* was kept, and taken after RUN_INFO */
    assert_int_equal(give(&bench, &messages[sample + 1]), ANSWER_SOON);
    assert_int_equal(give(&bench, &messages[sample + 1]), ANSWER_NOW); /* again */
    assert_int_equal(give(&bench, &messages[sample + 3]), ANSWER_NOW); /* gap */
    assert_int_equal(give(&bench, &messages[bench.run.count - 1]), ANSWER_NOW);
    assert_false(record_receiver_end_matches(bench.recording));
    give_all(&bench);
    finish_complete(&bench);
    struct record_receiver_ack ack;
    record_receiver_ack(bench.recording, &ack);
    assert_true(ack.message.complete && ack.message.n_held == 0);
    assert_true(ack.next_seq[RECORD_SAMPLE] == synthetic_default.n_samples && ack.next_seq[RECORD_END] == 1);
    bench_close(&bench);
}

static void test_foreign_and_oversized(void **state)
{
    struct bench bench;
    struct synthetic_run other;
    struct synthetic_options options = synthetic_default;
    (void)state;
    bench_open(&bench, &synthetic_default);
    options.run_id = 43;
    synthetic_create(&other, &options);
    unsigned char *large = calloc(1, BUS_MESSAGE_MAX + 1);
    for (size_t k = 0; k < bench.run.count; k++) {
        assert_int_equal(give(&bench, &other.messages[k]), ANSWER_NONE);
        assert_int_equal(give_bytes(&bench, RECORD_SAMPLE, large, BUS_MESSAGE_MAX + 1), ANSWER_NONE);
        give(&bench, &bench.run.messages[k]);
    }
    assert_int_equal(record_receiver_drops(bench.recording)->foreign, other.count);
    assert_int_equal(record_receiver_drops(bench.recording)->oversized, other.count);
    finish_complete(&bench);
    free(large);
    synthetic_free(&other);
    bench_close(&bench);
}

static void put_int(unsigned char *bytes, int32_t value)
{
    for (int k = 0; k < 4; k++)
        bytes[k] = (unsigned char)((uint32_t)value >> (24 - 8 * k));
}

/* Counts at which the generated decoders would read or write outside: they compute 8 n in an int. */
static void test_hostile_counts(void **state)
{
    static const int32_t counts[] = {-1, INT32_MIN, 0x20000001, 0x10000001, 0x40000001, INT32_MAX, 251};
    struct bench bench;
    (void)state;
    bench_open(&bench, &synthetic_default);
    for (size_t m = 0; m < bench.run.count; m++) {
        const struct synthetic_message *message = &bench.run.messages[m];
        unsigned char *bytes = malloc(message->size);
        assert_non_null(bytes);
        /* The header stays; every aligned or unaligned int after it in the front part is replaced in turn. */
        for (size_t at = 40; at + 4 <= message->size && at < 120; at++) {
            union message decoded;
            memcpy(bytes, message->data, message->size);
            put_int(bytes + at, counts[at % (sizeof counts / sizeof *counts)]);
            if (message_decode(message->kind, bytes, message->size, &decoded) == STATUS_OK)
                message_free(message->kind, &decoded);
        }
        free(bytes);
    }
    union message decoded;
    const struct synthetic_message *particles = &bench.run.messages[1];
    put_int(particles->data + 40 + 12, 0x20000001); /* `count` */
    assert_int_equal(message_decode(RECORD_PARTICLES, particles->data, particles->size, &decoded), STATUS_FORMAT);
    bench_close(&bench);
}

/* Random bytes anywhere: no crash, nothing but dropped or taken. What is only a wrong number is not seen here. */
static void test_fuzz_decode(void **state)
{
    struct synthetic_run run;
    uint64_t random = 2;
    (void)state;
    synthetic_create(&run, &synthetic_default);
    for (int round = 0; round < 50000; round++) {
        const struct synthetic_message *message = &run.messages[synthetic_random(&random) % run.count];
        unsigned char *bytes = malloc(message->size);
        assert_non_null(bytes);
        memcpy(bytes, message->data, message->size);
        size_t size = message->size;
        if (synthetic_random(&random) % 3 == 0)
            size = synthetic_random(&random) % (message->size + 1);
        for (uint64_t flips = synthetic_random(&random) % 8; flips > 0 && size > 8; flips--) {
            uint64_t place = synthetic_random(&random) % (size < 160 ? size : 160);
            bytes[place] = (unsigned char)synthetic_random(&random);
        }
        union message decoded;
        int kind = (int)(round % 16 == 0 ? synthetic_random(&random) % MESSAGE_LOGGED_KINDS : (uint64_t)message->kind);
        if (message_decode(kind, bytes, size, &decoded) == STATUS_OK)
            message_free(kind, &decoded);
        free(bytes);
    }
    synthetic_free(&run);
}

/* Spoils a copy in a way that can be seen: cut, longer, of another type, of another run, out of turn, bad counts. */
static size_t spoil(unsigned char *bytes, size_t size, uint64_t *random)
{
    switch (synthetic_random(random) % 5) {
    case 0:
        return synthetic_random(random) % size;
    case 1:
        bytes[size] = 0;
        return size + 1;
    case 2:
        bytes[synthetic_random(random) % 8] ^= 1 + synthetic_random(random) % 255;
        return size;
    case 3:
        bytes[8 + synthetic_random(random) % 16] ^= 1 + synthetic_random(random) % 255;
        return size;
    default:
        for (size_t k = 40; k < size; k++)
            bytes[k] = 0xff;
        return size;
    }
}

static void test_fuzz_recording(void **state)
{
    struct bench bench;
    uint64_t random = 3;
    (void)state;
    bench_open_walls(&bench, 100);
    for (size_t k = 0; k < bench.run.count; k++) {
        const struct synthetic_message *message = &bench.run.messages[k];
        for (int copy = 0; copy < 10; copy++) {
            unsigned char *bytes = malloc(message->size + 1);
            assert_non_null(bytes);
            memcpy(bytes, message->data, message->size);
            size_t size = spoil(bytes, message->size, &random);
            /* A wall message of full size is a good one, whatever its numbers are. */
            if (message->kind < RECORD_CHANNELS || size != message->size)
                give_bytes(&bench, message->kind, bytes, size);
            free(bytes);
        }
        give(&bench, message);
    }
    assert_true(record_receiver_drops(bench.recording)->malformed > 0);
    finish_complete(&bench);
    bench_close(&bench);
}

/* What cannot be recorded may have been changed on its way; when it comes again it is what the run says, and the run
 * shall not wait for anything better. */
static void test_what_cannot_be_recorded_comes_again(void **state)
{
    struct bench bench;
    struct synthetic_options options = synthetic_default;
    enum recording_answer answer;
    (void)state;
    options.unreadable = true;
    bench_open(&bench, &options);
    const struct synthetic_message *info = &bench.run.messages[0];
    give(&bench, info);
    assert_int_equal(record_receiver_drops(bench.recording)->malformed, 1);
    assert_false(record_receiver_has_run(bench.recording));
    give(&bench, &bench.run.messages[1]); /* others between the two change nothing */
    assert_int_equal(record_receiver_take(bench.recording, info->kind, info->data, info->size, &answer), STATUS_FORMAT);
    assert_non_null(strstr(status_message(), "RUN_INFO cannot be recorded"));
    assert_non_null(strstr(status_message(), "sample")); /* why */
    bench_close(&bench);
}

/* Messages that are right in themselves but do not fit the run. */
static void test_misfits(void **state)
{
    struct bench bench;
    struct synthetic_run other;
    struct synthetic_options options = synthetic_default;
    (void)state;
    bench_open(&bench, &synthetic_default);
    options.dimension = 3;
    options.n_particles = 260;
    synthetic_create(&other, &options);
    give(&bench, &bench.run.messages[0]);
    for (int kind = RECORD_PARTICLES; kind < RECORD_NOTE; kind++) {
        size_t last_chunk = kind == RECORD_PARTICLES ? 2 : 0; /* the one that would go beyond N */
        for (size_t k = 0; k < last_chunk; k++)
            give(&bench, &bench.run.messages[find(&bench.run, kind, (int)k)]);
        give(&bench, &other.messages[find(&other, kind, (int)last_chunk)]);
        assert_int_equal(record_receiver_drops(bench.recording)->malformed, kind);
        for (int k = (int)last_chunk; k < bench.run.next_seq[kind]; k++)
            give(&bench, &bench.run.messages[find(&bench.run, kind, k)]);
    }
    for (int k = 0; k < bench.run.next_seq[RECORD_NOTE]; k++)
        give(&bench, &bench.run.messages[find(&bench.run, RECORD_NOTE, k)]);
    give(&bench, &bench.run.messages[find(&bench.run, RECORD_CHECKPOINT, 0)]);
    give(&bench, &bench.run.messages[bench.run.count - 1]);
    finish_complete(&bench);
    synthetic_free(&other);
    bench_close(&bench);
}

/* One message is lost for good: the run is never complete, the file is readable and holds the rest. */
static void lose_one(int kind, int n)
{
    struct bench bench;
    bench_open_walls(&bench, 100);
    size_t lost = find(&bench.run, kind, n);
    for (int round = 0; round < 3; round++) {
        for (size_t k = 0; k < bench.run.count; k++) {
            if (k != lost)
                give(&bench, &bench.run.messages[k]);
        }
    }
    assert_false(record_receiver_end_matches(bench.recording));
    assert_int_equal(record_receiver_finish(bench.recording), STATUS_INCOMPLETE);
    if (kind == RECORD_RUN_INFO) { /* nothing could be kept */
        char path[128];
        snprintf(path, sizeof path, "%s/run.h5", bench.directory);
        assert_int_not_equal(access(path, F_OK), 0);
    } else {
        hid_t file = read_open(bench.directory);
        assert_true(read_attribute(file, "/", "complete") == 0.0);
        assert_true(H5Fclose(file) >= 0);
        assert_non_null(strstr(status_message(), kind == RECORD_END ? "END is missing" : message_channel(kind)));
    }
    bench_close(&bench);
}

static void test_never_complete(void **state)
{
    (void)state;
    for (int kind = 0; kind < MESSAGE_LOGGED_KINDS; kind++)
        lose_one(kind, 0);
    lose_one(RECORD_SAMPLE, 19); /* the last of a channel leaves no gap */
    lose_one(RECORD_FRAME_CONTACTS, 5);
    lose_one(MESSAGE_WALL_STATE, 99);
    lose_one(MESSAGE_WALL_COMMAND, 99);
}

static void test_walls_before_run_info_and_repeated(void **state)
{
    struct bench bench;
    (void)state;
    bench_open_walls(&bench, 50);
    for (int k = 0; k < 10; k++) {
        give(&bench, &bench.run.messages[find(&bench.run, MESSAGE_WALL_STATE, k)]);
        give(&bench, &bench.run.messages[find(&bench.run, MESSAGE_WALL_STATE, k)]);
        give(&bench, &bench.run.messages[find(&bench.run, MESSAGE_WALL_COMMAND, k)]);
    }
    give_all(&bench);
    assert_int_equal(record_receiver_drops(bench.recording)->repeated, 30);
    finish_complete(&bench);
    bench_close(&bench);
}

/* Commands may come before their states; nothing is lost, and copies of one that waits are copies. */
static void test_walls_early_records(void **state)
{
    struct bench bench;
    (void)state;
    bench_open_walls(&bench, 50);
    for (size_t k = 0; k < bench.run.count; k++) {
        const struct synthetic_message *message = &bench.run.messages[k];
        if (message->kind == MESSAGE_WALL_STATE) {
            assert_int_equal(message[1].kind, MESSAGE_WALL_COMMAND);
            give(&bench, &message[1]);
            give(&bench, &message[1]);
        }
        if (message->kind != MESSAGE_WALL_COMMAND)
            give(&bench, message);
    }
    assert_int_equal(record_receiver_drops(bench.recording)->repeated, 50);
    finish_complete(&bench);
    bench_close(&bench);
}

/* Windows of exchanges as a lossy bus hands them over: some messages missing, then all of the window again, back to
 * front. The record is as if nothing had been lost; a checkpoint waits for what is missing, and nothing is taken that
 * is far ahead. */
static void test_walls_lost_and_sent_again(void **state)
{
    struct bench bench;
    struct synthetic_options options = synthetic_default;
    uint64_t random = 11;
    (void)state;
    options.walls = true;
    options.n_samples = 0;
    options.n_wall_states = 5 * WALLS_WINDOW;
    bench_open(&bench, &options);
    const size_t first = find(&bench.run, MESSAGE_WALL_STATE, 0), window = 2 * WALLS_WINDOW;
    const size_t checkpoint = find(&bench.run, RECORD_CHECKPOINT, 0);
    for (size_t k = 0; k < first; k++)
        give(&bench, &bench.run.messages[k]);
    give(&bench, &bench.run.messages[first + window]);
    assert_int_equal(record_receiver_drops(bench.recording)->early, 1);
    for (size_t start = first; start < checkpoint; start += window) {
        for (size_t k = start; k < start + window; k++) {
            if (synthetic_random(&random) % 3 > 0)
                give(&bench, &bench.run.messages[k]);
        }
        assert_int_equal(give(&bench, &bench.run.messages[checkpoint]), ANSWER_NOW);
        for (size_t k = start + window; k-- > start;)
            give(&bench, &bench.run.messages[k]);
    }
    assert_int_equal(record_receiver_drops(bench.recording)->early, 6); /* each window's checkpoint came too early */
    give(&bench, &bench.run.messages[checkpoint]);
    give(&bench, &bench.run.messages[checkpoint + 1]);
    finish_complete(&bench);
    bench_close(&bench);
}

static int64_t wall_ack(const struct bench *bench)
{
    struct record_receiver_ack ack;
    record_receiver_ack(bench->recording, &ack);
    return ack.message.next_wall_seq;
}

/* Numbers that no sender of this run has: nothing is lost to them. */
static void test_walls_with_strange_numbers(void **state)
{
    static const int64_t strange[] = {-1, INT64_MIN, INT64_MAX, INT64_MAX / 2, WALLS_WINDOW + 1, 1000};
    struct bench bench;
    (void)state;
    bench_open_walls(&bench, 50);
    const size_t first = find(&bench.run, MESSAGE_WALL_STATE, 0);
    for (size_t k = 0; k < bench.run.count; k++) {
        give(&bench, &bench.run.messages[k]);
        for (size_t s = 0; k == first && s < sizeof strange / sizeof *strange; s++) {
            const struct synthetic_message *message = &bench.run.messages[first + s % 2];
            unsigned char bytes[WALL_MESSAGE_MAX];
            memcpy(bytes, message->data, message->size);
            for (int b = 0; b < 8; b++) /* seq, behind fingerprint and run_id */
                bytes[16 + b] = (unsigned char)((uint64_t)strange[s] >> (56 - 8 * b));
            assert_int_equal(give_bytes(&bench, message->kind, bytes, message->size), ANSWER_NOW);
        }
        if (k == first)
            assert_int_equal(wall_ack(&bench), 0); /* its command is still to come */
    }
    assert_int_equal(wall_ack(&bench), 50);
    finish_complete(&bench);
    bench_close(&bench);
}

static void test_walls_not_wanted(void **state)
{
    struct bench bench;
    struct synthetic_options options = synthetic_default;
    (void)state;
    options.n_wall_states = 50;
    bench_open(&bench, &options);
    give(&bench, &bench.run.messages[find(&bench.run, MESSAGE_WALL_STATE, 0)]);
    give_all(&bench);
    finish_complete(&bench);
    bench_close(&bench);
}

static void test_refuses_to_overwrite(void **state)
{
    struct bench bench;
    struct record_receiver *second;
    (void)state;
    bench_open(&bench, &synthetic_default);
    give_all(&bench);
    finish_complete(&bench);
    const struct record_receiver_options options = {.directory = bench.directory, .run_id = 1, .remake = convert_into};
    assert_int_equal(record_receiver_create(&second, &options), STATUS_IO);
    assert_non_null(strstr(status_message(), "never overwritten"));
    record_receiver_free(second);
    check_run(&bench);
    bench_close(&bench);
}

/* A second recorder for the same folder, while the first is at work. */
static void test_one_recorder_per_folder(void **state)
{
    struct bench bench;
    struct record_receiver *second;
    (void)state;
    bench_open(&bench, &synthetic_default);
    const struct record_receiver_options options = {.directory = bench.directory, .run_id = 1, .remake = convert_into};
    assert_int_equal(record_receiver_create(&second, &options), STATUS_IO);
    assert_non_null(strstr(status_message(), "another recorder"));
    record_receiver_free(second);
    give_all(&bench);
    finish_complete(&bench);
    bench_close(&bench);
}

/* Readers that are not ours: a command that reads run.h5, and is run while it is written. */
static const struct {
    const char *tool, *command;
} readers[] = {
    {"command -v h5ls", "h5ls -r %s/run.h5 | grep -q strain"},
    {"command -v h5dump", "h5dump -d /samples/strain/value %s/run.h5 | grep -q DATASPACE"},
    {"/usr/bin/python3 -c 'import h5py'",
     "/usr/bin/python3 -c 'import h5py,sys; h5py.File(sys.argv[1])[\"/samples/strain/value\"][:]' %s/run.h5"},
};

static void run_readers(const char *directory)
{
    for (size_t k = 0; k < sizeof readers / sizeof *readers; k++) {
        char command[512];
        snprintf(command, sizeof command, "%s >/dev/null 2>&1", readers[k].tool);
        if (system(command) != 0) {
            fprintf(stderr, "SKIPPED: %s\n", readers[k].tool);
            continue;
        }
        int length = snprintf(command, sizeof command, readers[k].command, directory);
        assert_true(length > 0 && (size_t)length < sizeof command);
        if (system(command) != 0)
            fail_msg("while it is written: %s", command);
    }
}

/* They read it after every flush, and one that has it open stops nobody. */
static void test_read_while_written(void **state)
{
    struct bench bench;
    (void)state;
    bench_open(&bench, &synthetic_default);
    for (size_t k = 0; k < bench.run.count; k++) {
        give(&bench, &bench.run.messages[k]);
        if (k % 16 != 8)
            continue;
        assert_int_equal(record_receiver_secure(bench.recording), STATUS_OK);
        record_receiver_publish(bench.recording);
        run_readers(bench.directory);
    }
    finish_complete(&bench);
    bench_close(&bench);
}

static void test_directory_cannot_be_made(void **state)
{
    struct record_receiver *recording;
    const struct record_receiver_options options = {.directory = "/dev/null/run", .run_id = 1};
    (void)state;
    assert_int_equal(record_receiver_create(&recording, &options), STATUS_IO);
    record_receiver_free(recording);
}

/* A reader that is not ours: the HDF5 tools, and an XML parser. */
static void test_other_readers(void **state)
{
    struct bench bench;
    char command[512], text[256] = "";
    (void)state;
    if (system("command -v h5dump >h5dump.txt && command -v xmllint >h5dump.txt") != 0) {
        fprintf(stderr, "SKIPPED: h5dump or xmllint is not installed\n");
        skip();
    }
    bench_open(&bench, &synthetic_default);
    give_all(&bench);
    finish_complete(&bench);
    snprintf(command, sizeof command, "h5dump %s/run.h5 >%s/h5dump.txt", bench.directory, bench.directory);
    assert_int_equal(system(command), 0);
    snprintf(command, sizeof command, "h5dump -y -w 1 -d /samples/strain/value %s/run.h5 | grep -c '^ *0.019, *$'",
             bench.directory);
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    assert_non_null(fgets(text, sizeof text, pipe));
    assert_int_equal(pclose(pipe), 0);
    assert_string_equal(text, "1\n"); /* strain x of the last sample */
    snprintf(command, sizeof command, "xmllint --noout %s/run.xdmf", bench.directory);
    assert_int_equal(system(command), 0);
    (void)remove("h5dump.txt");
    bench_close(&bench);
}

/* Every dataset that run.xdmf names is there, with the dimensions it says. */
static void test_xdmf_refers_to_what_is_there(void **state)
{
    struct bench bench;
    char path[128], line[512];
    int references = 0, times = 0;
    (void)state;
    bench_open(&bench, &synthetic_default);
    give_all(&bench);
    finish_complete(&bench);
    snprintf(path, sizeof path, "%s/run.xdmf", bench.directory);
    FILE *xdmf = fopen(path, "r");
    assert_non_null(xdmf);
    hid_t file = read_open(bench.directory);
    while (fgets(line, sizeof line, xdmf)) {
        char *name = strstr(line, "run.h5:");
        long rows = 0;
        times += strstr(line, "<Time Value") != NULL;
        if (!name)
            continue;
        *strchr(name, '<') = '\0';
        assert_int_equal(sscanf(strstr(line, "Dimensions=\"") + 12, "%ld", &rows), 1);
        assert_int_equal(read_rows(file, name + 7), rows);
        references++;
    }
    assert_int_equal(times, synthetic_default.n_frames);
    assert_int_equal(references, 6 * synthetic_default.n_frames); /* position, velocity, radius, mass, id twice */
    assert_int_equal(fclose(xdmf), 0);
    assert_true(H5Fclose(file) >= 0);
    bench_close(&bench);
}

/* Two stages that meet at step 20: a frame of each there, one between two samples, one whose sample is to come. */
static void test_frames_take_their_samples(void **state)
{
    const struct moment samples[] = {{0, 0}, {10, 0}, {20, 0}, {20, 1}, {30, 1}};
    const struct moment frames[] = {{20, 0}, {20, 1}, {25, 1}, {35, 1}};
    struct frame_observables observed = {0};
    int64_t sample = -1;
    (void)state;
    assert_false(frame_observables_next(&observed, true, &sample));
    for (int k = 0; k < 5; k++)
        assert_int_equal(frame_observables_sample(&observed, samples[k]), STATUS_OK);
    for (int k = 0; k < 4; k++)
        assert_int_equal(frame_observables_frame(&observed, frames[k]), STATUS_OK);
    for (int expected = 2; expected <= 3; expected++) {
        assert_true(frame_observables_next(&observed, false, &sample));
        assert_int_equal(sample, expected);
    }
    assert_true(frame_observables_next(&observed, false, &sample));
    assert_int_equal(sample, 3);
    assert_false(frame_observables_next(&observed, false, &sample)); /* one of step 35 may come */
    assert_true(frame_observables_next(&observed, true, &sample));
    assert_int_equal(sample, 4);
    assert_false(frame_observables_next(&observed, true, &sample));
    frame_observables_free(&observed);
}

/* The last record of a kind before the first CHECKPOINT; -1: there is none. */
static int last_before_checkpoint(const struct synthetic_run *run, int kind)
{
    int found = -1;
    for (size_t k = 0; k < find(run, RECORD_CHECKPOINT, 0); k++)
        found = run->messages[k].kind == kind ? (int)k : found;
    return found;
}

/* Whichever one record is missing, on whichever channel: neither CHECKPOINT nor END is taken before it is here. */
static void test_checkpoint_and_end_wait_for_all(void **state)
{
    int tried = 0;
    (void)state;
    for (int kind = RECORD_PARTICLES; kind < MESSAGE_LOGGED_KINDS; kind++) {
        struct bench bench;
        struct record_receiver_ack ack;
        bench_open_walls(&bench, 20);
        const int missing = last_before_checkpoint(&bench.run, kind);
        for (size_t k = 0; missing >= 0 && k < bench.run.count; k++) {
            if ((int)k != missing)
                give(&bench, &bench.run.messages[k]);
        }
        record_receiver_ack(bench.recording, &ack);
        assert_true(ack.next_seq[RECORD_CHECKPOINT] == 0 && ack.next_seq[RECORD_END] == 0);
        assert_false(record_receiver_end_matches(bench.recording));
        if (missing >= 0) {
            give(&bench, &bench.run.messages[missing]);
            give_all(&bench);
            record_receiver_ack(bench.recording, &ack);
            assert_true(ack.next_seq[RECORD_CHECKPOINT] == 1 && ack.next_seq[RECORD_END] == 1);
            finish_complete(&bench);
            tried++;
        }
        bench_close(&bench);
    }
    assert_true(tried >= 6); /* particles, samples, both kinds of frames, states and commands of the walls */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trip),
        cmocka_unit_test(test_friction_columns),
        cmocka_unit_test(test_history),
        cmocka_unit_test(test_bad_history),
        cmocka_unit_test(test_frames_take_their_samples),
        cmocka_unit_test(test_checkpoint_and_end_wait_for_all),
        cmocka_unit_test(test_gaps_and_repeats),
        cmocka_unit_test(test_answers),
        cmocka_unit_test(test_foreign_and_oversized),
        cmocka_unit_test(test_hostile_counts),
        cmocka_unit_test(test_fuzz_decode),
        cmocka_unit_test(test_fuzz_recording),
        cmocka_unit_test(test_misfits),
        cmocka_unit_test(test_what_cannot_be_recorded_comes_again),
        cmocka_unit_test(test_never_complete),
        cmocka_unit_test(test_walls_before_run_info_and_repeated),
        cmocka_unit_test(test_walls_early_records),
        cmocka_unit_test(test_walls_lost_and_sent_again),
        cmocka_unit_test(test_walls_with_strange_numbers),
        cmocka_unit_test(test_walls_not_wanted),
        cmocka_unit_test(test_refuses_to_overwrite),
        cmocka_unit_test(test_one_recorder_per_folder),
        cmocka_unit_test(test_read_while_written),
        cmocka_unit_test(test_directory_cannot_be_made),
        cmocka_unit_test(test_other_readers),
        cmocka_unit_test(test_xdmf_refers_to_what_is_there),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
