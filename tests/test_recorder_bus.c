/* The recorder's process on a real bus, with a sender that does as sim does. To be run in a network namespace of its
 * own. Argument: the recorder's executable. */
#include <fcntl.h>
#include <pthread.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "common/record_sender.h"
#include "test_recorder_read.h"
#include "test_recorder_synthetic.h"

static const char *recorder_path;
static const double STREAM_TIMEOUT_S = 20.0;

#define SENDER_URL   "udpm://239.255.76.67:7667?ttl=0"
#define RECORDER_URL "udpm://239.255.76.67:7999?ttl=0"

struct bench {
    char directory[64];
    struct synthetic_run run;
    struct bus bus;
    struct record_sender *stream;
    pid_t recorder;
    FILE *errors; /* the recorder's stderr */
    const char *recorder_url;
};

/* In the child. */
static void exec_recorder(const struct bench *bench, const char *timeout, rlim_t size_limit)
{
    char run_id[32];
    const struct rlimit limit = {size_limit, size_limit};
    snprintf(run_id, sizeof run_id, "%lld", (long long)bench->run.options.run_id);
    if (size_limit != RLIM_INFINITY && setrlimit(RLIMIT_FSIZE, &limit) != 0)
        _exit(126);
    execl(recorder_path, recorder_path, "--run-id", run_id, "--out", bench->directory, "--timeout", timeout, "--lcm",
          bench->recorder_url, (char *)NULL);
    _exit(127);
}

static void recorder_start(struct bench *bench, const char *timeout, rlim_t size_limit)
{
    int ends[2];
    assert_int_equal(pipe2(ends, O_CLOEXEC), 0);
    bench->recorder = fork();
    assert_true(bench->recorder >= 0);
    if (bench->recorder == 0) {
        if (dup2(ends[1], STDERR_FILENO) < 0)
            _exit(126);
        exec_recorder(bench, timeout, size_limit);
    }
    assert_int_equal(close(ends[1]), 0);
    bench->errors = fdopen(ends[0], "r");
    assert_non_null(bench->errors);
}

