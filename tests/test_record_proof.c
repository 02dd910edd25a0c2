/* What proves that a record is whole: counts within messages, the form of the log, hashes and totals in CHECKPOINT and
 * END. Each check has a message here that only this check sees. */
#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "common/event_log.h"
#include "common/record_hash.h"
#include "common/wire.h"
#include "recorder/h5.h"
#include "recorder/log_conversion.h"
#include "recorder/run_frames.h"
#include "recorder/verify.h"
#include "test_recorder_synthetic.h"

enum { ENCODED_MAX = 8192 };

static const struct synthetic_message *nth(const struct synthetic_run *run, int kind, int n)
{
    for (size_t k = 0; k < run->count; k++) {
        if (run->messages[k].kind == kind && n-- == 0)
            return &run->messages[k];
    }
    fail_msg("no such message");
    return NULL;
}

/* --- Within a message --- */

static void expect_refused(int kind, const unsigned char *bytes, int size)
{
    union message decoded;
    assert_true(size > 0);
    assert_int_equal(message_decode(kind, bytes, (size_t)size, &decoded), STATUS_FORMAT);
    assert_non_null(strstr(status_message(), "counts do not agree"));
}

static void counts_of_frames_agree(void **state)
{
    struct synthetic_run run;
    union message message;
    unsigned char bytes[ENCODED_MAX];
    int8_t sliding = 1;
    (void)state;
    synthetic_create(&run, &synthetic_default);
    const struct synthetic_message *particles = nth(&run, RECORD_FRAME_PARTICLES, 0);
    assert_int_equal(message_decode(particles->kind, particles->data, particles->size, &message), STATUS_OK);
    shakedown_frame_particles_t *frame = &message.frame_particles;
    frame->chunk = frame->n_chunks;
    expect_refused(particles->kind, bytes, shakedown_frame_particles_t_encode(bytes, 0, sizeof bytes, frame));
    frame->chunk = 0;
    frame->count--; /* fewer particles than positions */
    expect_refused(particles->kind, bytes, shakedown_frame_particles_t_encode(bytes, 0, sizeof bytes, frame));
    frame->count++;
    message_free(particles->kind, &message);

    const struct synthetic_message *contacts = nth(&run, RECORD_FRAME_CONTACTS, 1);
    assert_int_equal(message_decode(contacts->kind, contacts->data, contacts->size, &message), STATUS_OK);
    shakedown_frame_contacts_t *chunk = &message.frame_contacts;
    int8_t *none = chunk->sliding;
    chunk->n_sliding = 1; /* of 100 contacts */
    chunk->sliding = &sliding;
    expect_refused(contacts->kind, bytes, shakedown_frame_contacts_t_encode(bytes, 0, sizeof bytes, chunk));
    chunk->n_sliding = 0;
    chunk->sliding = none;
    message_free(contacts->kind, &message);
    synthetic_free(&run);
}

/* Bytes behind a message, and texts that end before or after their length says. */
static void a_message_ends_where_it_ends(void **state)
{
    static const unsigned char one[] = "TYPEHASH\0\0\0\5\0\0\0\3ab";
    unsigned char bytes[sizeof one + 1];
    (void)state;
    assert_true(wire_check("is", one, sizeof one));
    memcpy(bytes, one, sizeof one);
    bytes[sizeof one] = 0;
    assert_false(wire_check("is", bytes, sizeof one + 1));
    assert_false(wire_check("is", one, sizeof one - 1));
    bytes[sizeof one - 3] = 0; /* "\0b": a shorter text */
    assert_false(wire_check("is", bytes, sizeof one));
    memcpy(bytes, "TYPEHASH\0\0\0\5\0\0\0\0", 16);
    assert_false(wire_check("is", bytes, 16)); /* without even its zero */
}

/* --- The log --- */

