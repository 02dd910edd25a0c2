/* The recorder killed at any message, and on a disk that is full. Argument: the recorder's executable. */
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

#include "recorder/log_conversion.h"
#include "recorder/verify.h"
#include "test_recorder_read.h"
#include "test_recorder_synthetic.h"

static const char *recorder_path;

/* In a child: takes messages, flushes after `flush_at` of them, is killed after `kill_at`. */
static void record_and_die(const struct synthetic_run *run, const char *directory, size_t flush_at, size_t kill_at)
{
    struct record_receiver *recording;
    enum recording_answer answer;
    const struct record_receiver_options options = {
        .directory = directory, .run_id = run->options.run_id, .remake = convert_into};
    if (record_receiver_create(&recording, &options) != STATUS_OK)
        _exit(1);
    for (size_t k = 0; k < kill_at; k++) {
        const struct synthetic_message *message = &run->messages[k];
        if (record_receiver_take(recording, message->kind, message->data, message->size, &answer) != STATUS_OK)
            _exit(1);
        if (k + 1 != flush_at)
            continue;
        if (record_receiver_secure(recording) != STATUS_OK)
            _exit(1);
        record_receiver_publish(recording);
    }
    (void)raise(SIGKILL);
}

static int messages_before(const struct synthetic_run *run, int kind, size_t end)
{
    int count = 0;
    for (size_t k = 0; k < end; k++)
        count += run->messages[k].kind == kind;
    return count;
}

/* What was flushed is there and right; what came later may be. */
static void check_after_kill(const struct synthetic_run *run, const char *directory, size_t flush_at)
{
    hid_t file = read_open(directory);
    assert_true(read_attribute(file, "/", "complete") == 0.0);
    long rows = read_rows(file, "/samples/strain/value");
    assert_true(rows >= messages_before(run, RECORD_SAMPLE, flush_at));
    double *strain = read_values(file, "/samples/strain/value");
    for (long s = 0; s < rows; s++)
        assert_true(strain[2 * s] == synthetic_strain((int)s, 0));
    free(strain);
    long frames = read_rows(file, "/particles/trajectory/position/value");
    int chunks = (run->options.n_particles + SYNTHETIC_CHUNK - 1) / SYNTHETIC_CHUNK;
    assert_true(frames >= messages_before(run, RECORD_FRAME_PARTICLES, flush_at) / chunks);
    double *position = read_values(file, "/particles/trajectory/position/value");
    for (long f = 0; f < frames; f++)
        assert_true(position[3 * f * run->options.n_particles] == synthetic_position((int)f, 0, 0));
    free(position);
    long states = read_rows(file, "/walls/state/force_n");
    double *force = read_values(file, "/walls/state/force_n");
    for (long k = 0; k < states; k++)
        assert_true(force[4 * k] == synthetic_wall_force(k, 0));
    free(force);
    double *overlap = read_values(file, "/connectivity/contacts/overlap");
    free(overlap);
    assert_true(H5Fclose(file) >= 0);
}

/* Whether there is no run.h5 (no room for RUN_INFO), or one that opens as an earlier flush left it. */
static bool is_absent_or_opens(const char *directory)
{
    char path[80];
    snprintf(path, sizeof path, "%s/run.h5", directory);
    if (access(path, F_OK) != 0)
        return true;
    hid_t run = read_open(directory);
    assert_true(read_attribute(run, "/", "complete") == 0.0);
    return H5Fclose(run) >= 0;
}

/* From the log comes at least what was secured, and run.h5 is that of it. */
static void check_repair(const struct synthetic_run *run, const char *directory, size_t secured)
{
    struct run_counts counts;
    char log[80];
    snprintf(log, sizeof log, "%s/run.lcm", directory);
    assert_int_equal(convert_into(log, directory, &counts), STATUS_INCOMPLETE);
    assert_true(counts.wall_states >= messages_before(run, MESSAGE_WALL_STATE, secured));
    check_after_kill(run, directory, secured);
    FILE *words = fopen("/dev/null", "w");
    assert_non_null(words);
    assert_int_equal(verify_run(directory, words), STATUS_INCOMPLETE);
    assert_int_equal(fclose(words), 0);
}

/* In a child: takes messages again and again, with all that goes with it, until it is killed. */
static void record_until_killed(const struct synthetic_run *run, const char *directory)
{
    struct record_receiver *recording;
    enum recording_answer answer;
    const struct record_receiver_options options = {
        .directory = directory, .run_id = run->options.run_id, .remake = convert_into};
    if (record_receiver_create(&recording, &options) != STATUS_OK)
        _exit(1);
    for (size_t k = 0; k + 1 < run->count; k++) {
        const struct synthetic_message *message = &run->messages[k];
        if (record_receiver_take(recording, message->kind, message->data, message->size, &answer) != STATUS_OK ||
            record_receiver_secure(recording) != STATUS_OK)
            _exit(1);
        if (k % 40 == 1)
            record_receiver_publish(recording);
    }
    (void)raise(SIGKILL);
}

/* Killed by the clock, so in the middle of writing, copying, renaming: run.h5 opens, if it is there yet, and the log
 * gives all that is whole in it. */