/* Waits for the end; its exit code. */
static int recorder_wait(struct bench *bench)
{
    int status;
    assert_int_equal(waitpid(bench->recorder, &status, 0), bench->recorder);
    char line[512];
    while (fgets(line, sizeof line, bench->errors))
        fputs(line, stdout);
    assert_int_equal(fclose(bench->errors), 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/* Reads the recorder's stderr up to a line that holds `text`. */
static void await_error(struct bench *bench, const char *text)
{
    char line[512];
    while (fgets(line, sizeof line, bench->errors)) {
        if (strstr(line, text))
            return;
    }
    fail_msg("the recorder never said \"%s\"", text);
}

static void bench_open(struct bench *bench, const struct synthetic_options *options)
{
    bench->recorder_url = SENDER_URL;
    synthetic_directory(bench->directory);
    synthetic_create(&bench->run, options);
    assert_int_equal(bus_open(&bench->bus, SENDER_URL), STATUS_OK);
    assert_int_equal(record_sender_create(&bench->stream, &bench->bus, options->run_id, STREAM_TIMEOUT_S), STATUS_OK);
}

static void bench_close(struct bench *bench)
{
    record_sender_free(bench->stream);
    bus_close(&bench->bus);
    synthetic_free(&bench->run);
    synthetic_directory_remove(bench->directory);
}

/* Sends messages [from, to); after every 100 wall messages waits for the recorder, as sim is held up by wallctl. */
static enum status send_range(struct bench *bench, size_t from, size_t to)
{
    int unpaced = 0;
    for (size_t k = from; k < to; k++) {
        const struct synthetic_message *message = &bench->run.messages[k];
        if (message->kind < RECORD_CHANNELS) {
            TRY(record_sender_publish(bench->stream, message->kind, message->data, message->size));
            if (k == 0 || unpaced > 100) {
                TRY(record_sender_flush(bench->stream));
                unpaced = 0;
            }
            continue;
        }
        TRY(bus_publish(&bench->bus, message_channel(message->kind), message->data, message->size));
        unpaced++;
    }
    return record_sender_flush(bench->stream);
}

static void check_file(const struct bench *bench, bool complete, long samples)
{
    hid_t file = read_open(bench->directory);
    assert_true(read_attribute(file, "/", "complete") == (complete ? 1.0 : 0.0));
    assert_int_equal(read_rows(file, "/samples/strain/value"), samples);
    double *strain = read_values(file, "/samples/strain/value");
    for (long s = 0; s < samples; s++)
        assert_true(strain[2 * s] == synthetic_strain((int)s, 0));
    free(strain);
    assert_true(H5Fclose(file) >= 0);
}

static void test_complete_run(void **state)
{
    struct bench bench;
    struct synthetic_options options = synthetic_default;
    (void)state;
    options.n_samples = 300;
    options.n_frames = 40;
    bench_open(&bench, &options);
    recorder_start(&bench, "20", RLIM_INFINITY);
    assert_int_equal(send_range(&bench, 0, bench.run.count), STATUS_OK);
    assert_int_equal(recorder_wait(&bench), 0);
    check_file(&bench, true, options.n_samples);
    bench_close(&bench);
}

static void test_walls_and_event_log(void **state)
{
    struct bench bench;
    struct synthetic_options options = synthetic_default;
    (void)state;
    options.walls = options.event_log = true;
    options.n_samples = 80;
    options.n_wall_states = 4000;
    bench_open(&bench, &options);
    recorder_start(&bench, "20", RLIM_INFINITY);
    double start_s = clock_now_s();
    assert_int_equal(send_range(&bench, 0, bench.run.count), STATUS_OK);
    printf("over the bus: %.0f wall messages/s\n", 2.0 * options.n_wall_states / (clock_now_s() - start_s));
    assert_int_equal(recorder_wait(&bench), 0);
    check_file(&bench, true, options.n_samples);
    hid_t file = read_open(bench.directory);
    assert_int_equal(read_rows(file, "/walls/state/step"), options.n_wall_states);
    assert_int_equal(read_rows(file, "/walls/command/step"), options.n_wall_states);
    assert_true(H5Fclose(file) >= 0);
    bench_close(&bench);
}

/* Another run on the same bus, and junk on our channels. */
static void test_strangers(void **state)
{
    struct bench bench;
    struct synthetic_run other;
    struct synthetic_options options = synthetic_default;
    uint64_t random = 5;
    (void)state;
    bench_open(&bench, &options);
    options.run_id = 43;
    synthetic_create(&other, &options);
    recorder_start(&bench, "20", RLIM_INFINITY);
    for (size_t k = 0; k + 1 < bench.run.count; k++) {
        unsigned char junk[64];
        for (size_t b = 0; b < sizeof junk; b++)
            junk[b] = (unsigned char)synthetic_random(&random);
        const struct synthetic_message *stranger = &other.messages[k];
        const char *channel = message_channel(stranger->kind);
        assert_int_equal(bus_publish(&bench.bus, channel, stranger->data, stranger->size), STATUS_OK);
        assert_int_equal(bus_publish(&bench.bus, channel, junk, sizeof junk), STATUS_OK);
        assert_int_equal(send_range(&bench, k, k + 1), STATUS_OK);
    }
    assert_int_equal(send_range(&bench, bench.run.count - 1, bench.run.count), STATUS_OK);
    await_error(&bench, "messages of other runs");
    assert_int_equal(recorder_wait(&bench), 0);
    check_file(&bench, true, synthetic_default.n_samples);
    synthetic_free(&other);
    bench_close(&bench);
}

/* Stopped before END: patience after the first signal, none after the second; readable, incomplete. */
static void test_stop_without_end(void **state)
{
    struct bench bench;
    (void)state;
    bench_open(&bench, &synthetic_default);
    recorder_start(&bench, "20", RLIM_INFINITY);
    assert_int_equal(send_range(&bench, 0, bench.run.count - 1), STATUS_OK);
    assert_int_equal(kill(bench.recorder, SIGTERM), 0);
    await_error(&bench, "stop requested");
    assert_int_equal(kill(bench.recorder, SIGTERM), 0);
    await_error(&bench, "END is missing");
    assert_int_equal(recorder_wait(&bench), status_exit_code(STATUS_INCOMPLETE));
    check_file(&bench, false, synthetic_default.n_samples);
    bench_close(&bench);
}

/* Stopped, then END comes: sim ends on the same signal and says so. */
static void test_stop_then_end(void **state)
{
    struct bench bench;
    (void)state;
    bench_open(&bench, &synthetic_default);
    recorder_start(&bench, "20", RLIM_INFINITY);
    assert_int_equal(send_range(&bench, 0, bench.run.count - 1), STATUS_OK);
    assert_int_equal(kill(bench.recorder, SIGINT), 0);
    await_error(&bench, "stop requested");
    assert_int_equal(send_range(&bench, bench.run.count - 1, bench.run.count), STATUS_OK);
    assert_int_equal(recorder_wait(&bench), 0);
    check_file(&bench, true, synthetic_default.n_samples);
    bench_close(&bench);
}

static void test_silence(void **state)
{
    struct bench bench;
    (void)state;
    bench_open(&bench, &synthetic_default);
    recorder_start(&bench, "0.5", RLIM_INFINITY);
    assert_int_equal(send_range(&bench, 0, bench.run.count - 1), STATUS_OK);
    await_error(&bench, "no message of this run for 0.5 s");
    assert_int_equal(recorder_wait(&bench), status_exit_code(STATUS_INCOMPLETE));
    check_file(&bench, false, synthetic_default.n_samples);
    bench_close(&bench);
}

/* A run that the recorder cannot read: the sender hears of it long before its patience with silence ends. */
static void test_unreadable_run(void **state)
{
    struct bench bench;
    struct synthetic_options options = synthetic_default;
    (void)state;
    options.unreadable = true;
    bench_open(&bench, &options);
    recorder_start(&bench, "20", RLIM_INFINITY);
    const double start_s = clock_now_s();
    assert_int_equal(send_range(&bench, 0, bench.run.count), STATUS_IO);
    assert_true(clock_now_s() - start_s < STREAM_TIMEOUT_S / 2); /* by its failure, not by silence */
    await_error(&bench, "RUN_INFO cannot be recorded");
    assert_int_equal(recorder_wait(&bench), status_exit_code(STATUS_FORMAT));
    bench_close(&bench);
}

/* Wall states that never came: END's totals do not match, so the run is not complete, and says which are missing. */
static void test_lost_walls(void **state)
{
    struct bench bench;
    struct synthetic_options options = synthetic_default;
    (void)state;
    options.walls = true;
    options.n_wall_states = 10;
    bench_open(&bench, &options);
    recorder_start(&bench, "1", RLIM_INFINITY);
    for (size_t k = 0; k + 1 < bench.run.count; k++) {
        if (bench.run.messages[k].kind < RECORD_CHECKPOINT) /* CHECKPOINT would wait for them */
            assert_int_equal(send_range(&bench, k, k + 1), STATUS_OK);
    }
    const struct synthetic_message *end = &bench.run.messages[bench.run.count - 1];
    assert_int_equal(bus_publish(&bench.bus, "END", end->data, end->size), STATUS_OK);
    await_error(&bench, "WALL_STATE 0 of 10");
    assert_int_equal(recorder_wait(&bench), status_exit_code(STATUS_INCOMPLETE));
    check_file(&bench, false, options.n_samples);
    bench_close(&bench);
}

/* Every 7th wall message, and the last, does not reach the recorder when it goes out first: the stream, which kept
 * copies, sends them again, and the run becomes complete. */
static void test_lost_walls_are_sent_again(void **state)
{
    struct bench bench;
    struct synthetic_options options = synthetic_default;
    int64_t sent = 0, lost = 0;
    (void)state;
    options.walls = true;
    options.n_wall_states = 100;
    bench_open(&bench, &options);
    recorder_start(&bench, "20", RLIM_INFINITY);
    for (size_t k = 0; k < bench.run.count; k++) {
        const struct synthetic_message *message = &bench.run.messages[k];
        if (message->kind < RECORD_CHANNELS) {
            assert_int_equal(send_range(&bench, k, k + 1), STATUS_OK);
            continue;
        }
        const int64_t seq = sent / 2, last = 2 * options.n_wall_states - 1;
        assert_int_equal(record_sender_wait_for_walls(bench.stream, seq), STATUS_OK);
        record_sender_keep_wall(bench.stream, sent % 2, seq, message->data, message->size);
        if (sent % 7 == 6 || sent == last)
            lost++;
        else
            assert_int_equal(bus_publish(&bench.bus, message_channel(message->kind), message->data, message->size),
                             STATUS_OK);
        sent++;
    }
    assert_true(record_sender_repeated(bench.stream) >= lost);
    assert_int_equal(recorder_wait(&bench), 0);
    check_file(&bench, true, options.n_samples);
    hid_t file = read_open(bench.directory);
    double *force = read_values(file, "/walls/state/force_n"), *step = read_values(file, "/walls/command/step");
    assert_int_equal(read_rows(file, "/walls/state/force_n"), options.n_wall_states);
    assert_int_equal(read_rows(file, "/walls/command/step"), options.n_wall_states);
    for (int k = 0; k < options.n_wall_states; k++)
        assert_true(force[4 * k] == synthetic_wall_force(k, 0) && step[k] == 5 * k);
    free(force);
    free(step);
    assert_true(H5Fclose(file) >= 0);
    bench_close(&bench);
}

/* ---- a bus that loses, doubles and swaps messages: a relay between the sender's port and the recorder's ---- */

struct control_quality {
    char channel[64]; /* "": none */
    size_t size;
    unsigned char data[BUS_MESSAGE_MAX];
};

struct relay {
    struct bus sender, recorder;
    pthread_t thread;
    atomic_bool stop;
    atomic_bool failed;
    int loss_percent, double_percent, swap_percent;
    uint64_t random;
    int64_t passed, lost;
    struct control_quality kept[2]; /* to the recorder, to the sender: goes out after the next one */
};

static bool dice(struct relay *relay, int percent)
{
    return (int)(synthetic_random(&relay->random) % 100) < percent;
}

static void relay_publish(struct relay *relay, bool back, const char *channel, const void *data, size_t size)
{
    struct bus *to = back ? &relay->sender : &relay->recorder;
    if (bus_publish(to, channel, data, size) != STATUS_OK)
        atomic_store(&relay->failed, true);
    relay->passed++;
}

static void relay_pass(struct relay *relay, bool back, const char *channel, const lcm_recv_buf_t *buffer)
{
    struct control_quality *kept = &relay->kept[back];
    if (dice(relay, relay->loss_percent)) {
        relay->lost++;
        return;
    }
    if (!kept->channel[0] && buffer->data_size <= sizeof kept->data && dice(relay, relay->swap_percent)) {
        snprintf(kept->channel, sizeof kept->channel, "%s", channel);
        kept->size = buffer->data_size;
        memcpy(kept->data, buffer->data, buffer->data_size);
        return;
    }
    for (int copies = dice(relay, relay->double_percent) ? 2 : 1; copies > 0; copies--)
        relay_publish(relay, back, channel, buffer->data, buffer->data_size);
    if (!kept->channel[0])
        return;
    relay_publish(relay, back, kept->channel, kept->data, kept->size);
    kept->channel[0] = '\0';
}

static void to_recorder(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    relay_pass(user, false, channel, buffer);
}

static void to_sender(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    relay_pass(user, true, channel, buffer);
}

static void *relay_run(void *user)
{
    struct relay *relay = user;
    while (!atomic_load(&relay->stop)) {
        bool handled = true;
        if (bus_handle(&relay->sender, 1, &handled) != STATUS_OK)
            atomic_store(&relay->failed, true);
        for (handled = true; handled;) {
            if (bus_handle(&relay->recorder, 0, &handled) != STATUS_OK)
                atomic_store(&relay->failed, true);
        }
    }
    return NULL;
}

static void relay_start(struct relay *relay)
{
    assert_int_equal(bus_open(&relay->sender, SENDER_URL), STATUS_OK);
    assert_int_equal(bus_open(&relay->recorder, RECORDER_URL), STATUS_OK);
    for (int kind = 0; kind < MESSAGE_LOGGED_KINDS; kind++)
        assert_int_equal(bus_subscribe(&relay->sender, message_channel(kind), to_recorder, relay), STATUS_OK);
    assert_int_equal(bus_subscribe(&relay->recorder, CHANNEL_RECORD_ACK, to_sender, relay), STATUS_OK);
    assert_int_equal(pthread_create(&relay->thread, NULL, relay_run, relay), 0);
}

static void relay_stop(struct relay *relay)
{
    atomic_store(&relay->stop, true);
    assert_int_equal(pthread_join(relay->thread, NULL), 0);
    bus_close(&relay->sender);
    bus_close(&relay->recorder);
    assert_false(atomic_load(&relay->failed));
}

/* Sends the run as sim does, in `duration_s` at the earliest. */
static void send_paced(struct bench *bench, double duration_s)
{
    const double start_s = clock_now_s();
    int64_t sent = 0;
    for (size_t k = 0; k < bench->run.count; k++) {
        const struct synthetic_message *message = &bench->run.messages[k];
        if (message->kind < RECORD_CHANNELS) {
            assert_int_equal(record_sender_publish(bench->stream, message->kind, message->data, message->size),
                             STATUS_OK);
        } else {
            assert_int_equal(record_sender_wait_for_walls(bench->stream, sent / 2), STATUS_OK);
            record_sender_keep_wall(bench->stream, sent % 2, sent / 2, message->data, message->size);
            assert_int_equal(bus_publish(&bench->bus, message_channel(message->kind), message->data, message->size),
                             STATUS_OK);
            sent++;
        }
        if (k == 0 || message->kind == RECORD_CHECKPOINT)
            assert_int_equal(record_sender_flush(bench->stream), STATUS_OK);
        const double due_s = start_s + duration_s * (double)k / (double)bench->run.count;
        do {
            bool handled;
            assert_int_equal(bus_handle(&bench->bus, clock_now_s() < due_s, &handled), STATUS_OK);
            assert_int_equal(record_sender_service(bench->stream), STATUS_OK);
        } while (clock_now_s() < due_s);
    }
    assert_int_equal(record_sender_flush(bench->stream), STATUS_OK);
}

static double lossy_run(struct relay *relay, const struct synthetic_options *options, double duration_s)
{
    struct bench bench;
    bench_open(&bench, options);
    bench.recorder_url = RECORDER_URL;
    recorder_start(&bench, "20", RLIM_INFINITY);
    relay_start(relay);
    const double start_s = clock_now_s();
    send_paced(&bench, duration_s);
    const double elapsed_s = clock_now_s() - start_s;
    assert_int_equal(recorder_wait(&bench), 0);
    relay_stop(relay);
    check_file(&bench, true, options->n_samples);
    hid_t file = read_open(bench.directory);
    assert_int_equal(read_rows(file, "/particles/trajectory/position/value"), options->n_frames);
    if (options->walls)
        assert_int_equal(read_rows(file, "/walls/command/step"), options->n_wall_states);
    assert_true(H5Fclose(file) >= 0);
    printf("loss %d %%: %zu messages in %.2f s, %lld of %lld lost, %lld sent again\n", relay->loss_percent,
           bench.run.count, elapsed_s, (long long)relay->lost, (long long)(relay->lost + relay->passed),
           (long long)record_sender_repeated(bench.stream));
    bench_close(&bench);
    return elapsed_s;
}

/* Each kind of trouble, and all of them together: every record is there once, and the run is complete. A run of 2 s
 * ends within twice that: what is lost is found out by what came after it, within milliseconds. */
static void test_loss(void **state)
{
    static const int percent[][3] = {{1, 0, 0}, {5, 0, 0}, {20, 0, 0}, {0, 20, 0}, {0, 0, 20}, {20, 20, 20}};
    struct synthetic_options options = synthetic_default;
    (void)state;
    options.n_samples = 2000;
    options.n_frames = 40;
    for (size_t k = 0; k < sizeof percent / sizeof *percent; k++) {
        static struct relay relay;
        relay = (struct relay){.loss_percent = percent[k][0],
                               .double_percent = percent[k][1],
                               .swap_percent = percent[k][2],
                               .random = 11 + k};
        options.walls = percent[k][2] > 0; /* at most 16 exchanges are on their way: these may take longer */
        options.n_wall_states = options.walls ? 2000 : 0;
        const double elapsed_s = lossy_run(&relay, &options, 2.0);
        assert_true(options.walls || elapsed_s < 4.0);
    }
}

/* Records far apart: STATUS keeps the recorder there, and without it the silence ends it. */
static void test_signs_of_life(void **state)
{
    struct bench bench;
    double strain[2] = {0};
    shakedown_status_t life = {.run_id = synthetic_default.run_id,
                               .stage_name = (char *)"only",
                               .dimension = 2,
                               .strain = strain,
                               .stress_wall_pa = strain};
    unsigned char bytes[512];
    (void)state;
    bench_open(&bench, &synthetic_default);
    recorder_start(&bench, "0.5", RLIM_INFINITY);
    assert_int_equal(send_range(&bench, 0, bench.run.count - 1), STATUS_OK);
    int size = shakedown_status_t_encode(bytes, 0, sizeof bytes, &life);
    assert_true(size > 0);
    for (double start_s = clock_now_s(); clock_now_s() - start_s < 1.5;) {
        bool handled;
        assert_int_equal(bus_publish(&bench.bus, CHANNEL_STATUS, bytes, (size_t)size), STATUS_OK);
        for (double now_s = clock_now_s(); clock_now_s() - now_s < 0.05;)
            assert_int_equal(bus_handle(&bench.bus, 10, &handled), STATUS_OK);
    }
    assert_int_equal(send_range(&bench, bench.run.count - 1, bench.run.count), STATUS_OK);
    assert_int_equal(recorder_wait(&bench), 0);
    check_file(&bench, true, synthetic_default.n_samples);
    bench_close(&bench);
}

/* A disk that becomes full: the sender is told at once, the file is readable. */
static void test_full_disk(void **state)
{
    struct bench bench;
    struct synthetic_options options = synthetic_default;
    (void)state;
    options.n_particles = 5000;
    options.n_frames = 100;
    bench_open(&bench, &options);
    recorder_start(&bench, "20", 1000 * 1000);
    assert_int_equal(send_range(&bench, 0, bench.run.count), STATUS_IO);
    assert_non_null(strstr(status_message(), "has failed"));
    await_error(&bench, "File too large");
    assert_int_equal(recorder_wait(&bench), status_exit_code(STATUS_IO));
    hid_t file = read_open(bench.directory);
    assert_true(read_attribute(file, "/", "complete") == 0.0);
    assert_true(H5Fclose(file) >= 0);
    bench_close(&bench);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_complete_run),
        cmocka_unit_test(test_walls_and_event_log),
        cmocka_unit_test(test_strangers),
        cmocka_unit_test(test_stop_without_end),
        cmocka_unit_test(test_stop_then_end),
        cmocka_unit_test(test_silence),
        cmocka_unit_test(test_unreadable_run),
        cmocka_unit_test(test_lost_walls),
        cmocka_unit_test(test_lost_walls_are_sent_again),
        cmocka_unit_test(test_loss),
        cmocka_unit_test(test_signs_of_life),
        cmocka_unit_test(test_full_disk),
    };
    if (argc != 2) {
        fprintf(stderr, "usage: %s RECORDER\n", argv[0]);
        return 2;
    }
    recorder_path = argv[1];
    return cmocka_run_group_tests(tests, NULL, NULL);
}