/* A channel's name must leave room for the zero behind it. This log has no checksums, which would find it first. */
static void a_long_channel_is_no_event(void **state)
{
    unsigned char bytes[28 + EVENT_CHANNEL_MAX] = {0xed, 0xa1, 0xda, 0x01};
    char path[] = "/tmp/test_record_proof.XXXXXX";
    struct event_reader reader;
    struct event event;
    bool found;
    (void)state;
    memset(bytes + 28, 'A', EVENT_CHANNEL_MAX);
    const int file = mkstemp(path);
    assert_true(file >= 0);
    for (unsigned char length = EVENT_CHANNEL_MAX - 1; length <= EVENT_CHANNEL_MAX; length++) {
        bytes[23] = length;
        assert_int_equal(pwrite(file, bytes, 28u + length, 0), 28 + length);
        assert_int_equal(event_reader_open(&reader, path), STATUS_OK);
        assert_int_equal(event_reader_next(&reader, &event, &found), STATUS_OK);
        assert_int_equal(found, length < EVENT_CHANNEL_MAX);
        assert_int_equal(reader.skipped_bytes > 0, length == EVENT_CHANNEL_MAX);
        event_reader_close(&reader);
    }
    assert_int_equal(close(file), 0);
    assert_int_equal(unlink(path), 0);
}

/* What a checkpoint knows of must be there; less is not filled up with zeros. */
static void a_log_is_cut_not_lengthened(void **state)
{
    char path[] = "/tmp/test_record_proof.XXXXXX";
    struct event_writer *writer;
    (void)state;
    const int file = mkstemp(path);
    assert_true(file >= 0);
    assert_int_equal(close(file), 0);
    assert_int_equal(event_writer_open(&writer, path, EVENT_START_NEW), STATUS_OK);
    assert_int_equal(event_writer_add(writer, "SAMPLE", "abc", 3), STATUS_OK);
    const int64_t size = event_writer_size(writer);
    assert_int_equal(event_writer_cut(writer, size + 1), STATUS_FORMAT);
    assert_int_equal(event_writer_size(writer), size);
    assert_int_equal(event_writer_cut(writer, size), STATUS_OK);
    assert_int_equal(event_writer_close(writer), STATUS_OK);
    assert_int_equal(unlink(path), 0);
}

/* --- The record as a whole --- */

struct bench {
    char directory[64];
    struct synthetic_run run;
    struct record_receiver *recording;
};

/* With 20 exchanges of the walls, and the CHECKPOINT behind all records or before most of them: then END is the only
 * one that counts these. */
static void bench_open(struct bench *bench, bool checkpoint_first)
{
    struct synthetic_options options = synthetic_default;
    options.walls = true;
    options.n_wall_states = 20;
    options.checkpoint_first = checkpoint_first;
    synthetic_directory(bench->directory);
    synthetic_create(&bench->run, &options);
    const struct record_receiver_options recording = {
        .directory = bench->directory, .run_id = options.run_id, .remake = convert_into};
    assert_int_equal(record_receiver_create(&bench->recording, &recording), STATUS_OK);
}

static void bench_close(struct bench *bench)
{
    record_receiver_free(bench->recording);
    synthetic_free(&bench->run);
    synthetic_directory_remove(bench->directory);
}

static void give(struct bench *bench, const struct synthetic_message *message)
{
    enum recording_answer answer;
    assert_int_equal(record_receiver_take(bench->recording, message->kind, message->data, message->size, &answer),
                     STATUS_OK);
}

/* A byte that may be any other: the last of time_s in the header; in frames, whose chunks have one time, of the last
 * velocity or normal, before the zero counts of what there is without friction. */
static size_t free_byte(const struct synthetic_message *message)
{
    return message->kind == RECORD_FRAME_PARTICLES  ? message->size - 5
           : message->kind == RECORD_FRAME_CONTACTS ? message->size - 13
                                                    : 39;
}

/* A bit of a record of a channel is another: it is of the right form, run and number. */
static void expect_another_record_found(int kind, bool checkpoint_first)
{
    const int n = kind == RECORD_FRAME_CONTACTS ? 1 : 0; /* frame 0 has none */
    struct bench bench;
    enum status status = STATUS_OK;
    enum recording_answer answer;
    bench_open(&bench, checkpoint_first);
    const struct synthetic_message *other = nth(&bench.run, kind, n);
    other->data[free_byte(other)] ^= 1;
    const size_t proof = bench.run.count - (checkpoint_first ? 1 : 2); /* END, or the CHECKPOINT before it */
    for (size_t k = 0; status == STATUS_OK && k <= proof; k++) {
        const struct synthetic_message *message = &bench.run.messages[k];
        status = record_receiver_take(bench.recording, message->kind, message->data, message->size, &answer);
    }
    assert_int_equal(status, STATUS_INCOMPLETE);
    assert_non_null(strstr(status_message(), record_channel_name[kind]));
    assert_non_null(strstr(status_message(), "not those that were sent"));
    assert_false(record_receiver_end_matches(bench.recording));
    bench_close(&bench);
}