static void test_kill_at_any_time(void **state)
{
    struct synthetic_run run;
    struct synthetic_options options = synthetic_default;
    int there = 0;
    uint64_t random = 3;
    (void)state;
    options.walls = true;
    options.n_frames = 20;
    options.n_samples = 600;
    options.n_wall_states = 600;
    synthetic_create(&run, &options);
    for (int round = 0; round < 40; round++) {
        char directory[64], path[80];
        int status;
        synthetic_directory(directory);
        snprintf(path, sizeof path, "%s/run.lcm", directory);
        pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0)
            record_until_killed(&run, directory);
        struct timespec while_it_writes = {.tv_nsec = (long)(synthetic_random(&random) % 100000000)};
        (void)nanosleep(&while_it_writes, NULL);
        assert_int_equal(kill(child, SIGKILL), 0);
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
        there += is_absent_or_opens(directory);
        struct run_counts counts;
        if (access(path, F_OK) == 0)
            assert_int_equal(convert_into(path, directory, &counts), STATUS_INCOMPLETE);
        there += is_absent_or_opens(directory);
        synthetic_directory_remove(directory);
    }
    assert_int_equal(there, 80);
    synthetic_free(&run);
}

static void test_kill(void **state)
{
    struct synthetic_run run;
    struct synthetic_options options = synthetic_default;
    (void)state;
    options.walls = true;
    options.n_frames = 20;
    options.n_samples = 600;
    options.n_wall_states = 3000;
    synthetic_create(&run, &options);
    for (size_t kill_at = 1; kill_at <= run.count; kill_at += run.count / 29) {
        char directory[64];
        int status;
        size_t flush_at = kill_at < 20 ? 1 : kill_at * 2 / 3;
        synthetic_directory(directory);
        pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0)
            record_and_die(&run, directory, flush_at, kill_at);
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
        check_after_kill(&run, directory, flush_at);
        check_repair(&run, directory, flush_at);
        synthetic_directory_remove(directory);
    }
    synthetic_free(&run);
}

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

/* Runs a shell command; its exit code (-1: killed), and what it said on stderr. */
static int shell(const char *command, char *errors, size_t size)
{
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    size_t used = fread(errors, 1, size - 1, pipe);
    errors[used] = '\0';
    int status = pclose(pipe);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/* Conversion into less and less room: the exit code of failed output and a reason, whatever was being written. */
static void test_file_size_limit(void **state)
{
    struct synthetic_run run;
    char directory[64], log[80], command[512], errors[4096];
    struct synthetic_options options = synthetic_default;
    int failures = 0, opened = 0;
    (void)state;
    options.n_particles = 5000;
    options.n_frames = 10;
    synthetic_directory(directory);
    snprintf(log, sizeof log, "%s/in.lcm", directory);
    synthetic_create(&run, &options);
    write_log(&run, log);
    for (int blocks = 1; blocks <= 65536; blocks *= 2) { /* of 512 bytes, as sh counts */
        snprintf(command, sizeof command, "ulimit -f %d; '%s' --from %s --out %s 2>&1 >h5dump.txt", blocks,
                 recorder_path, log, directory);
        int code = shell(command, errors, sizeof errors);
        if (code != 0) {
            failures++;
            assert_int_equal(code, status_exit_code(STATUS_IO));
            assert_non_null(strstr(errors, "recorder: error: cannot"));
            assert_non_null(strstr(errors, "File too large"));
            opened += is_absent_or_opens(directory);
        }
        snprintf(command, sizeof command, "%s/run.h5", directory);
        (void)remove(command); /* absent if not even that could be created */
    }
    assert_true(failures >= 5 && failures < 17); /* both the failure and the success were seen */
    assert_int_equal(opened, failures);
    (void)remove("h5dump.txt");
    synthetic_free(&run);
    synthetic_directory_remove(directory);
}

/* The same on a real file system that is full. */
static void test_full_disk(void **state)
{
    struct synthetic_run run;
    char directory[64], command[1024], errors[4096];
    struct synthetic_options options = synthetic_default;
    (void)state;
    if (system("unshare -rm mount -t tmpfs -o size=64k tmpfs /tmp 2>/dev/null") != 0) {
        fprintf(stderr, "SKIPPED: this kernel lets no small tmpfs be mounted (unshare -rm)\n");
        skip();
    }
    options.n_particles = 5000;
    options.n_frames = 10;
    synthetic_directory(directory);
    snprintf(command, sizeof command, "%s/in.lcm", directory);
    synthetic_create(&run, &options);
    write_log(&run, command);
    snprintf(command, sizeof command,
             "unshare -rm sh -c 'mkdir -p %s/full && mount -t tmpfs -o size=500k tmpfs %s/full && "
             "exec \"$0\" --from %s/in.lcm --out %s/full' '%s' 2>&1",
             directory, directory, directory, directory, recorder_path);
    assert_int_equal(shell(command, errors, sizeof errors), status_exit_code(STATUS_IO));
    assert_non_null(strstr(errors, "No space left on device"));
    synthetic_free(&run);
    snprintf(command, sizeof command, "%s/full", directory);
    (void)remove(command);
    synthetic_directory_remove(directory);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_kill),
        cmocka_unit_test(test_kill_at_any_time),
        cmocka_unit_test(test_file_size_limit),
        cmocka_unit_test(test_full_disk),
    };
    if (argc != 2) {
        fprintf(stderr, "usage: %s RECORDER\n", argv[0]);
        return 2;
    }
    recorder_path = argv[1];
    return cmocka_run_group_tests(tests, NULL, NULL);
}
