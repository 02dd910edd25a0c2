/* The recorder and LCM event logs: conversion, cut and damaged logs, the log it writes itself; and how fast it is. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "recorder/log_conversion.h"
#include "recorder/verify.h"
#include "test_recorder_read.h"
#include "test_recorder_synthetic.h"

/* Writes the run as sim writes it to a file:// URL. */
static void write_log(const struct synthetic_run *run, const char *path)
{
    struct bus bus;
    char url[128];
    (void)remove(path); /* absent the first time */
    snprintf(url, sizeof url, "file://%s?mode=w", path);
    assert_int_equal(bus_open(&bus, url), STATUS_OK);
    for (size_t k = 0; k < run->count; k++) {
        const struct synthetic_message *message = &run->messages[k];
        assert_int_equal(bus_publish(&bus, message_channel(message->kind), message->data, message->size), STATUS_OK);
    }
    assert_int_equal(bus_flush(&bus), STATUS_OK);
    bus_close(&bus);
}

static enum status convert(const char *log, const char *directory)
{
    struct record_receiver *recording;
    const struct record_receiver_options options = {.directory = directory, .any_run = true, .from_log = true};
    assert_int_equal(record_receiver_create(&recording, &options), STATUS_OK);
    enum status status = convert_log(recording, log);
    assert_int_equal(status == STATUS_OK, record_receiver_is_complete(recording));
    record_receiver_free(recording);
    return status;
}

static long samples_in(const char *directory, bool complete)
{
    hid_t file = read_open(directory);
    assert_true(read_attribute(file, "/", "complete") == (complete ? 1.0 : 0.0));
    long rows = read_rows(file, "/samples/strain/value");
    for (long k = 0; k < rows; k++) {
        double *strain = k == 0 ? read_values(file, "/samples/strain/value") : NULL;
        for (long s = 0; strain && s < rows; s++)
            assert_true(strain[2 * s] == synthetic_strain((int)s, 0));
        free(strain);
    }
    assert_true(H5Fclose(file) >= 0);
    return rows;
}

struct bench {
    char directory[64], log[80];
    struct synthetic_run run;
};

static void bench_open(struct bench *bench, const struct synthetic_options *options)
{
    synthetic_directory(bench->directory);
    snprintf(bench->log, sizeof bench->log, "%s/in.lcm", bench->directory);
    synthetic_create(&bench->run, options);
    write_log(&bench->run, bench->log);
}

static void bench_close(struct bench *bench)
{
    synthetic_free(&bench->run);
    synthetic_directory_remove(bench->directory);
}

static void remove_run(const struct bench *bench)
{
    char path[96];
    snprintf(path, sizeof path, "%s/run.h5", bench->directory);
    (void)remove(path); /* absent if no RUN_INFO came */
}

static void test_conversion(void **state)
{
    struct bench bench;
    struct synthetic_options options = synthetic_default;
    (void)state;
    options.event_log = true; /* must not be written again */
    bench_open(&bench, &options);
    assert_int_equal(convert(bench.log, bench.directory), STATUS_OK);
    assert_int_equal(samples_in(bench.directory, true), options.n_samples);
    char path[96];
    snprintf(path, sizeof path, "%s/run.lcm", bench.directory);
    assert_int_not_equal(access(path, F_OK), 0);
    bench_close(&bench);
}

static long file_size(const char *path)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    long size = ftell(file);
    assert_int_equal(fclose(file), 0);
    return size;
}

/* Every cut gives a readable file (or none before RUN_INFO) that says incomplete, with the samples before the cut. */
static void test_cut_log(void **state)
{
    struct bench bench;
    long last_rows = synthetic_default.n_samples;
    (void)state;
    bench_open(&bench, &synthetic_default);
    long size = file_size(bench.log);
    const long end_size = 28 + 3 + (long)bench.run.messages[bench.run.count - 1].size;
    /* in END; just before END; in the last sample; then ever earlier */
    for (long cut = size - 1; cut > 0; cut = cut > size - end_size ? size - end_size : cut - size / 23 - 1) {
        assert_int_equal(truncate(bench.log, cut), 0);
        assert_int_equal(convert(bench.log, bench.directory), STATUS_INCOMPLETE);
        if (strstr(status_message(), "no RUN_INFO"))
            continue;
        long rows = samples_in(bench.directory, false);
        assert_true(rows <= last_rows);
        last_rows = rows;
        remove_run(&bench);
    }
    assert_true(last_rows == 0);
    bench_close(&bench);
}