static void checkpoint_and_end_know_each_record(void **state)
{
    (void)state;
    for (int kind = RECORD_RUN_INFO; kind < RECORD_CHECKPOINT; kind++)
        expect_another_record_found(kind, false);
    for (int kind = RECORD_SAMPLE; kind < RECORD_END; kind++) /* those behind the checkpoint, and itself */
        expect_another_record_found(kind, true);
}

/* Gives all but END and one message, if there is one, and then an END that counts `less` fewer records of a kind. */
static void expect_no_end(int missing_kind, int missing, int kind, int less)
{
    struct bench bench;
    union message message;
    unsigned char bytes[ENCODED_MAX];
    enum recording_answer answer;
    bench_open(&bench, true);
    const struct synthetic_message *lost = missing_kind < 0 ? NULL : nth(&bench.run, missing_kind, missing);
    const struct synthetic_message *last = &bench.run.messages[bench.run.count - 1];
    int64_t hash = RECORD_HASH_OF_NONE;
    for (const struct synthetic_message *each = bench.run.messages; each < last; each++) {
        if (each != lost)
            give(&bench, each);
        if (each != lost && each->kind == kind)
            hash = record_hash_add(hash, each->data, each->size);
    }
    assert_int_equal(message_decode(last->kind, last->data, last->size, &message), STATUS_OK);
    if (kind < RECORD_CHANNELS) {
        message.end.total[kind] -= less;
        message.end.hash[kind] = hash; /* so that nothing but the count, or what it leaves out, is wrong */
    }
    const int size = shakedown_end_t_encode(bytes, 0, sizeof bytes, &message.end);
    assert_true(size > 0);
    message_free(last->kind, &message);
    assert_int_equal(record_receiver_take(bench.recording, RECORD_END, bytes, (size_t)size, &answer), STATUS_OK);
    assert_false(record_receiver_end_matches(bench.recording));
    assert_int_equal(record_receiver_finish(bench.recording), STATUS_INCOMPLETE);
    bench_close(&bench);
}

static void end_counts_what_is_there(void **state)
{
    (void)state;
    for (int kind = RECORD_RUN_INFO; kind < RECORD_END; kind++)
        expect_no_end(-1, 0, kind, 1);                                   /* more is there than END counts */
    expect_no_end(RECORD_FRAME_PARTICLES, 8, RECORD_FRAME_PARTICLES, 1); /* the last chunk of a frame was never sent */
    expect_no_end(RECORD_FRAME_CONTACTS, 8, RECORD_FRAME_CONTACTS, 1);
    expect_no_end(MESSAGE_WALL_STATE, 19, MESSAGE_WALL_STATE, 0);
    expect_no_end(MESSAGE_WALL_COMMAND, 19, MESSAGE_WALL_COMMAND, 0);
}

/* The sender is told of what came early, so that it sends only what is missing. */
static void early_ones_are_kept(void **state)
{
    struct bench bench;
    struct record_receiver_ack ack;
    (void)state;
    bench_open(&bench, false);
    const size_t first = (size_t)(nth(&bench.run, RECORD_SAMPLE, 0) - bench.run.messages);
    for (size_t k = 0; k < first; k++)
        give(&bench, &bench.run.messages[k]);
    for (int early = 1; early <= 3; early++)
        give(&bench, nth(&bench.run, RECORD_SAMPLE, early));
    record_receiver_ack(bench.recording, &ack);
    assert_int_equal(ack.message.n_held, 3);
    for (int k = 0; k < 3; k++)
        assert_true(ack.held_channel[k] == RECORD_SAMPLE && ack.held_seq[k] == k + 1);
    give(&bench, nth(&bench.run, RECORD_SAMPLE, 0));
    record_receiver_ack(bench.recording, &ack);
    assert_true(ack.message.n_held == 0 && ack.next_seq[RECORD_SAMPLE] == 4);
    bench_close(&bench);
}

/* The last chunk of a frame in the place of the second: of the right run and number, and of that frame. */
static void chunks_come_in_their_order(void **state)
{
    enum { SEQ_END = 23 }; /* the last byte of seq in the header */
    (void)state;
    for (int kind = RECORD_FRAME_PARTICLES; kind <= RECORD_FRAME_CONTACTS; kind++) {
        struct bench bench;
        bench_open(&bench, false);
        const int n = kind == RECORD_FRAME_CONTACTS ? 2 : 1; /* frame 0 has one chunk of no contacts */
        const struct synthetic_message *second = nth(&bench.run, kind, n), *third = nth(&bench.run, kind, n + 1);
        for (const struct synthetic_message *each = bench.run.messages; each < second; each++)
            give(&bench, each);
        third->data[SEQ_END]--;
        give(&bench, third);
        assert_int_equal(record_receiver_drops(bench.recording)->malformed, 1);
        third->data[SEQ_END]++;
        give(&bench, second);
        give(&bench, third);
        assert_int_equal(record_receiver_drops(bench.recording)->malformed, 1);
        bench_close(&bench);
    }
}

/* --- A run that goes on from its CHECKPOINT --- */

/* Its RUN_INFO, which says that the record holds `more` samples than it does. */
static size_t encode_resumed(const struct synthetic_run *run, int64_t more, unsigned char bytes[ENCODED_MAX])
{
    union message checkpoint, info;
    const struct synthetic_message *first = &run->messages[0], *last = nth(run, RECORD_CHECKPOINT, 0);
    int64_t total[RECORD_CHANNELS] = {0};
    assert_int_equal(message_decode(first->kind, first->data, first->size, &info), STATUS_OK);
    assert_int_equal(message_decode(last->kind, last->data, last->size, &checkpoint), STATUS_OK);
    memcpy(total, checkpoint.checkpoint.total, sizeof total);
    total[RECORD_CHECKPOINT]++; /* itself */
    total[RECORD_SAMPLE] += more;
    info.run_info.step = checkpoint.header.step;
    info.run_info.n_resumed = RECORD_CHANNELS;
    info.run_info.resumed_total = total;
    info.run_info.resumed_wall_states = checkpoint.checkpoint.wall_states;
    const int size = shakedown_run_info_t_encode(bytes, 0, ENCODED_MAX, &info.run_info);
    info.run_info.n_resumed = 0;
    info.run_info.resumed_total = NULL;
    message_free(first->kind, &info);
    message_free(last->kind, &checkpoint);
    assert_true(size > 0);
    return (size_t)size;
}

/* The record is gone on with only if it holds all that the checkpoint knows of, and no more. */
static void a_run_goes_on_from_what_its_checkpoint_knows(void **state)
{
    (void)state;
    for (int more = -1; more <= 1; more++) {
        struct bench bench;
        unsigned char bytes[ENCODED_MAX];
        enum recording_answer answer;
        bench_open(&bench, false);
        for (size_t k = 0; k + 1 < bench.run.count; k++)
            give(&bench, &bench.run.messages[k]);
        assert_int_equal(record_receiver_secure(bench.recording), STATUS_OK);
        record_receiver_free(bench.recording); /* as a kill would leave it */
        const struct record_receiver_options options = {
            .directory = bench.directory, .run_id = bench.run.options.run_id, .resume = true, .remake = convert_into};
        assert_int_equal(record_receiver_create(&bench.recording, &options), STATUS_OK);
        const enum status status = record_receiver_take(bench.recording, RECORD_RUN_INFO, bytes,
                                                        encode_resumed(&bench.run, more, bytes), &answer);
        assert_int_equal(status, more == 0 ? STATUS_OK : STATUS_IO);
        if (more != 0)
            assert_non_null(strstr(status_message(), "that the checkpoint knows of"));
        bench_close(&bench);
    }
}

/* --- run.h5 as the export reads it --- */

/* Puts `value` in the place of i (0) or j (1) of a contact. */
static void pair_write(const char *path, hsize_t contact, hsize_t which, int value)
{
    const hsize_t at[2] = {contact, which}, one[2] = {1, 1};
    const hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
    const hid_t set = H5Dopen2(file, "/connectivity/contacts/pair", H5P_DEFAULT), space = H5Dget_space(set);
    const hid_t memory = H5Screate_simple(2, one, NULL);
    assert_true(H5Sselect_hyperslab(space, H5S_SELECT_SET, at, NULL, one, NULL) >= 0);
    assert_true(H5Dwrite(set, H5T_NATIVE_INT, memory, space, H5P_DEFAULT, &value) >= 0);
    assert_true(H5Sclose(memory) >= 0 && H5Sclose(space) >= 0 && H5Dclose(set) >= 0 && H5Fclose(file) >= 0);
}