static void overwrite(const char *path, long at, const void *bytes, size_t size)
{
    FILE *file = fopen(path, "r+b");
    assert_non_null(file);
    assert_int_equal(fseek(file, at, SEEK_SET), 0);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

/* Random damage: never a crash, never complete. */
static void test_damaged_log(void **state)
{
    struct bench bench;
    uint64_t random = 4;
    (void)state;
    bench_open(&bench, &synthetic_default);
    long size = file_size(bench.log);
    for (int round = 0; round < 40; round++) {
        unsigned char junk[24];
        for (size_t k = 0; k < sizeof junk; k++)
            junk[k] = (unsigned char)synthetic_random(&random);
        write_log(&bench.run, bench.log);
        overwrite(bench.log, (long)(synthetic_random(&random) % (uint64_t)(size - 24)), junk, sizeof junk);
        enum status status = convert(bench.log, bench.directory);
        assert_int_equal(status, STATUS_INCOMPLETE); /* the checksums see every change */
        remove_run(&bench);
    }
    bench_close(&bench);
}

/* Lengths in an event's header at which a reader that believes them allocates gigabytes or writes outside. */
static void test_hostile_event_lengths(void **state)
{
    static const unsigned char lengths[][4] = {
        {0x7f, 0xff, 0xff, 0xff}, {0xff, 0xff, 0xff, 0xff}, {0x80, 0, 0, 0}, {0, 0, 0, 0}, {0, 0x0f, 0xff, 0xff}};
    struct bench bench;
    (void)state;
    bench_open(&bench, &synthetic_default);
    long second = 28 + 8 + (long)bench.run.messages[0].size; /* the event after RUN_INFO */
    for (size_t k = 0; k < 2 * sizeof lengths / sizeof *lengths; k++) {
        write_log(&bench.run, bench.log);
        overwrite(bench.log, second + (k % 2 ? 20 : 24), lengths[k / 2], 4);
        assert_int_equal(convert(bench.log, bench.directory), STATUS_INCOMPLETE);
        assert_int_equal(samples_in(bench.directory, false), synthetic_default.n_samples);
        remove_run(&bench);
    }
    bench_close(&bench);
}

static void test_missing_and_empty_log(void **state)
{
    struct bench bench;
    (void)state;
    bench_open(&bench, &synthetic_default);
    assert_int_equal(convert("no/such/file", bench.directory), STATUS_IO);
    assert_non_null(strstr(status_message(), "no/such/file"));
    assert_int_equal(truncate(bench.log, 0), 0);
    assert_int_equal(convert(bench.log, bench.directory), STATUS_INCOMPLETE);
    bench_close(&bench);
}

/* run.lcm, written while recording, holds every accepted message once, and gives the same file again. */
static void test_event_log(void **state)
{
    struct bench bench, again;
    struct synthetic_options options = synthetic_default;
    struct record_receiver *recording;
    enum recording_answer answer;
    (void)state;
    options.event_log = options.walls = true;
    options.n_wall_states = 100;
    bench_open(&bench, &options);
    bench_open(&again, &synthetic_default);
    const struct record_receiver_options live = {
        .directory = bench.directory, .run_id = options.run_id, .remake = convert_into};
    assert_int_equal(record_receiver_create(&recording, &live), STATUS_OK);
    for (size_t k = 0; k < bench.run.count; k++) {
        const struct synthetic_message *message = &bench.run.messages[k];
        assert_int_equal(record_receiver_take(recording, message->kind, message->data, message->size, &answer),
                         STATUS_OK);
        assert_int_equal(record_receiver_take(recording, message->kind, message->data, message->size, &answer),
                         STATUS_OK);
    }
    assert_int_equal(record_receiver_finish(recording), STATUS_OK);
    record_receiver_free(recording);
    char path[96];
    snprintf(path, sizeof path, "%s/run.lcm", bench.directory);
    assert_int_equal(file_size(path), file_size(bench.log)); /* each message once */
    assert_int_equal(convert(path, again.directory), STATUS_OK);
    assert_int_equal(samples_in(again.directory, true), options.n_samples);
    bench_close(&again);
    bench_close(&bench);
}

static enum status verify(const char *directory, char *said, size_t size)
{
    FILE *out = fmemopen(said, size, "w");
    assert_non_null(out);
    enum status status = verify_run(directory, out);
    assert_int_equal(fclose(out), 0);
    return status;
}

/* A whole run is complete; one changed bit of any place in its log or its data is found; so is a record that another
 * sender has put in the place of ours. */
static void test_verify(void **state)
{
    struct bench bench;
    char said[4096], path[96];
    struct synthetic_options options = synthetic_default;
    uint64_t random = 8;
    (void)state;
    options.walls = true;
    options.n_wall_states = 50;
    bench_open(&bench, &options);
    snprintf(path, sizeof path, "%s/run.lcm", bench.directory);
    assert_int_equal(verify("no/such/folder", said, sizeof said), STATUS_IO);
    assert_int_equal(rename(bench.log, path), 0);
    assert_int_equal(verify(bench.directory, said, sizeof said), STATUS_INCOMPLETE); /* no run.h5 */
    assert_int_equal(convert(path, bench.directory), STATUS_OK);
    assert_int_equal(verify(bench.directory, said, sizeof said), STATUS_OK);
    assert_non_null(strstr(said, "complete 1, 20 samples, 3 frames"));
    for (int round = 0; round < 30; round++) {
        const long size = file_size(path), place = (long)(synthetic_random(&random) % (uint64_t)size);
        FILE *file = fopen(path, "r+b");
        assert_non_null(file);
        assert_int_equal(fseek(file, place, SEEK_SET), 0);
        const int byte = fgetc(file);
        assert_int_equal(fclose(file), 0);
        overwrite(path, place, &(unsigned char){(unsigned char)(byte ^ 16)}, 1);
        assert_int_not_equal(verify(bench.directory, said, sizeof said), STATUS_OK);
        overwrite(path, place, &(unsigned char){(unsigned char)byte}, 1);
    }
    assert_int_equal(verify(bench.directory, said, sizeof said), STATUS_OK);
    bench_close(&bench);
}

/* A log without one record in the middle, one with a record that is another, and a run.h5 that is not complete. */
static void test_verify_says_what_is_wrong(void **state)
{
    struct bench bench;
    char said[4096], path[96];
    const int32_t no = 0;
    (void)state;
    bench_open(&bench, &synthetic_default);
    snprintf(path, sizeof path, "%s/run.lcm", bench.directory);
    assert_int_equal(rename(bench.log, path), 0);
    assert_int_equal(convert(path, bench.directory), STATUS_OK);
    assert_int_equal(unlink(path), 0);
    assert_int_equal(verify(bench.directory, said, sizeof said), STATUS_OK);
    struct synthetic_message *sample = bench.run.messages;
    while (sample->kind != RECORD_SAMPLE || sample[1].kind != RECORD_SAMPLE)
        sample++;
    sample->data[sample->size - 1] ^= 1;
    write_log(&bench.run, path);
    assert_int_equal(verify(bench.directory, said, sizeof said), STATUS_FORMAT);
    assert_non_null(strstr(said, "the records on SAMPLE are not those that were sent"));
    assert_int_equal(unlink(path), 0);
    sample->kind = MESSAGE_STATUS; /* which no log has */
    write_log(&bench.run, path);
    assert_int_not_equal(verify(bench.directory, said, sizeof said), STATUS_OK);
    assert_non_null(strstr(said, "where 0 was due"));
    assert_int_equal(unlink(path), 0);
    snprintf(path, sizeof path, "%s/run.h5", bench.directory);
    hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
    hid_t complete = H5Aopen(file, "complete", H5P_DEFAULT);
    assert_true(H5Awrite(complete, H5T_NATIVE_INT32, &no) >= 0 && H5Aclose(complete) >= 0 && H5Fclose(file) >= 0);
    assert_int_equal(verify(bench.directory, said, sizeof said), STATUS_INCOMPLETE);
    assert_non_null(strstr(said, "not complete"));
    bench_close(&bench);
}

/* A sample of the right form, number and run that is not the one that was sent: END's hash does not match. */
static void test_another_sample(void **state)
{
    struct bench bench;
    (void)state;
    bench_open(&bench, &synthetic_default);
    for (size_t k = 0; k < bench.run.count; k++) {
        if (bench.run.messages[k].kind == RECORD_SAMPLE)
            bench.run.messages[k].data[bench.run.messages[k].size - 1] ^= 1;
    }
    write_log(&bench.run, bench.log);
    assert_int_equal(convert(bench.log, bench.directory), STATUS_INCOMPLETE);
    assert_non_null(strstr(status_message(), "SAMPLE are not those that were sent"));
    assert_int_equal(samples_in(bench.directory, false), synthetic_default.n_samples);
    bench_close(&bench);
}

/* A log of the bus in which wall messages are missing, more than a sender ever has on its way: the file holds all that
 * is there, in order, and says that it is not complete. */
static void test_log_without_some_walls(void **state)
{
    struct synthetic_options options = synthetic_default;
    struct synthetic_run run;
    struct record_receiver *recording;
    enum recording_answer answer;
    char directory[64];
    long states = 0, commands = 0, wall = 0;
    (void)state;
    options.walls = true;
    options.n_wall_states = 300;
    synthetic_directory(directory);
    synthetic_create(&run, &options);
    const struct record_receiver_options from_log = {.directory = directory, .any_run = true, .from_log = true};
    assert_int_equal(record_receiver_create(&recording, &from_log), STATUS_OK);
    for (size_t k = 0; k < run.count; k++) {
        const struct synthetic_message *message = &run.messages[k];
        const bool is_wall = message->kind >= MESSAGE_WALL_STATE;
        if (is_wall && (wall++ % 50 == 7 || (wall >= 200 && wall < 300)))
            continue;
        states += message->kind == MESSAGE_WALL_STATE;
        commands += message->kind == MESSAGE_WALL_COMMAND;
        assert_int_equal(record_receiver_take(recording, message->kind, message->data, message->size, &answer),
                         STATUS_OK);
    }
    assert_int_equal(record_receiver_finish(recording), STATUS_INCOMPLETE);
    record_receiver_free(recording);
    hid_t file = read_open(directory);
    assert_int_equal(read_rows(file, "/walls/state/step"), states);
    assert_int_equal(read_rows(file, "/walls/command/step"), commands);
    double *step = read_values(file, "/walls/state/step");
    for (long k = 1; k < states; k++)
        assert_true(step[k] > step[k - 1]);
    free(step);
    assert_true(H5Fclose(file) >= 0);
    synthetic_free(&run);
    synthetic_directory_remove(directory);
}

/* Prints the rate; no bound, as it depends on the machine. */
static void test_throughput(void **state)
{
    enum { STATES = 50000 };
    struct bench bench;
    struct synthetic_options options = synthetic_default;
    (void)state;
    options.walls = true;
    options.n_wall_states = STATES;
    options.n_samples = 0;
    bench_open(&bench, &options);
    double start_s = clock_now_s();
    assert_int_equal(convert(bench.log, bench.directory), STATUS_OK);
    double elapsed_s = clock_now_s() - start_s;
    printf("full-rate wall recording: %.0f rows/s (a state or a command each)\n", 2.0 * STATES / elapsed_s);
    bench_close(&bench);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_conversion),
        cmocka_unit_test(test_cut_log),
        cmocka_unit_test(test_damaged_log),
        cmocka_unit_test(test_hostile_event_lengths),
        cmocka_unit_test(test_missing_and_empty_log),
        cmocka_unit_test(test_event_log),
        cmocka_unit_test(test_verify),
        cmocka_unit_test(test_verify_says_what_is_wrong),
        cmocka_unit_test(test_another_sample),
        cmocka_unit_test(test_log_without_some_walls),
        cmocka_unit_test(test_throughput),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