static enum status frame_read(const char *path, int frame)
{
    struct run_frames run;
    assert_int_equal(run_frames_open(&run, path), STATUS_OK);
    const enum status status = run_frames_read(&run, frame);
    for (int64_t k = 0; status == STATUS_OK && k < 3 * run.contacts.rows; k++)
        assert_true(columns_find(&run.contacts, "force")->value[k] ==
                    columns_find(&run.contacts, "normal_force")->value[k / 3] *
                        columns_find(&run.contacts, "normal")->value[k]);
    run_frames_close(&run);
    return status;
}

/* Contacts are between particles that are there, or a particle and one of six walls (-1 ... -6). */
static void contacts_have_two_ends(void **state)
{
    static const struct {
        int which, value;
        enum status status;
    } cases[] = {{0, 250, STATUS_FORMAT}, {0, -1, STATUS_FORMAT}, {0, 249, STATUS_OK}, {1, 250, STATUS_FORMAT},
                 {1, -7, STATUS_FORMAT},  {1, -6, STATUS_OK},     {1, 249, STATUS_OK}};
    struct bench bench;
    char path[96];
    (void)state;
    bench_open(&bench, false);
    for (size_t k = 0; k < bench.run.count; k++)
        give(&bench, &bench.run.messages[k]);
    assert_int_equal(record_receiver_finish(bench.recording), STATUS_OK);
    snprintf(path, sizeof path, "%s/run.h5", bench.directory);
    assert_int_equal(frame_read(path, 1), STATUS_OK);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        pair_write(path, 3, (hsize_t)cases[k].which, cases[k].value);
        assert_int_equal(frame_read(path, 1), cases[k].status);
        pair_write(path, 3, (hsize_t)cases[k].which, 7);
    }
    bench_close(&bench);
}

/* Where the first block of a dataset stands in the file. */
static haddr_t place_of(const char *path, const char *name)
{
    hsize_t offset[H5_RANK_MAX] = {0}, size;
    unsigned mask;
    haddr_t place;
    const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT), id = H5Dopen2(file, name, H5P_DEFAULT);
    assert_true(file >= 0 && id >= 0);
    assert_true(H5Dget_chunk_info_by_coord(id, offset, &mask, &place, &size) >= 0 && size > 0);
    assert_true(H5Dclose(id) >= 0 && H5Fclose(file) >= 0);
    return place;
}

/* A bit of a number that has changed on the disk. */
static void a_changed_number_is_found(void **state)
{
    static const char *const names[] = {"/samples/strain/value", "/samples/stress_wall_pa/value",
                                        "/particles/trajectory/position/value"};
    struct bench bench;
    char path[96];
    FILE *out = fopen("/dev/null", "w");
    (void)state;
    assert_non_null(out);
    bench_open(&bench, false);
    for (size_t k = 0; k < bench.run.count; k++)
        give(&bench, &bench.run.messages[k]);
    assert_int_equal(record_receiver_finish(bench.recording), STATUS_OK);
    assert_int_equal(verify_run(bench.directory, out), STATUS_OK);
    snprintf(path, sizeof path, "%s/run.h5", bench.directory);
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        const off_t at = (off_t)place_of(path, names[k]) + 3;
        unsigned char byte;
        const int file = open(path, O_RDWR);
        assert_true(file >= 0);
        for (int round = 0; round < 2; round++) { /* and back */
            assert_int_equal(pread(file, &byte, 1, at), 1);
            byte ^= 1;
            assert_int_equal(pwrite(file, &byte, 1, at), 1);
            assert_int_equal(verify_run(bench.directory, out), round == 0 ? STATUS_FORMAT : STATUS_OK);
        }
        assert_int_equal(close(file), 0);
    }
    bench_close(&bench);
    assert_int_equal(fclose(out), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(counts_of_frames_agree),
        cmocka_unit_test(a_message_ends_where_it_ends),
        cmocka_unit_test(a_long_channel_is_no_event),
        cmocka_unit_test(a_log_is_cut_not_lengthened),
        cmocka_unit_test(checkpoint_and_end_know_each_record),
        cmocka_unit_test(end_counts_what_is_there),
        cmocka_unit_test(early_ones_are_kept),
        cmocka_unit_test(chunks_come_in_their_order),
        cmocka_unit_test(a_run_goes_on_from_what_its_checkpoint_knows),
        cmocka_unit_test(contacts_have_two_ends),
        cmocka_unit_test(a_changed_number_is_found),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
