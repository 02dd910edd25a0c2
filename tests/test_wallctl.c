/* The process wallctl, end to end, against a stand-in for sim on a real bus: loss, foreign and hostile messages, kills,
 * signals, and the replay of a log. Run in a namespace of its own as `test_wallctl PATH_OF_WALLCTL`. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/bus.h"
#include "common/coupling.h"
#include "common/scene_file.h"
#include "shakedown_end_t.h"
#include "wall_fixture.h"
#include "wallctl/control_law.h"

enum { RUN = 77, ANSWER_MS = 20 /* as sim */, GIVE_UP_S = 30 };

static const char *wallctl_path;

/* One run: files in a directory of its own, a bus, the scene, the process. */
struct bench {
    char directory[64], scene_path[96], log_path[96], error_path[96];
    struct scene *scene;
    struct bus bus;
    pid_t child;
    struct wall_command last; /* command that came last */
    bool got;                 /* one came */
    int64_t wanted_step;
    int64_t repeats;
};

static void must(enum status status)
{
    if (status != STATUS_OK)
        fail_msg("%s: %s", status_text(status), status_message());
}

static void on_command(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    struct bench *b = user;
    struct message_header header;
    struct wall_command command;
    (void)channel;
    if (!wall_command_decode(buffer->data, buffer->data_size, &header, &command) || header.run_id != RUN)
        fail_msg("wallctl sent a command that cannot be read");
    if (command.step != b->wanted_step) /* a late copy */
        return;
    b->last = command;
    b->got = true;
}

static void path_join(char path[96], const char *directory, const char *name)
{
    assert_true(snprintf(path, 96, "%s/%s", directory, name) < 96);
}

static int setup(void **state)
{
    struct bench *b = calloc(1, sizeof *b);
    assert_non_null(b);
    strcpy(b->directory, "/tmp/shakedown-wallctl-XXXXXX");
    assert_non_null(mkdtemp(b->directory));
    path_join(b->scene_path, b->directory, "scene.cfg");
    path_join(b->log_path, b->directory, "run.lcm");
    path_join(b->error_path, b->directory, "stderr");
    FILE *file = fopen(b->scene_path, "w");
    assert_non_null(file);
    assert_true(fputs(fixture_scene_text(), file) >= 0);
    assert_int_equal(fclose(file), 0);
    b->scene = calloc(1, sizeof *b->scene);
    assert_non_null(b->scene);
    must(scene_load(b->scene, b->scene_path, NULL, 0));
    must(bus_open(&b->bus, NULL));
    must(bus_subscribe(&b->bus, CHANNEL_WALL_COMMAND, on_command, b));
    *state = b;
    return 0;
}

static int teardown(void **state)
{
    struct bench *b = *state;
    if (b->child > 0 && kill(b->child, SIGKILL) == 0)
        waitpid(b->child, NULL, 0);
    (void)!unlink(b->scene_path); /* not every test writes all */
    (void)!unlink(b->log_path);
    (void)!unlink(b->error_path);
    (void)!rmdir(b->directory);
    bus_close(&b->bus);
    fixture_scene_free(b->scene);
    free(b);
    return 0;
}

/* Starts wallctl with these arguments, stderr to a file, SIGINT ignored as a shell does it for background jobs. */
static void start(struct bench *b, const char *const *arguments)
{
    b->child = fork();
    assert_true(b->child >= 0);
    if (b->child > 0)
        return;
    if (!freopen(b->error_path, "w", stderr) || signal(SIGINT, SIG_IGN) == SIG_ERR)
        _exit(126);
    execv(wallctl_path, (char *const *)arguments);
    _exit(127);
}

static void start_control(struct bench *b)
{
    const char *const arguments[] = {"wallctl", b->scene_path, "--run-id", "77", NULL};
    start(b, arguments);
}

/* Waits for the process with a limit; handling messages meanwhile is what passes the time. */
static int exit_code(struct bench *b)
{
    double deadline_s = clock_now_s() + GIVE_UP_S;
    int result = 0;
    bool handled;
    while (waitpid(b->child, &result, WNOHANG) == 0) {
        assert_true(clock_now_s() < deadline_s);
        must(bus_handle(&b->bus, 1, &handled));
    }
    b->child = 0;
    return WIFEXITED(result) ? WEXITSTATUS(result) : 128 + WTERMSIG(result);
}

static void read_errors(const struct bench *b, char text[4096])
{
    FILE *file = fopen(b->error_path, "r");
    assert_non_null(file);
    size_t size = fread(text, 1, 4095, file);
    text[size] = '\0';
    assert_int_equal(fclose(file), 0);
}

static void state_send(struct bench *b, const struct wall_state *state, int64_t run_id)
{
    unsigned char bytes[WALL_MESSAGE_MAX];
    size_t size = wall_state_encode(state, run_id, state->step, bytes);
    assert_true(size > 0);
    must(bus_publish(&b->bus, CHANNEL_WALL_STATE, bytes, size));
}

/* Sends the state until its command comes, as sim does; the first `lose` commands are thrown away. */
static void exchange(struct bench *b, const struct wall_state *state, int lose)
{
    double deadline_s = clock_now_s() + GIVE_UP_S;
    b->wanted_step = state->step;
    for (int sent = 0;; sent++) {
        bool handled = true;
        double late_s = clock_now_s() + 1e-3 * ANSWER_MS;
        b->got = false;
        b->repeats += sent > 0;
        state_send(b, state, RUN);
        while (!b->got && clock_now_s() < late_s)
            must(bus_handle(&b->bus, ANSWER_MS, &handled));
        if (b->got && lose-- <= 0)
            return;
        assert_true(clock_now_s() < deadline_s);
    }
}

/* wallctl must say what the law says in this process, bit for bit. */
static void command_check(const struct bench *b, const struct wall_state *state)
{
    unsigned char expected[WALL_MESSAGE_MAX], got[WALL_MESSAGE_MAX];
    struct wall_command command;
    must(wallctl_law(b->scene, state, &command));
    size_t size = wall_command_encode(&command, RUN, 0, 0, expected);
    assert_int_equal(wall_command_encode(&b->last, RUN, 0, 0, got), size);
    assert_memory_equal(expected, got, size);
}

static struct wall_state first_state(void)
{
    return fixture_state(4, 0.12);
}

/* Carries out the last command; stiff springs answer. False when the protocol is done. */
static bool step_on(struct bench *b, struct wall_state *state)
{
    if (b->last.finished)
        return false;
    fixture_advance(b->scene, &b->last, state);
    fixture_springs(state, 1e4, 0.12);
    state->energy_step = state->step;
    return true;
}

static void end_send(struct bus *bus, int64_t run_id)
{
    unsigned char bytes[256];
    shakedown_end_t end = {.run_id = run_id, .reason = (char *)""};
    int size = shakedown_end_t_encode(bytes, 0, sizeof bytes, &end);
    assert_true(size > 0);
    must(bus_publish(bus, "END", bytes, (size_t)size));
}

/* 100 + 200 + 200 + 100 + 100 steps in intervals of 3, cut at the ends of the stages, and the last command. */
enum { FIXTURE_EXCHANGES = 34 + 67 + 67 + 34 + 34 + 1 };

static void a_run_goes_through(void **fixture)
{
    struct bench *b = *fixture;
    struct wall_state state = first_state();
    int exchanges = 0;
    char errors[4096];
    start_control(b);
    do {
        exchange(b, &state, 0);
        command_check(b, &state);
        exchanges++;
    } while (step_on(b, &state));
    assert_int_equal(exchanges, FIXTURE_EXCHANGES);
    assert_int_equal(state.step, 700);
    end_send(&b->bus, RUN);
    assert_int_equal(exit_code(b), 0);
    read_errors(b, errors);
    assert_string_equal(errors, "");
}

/* Every 10th command lost twice over: the state comes again and gets the same bits. */
static void lost_commands_change_nothing(void **fixture)
{
    struct bench *b = *fixture;
    struct wall_state state = first_state();
    int exchanges = 0;
    start_control(b);
    do {
        exchange(b, &state, exchanges++ % 10 == 9 ? 2 : 0);
        command_check(b, &state);
    } while (step_on(b, &state));
    assert_true(b->repeats >= 2 * (FIXTURE_EXCHANGES / 10));
    end_send(&b->bus, RUN);
    assert_int_equal(exit_code(b), 0);
}

/* Killed without warning in the middle, twice: the next one goes on from the state alone. */
static void a_kill_changes_nothing(void **fixture)
{
    struct bench *b = *fixture;
    struct wall_state state = first_state();
    int exchanges = 0;
    start_control(b);
    do {
        if (exchanges == 50 || exchanges == 120) {
            assert_int_equal(kill(b->child, SIGKILL), 0);
            assert_int_equal(exit_code(b), 128 + SIGKILL);
            start_control(b);
        }
        exchange(b, &state, 0);
        command_check(b, &state);
        exchanges++;
    } while (step_on(b, &state));
    assert_int_equal(exchanges, FIXTURE_EXCHANGES);
    end_send(&b->bus, RUN);
    assert_int_equal(exit_code(b), 0);
}

/* Sends what must be dropped: 1 foreign state and END, 4 malformed messages, 1 state that the law refuses. */
static void nonsense_send(struct bench *b, const struct wall_state *state)
{
    unsigned char bytes[WALL_MESSAGE_MAX];
    size_t size = wall_state_encode(state, RUN, 0, bytes);
    state_send(b, state, RUN + 1);
    end_send(&b->bus, RUN + 1);
    must(bus_publish(&b->bus, CHANNEL_WALL_STATE, bytes, size - 1));
    must(bus_publish(&b->bus, CHANNEL_WALL_STATE, "?", 1));
    must(bus_publish(&b->bus, "END", bytes, size));                  /* another type */
    bytes[size - 4 * WALL_STATE_ARRAYS * sizeof(double) - 4] = 0x20; /* 2^29 + 4 walls */
    must(bus_publish(&b->bus, CHANNEL_WALL_STATE, bytes, size));
    struct wall_state refused = *state;
    refused.stage = 99;
    state_send(b, &refused, RUN);
}

static void nonsense_is_dropped_and_counted(void **fixture)
{
    struct bench *b = *fixture;
    struct wall_state state = first_state();
    char errors[4096];
    start_control(b);
    exchange(b, &state, 0); /* it listens from here on */
    nonsense_send(b, &state);
    while (step_on(b, &state)) {
        exchange(b, &state, 0);
        command_check(b, &state);
    }
    end_send(&b->bus, RUN);
    assert_int_equal(exit_code(b), 0);
    read_errors(b, errors);
    assert_non_null(strstr(errors, "stage 99"));
    assert_non_null(strstr(errors, "2 messages of other runs, 4 malformed, 1 states refused"));
}

/* After a first signal it still answers and takes END; it was started with SIGINT ignored. */
static void a_signal_leaves_time_for_the_end(void **fixture)
{
    struct bench *b = *fixture;
    struct wall_state state = first_state();
    start_control(b);
    exchange(b, &state, 0);
    assert_int_equal(kill(b->child, SIGINT), 0);
    for (int k = 0; k < 20 && step_on(b, &state); k++) {
        exchange(b, &state, 0);
        command_check(b, &state);
    }
    end_send(&b->bus, RUN);
    assert_int_equal(exit_code(b), 0);
}

/* Signals that come together count once, so the second goes on being sent until the process is gone. */
static void a_second_signal_ends_it_at_once(void **fixture)
{
    struct bench *b = *fixture;
    struct wall_state state = first_state();
    char errors[4096];
    bool handled;
    int result = 0;
    start_control(b);
    exchange(b, &state, 0);
    double start_s = clock_now_s();
    while (waitpid(b->child, &result, WNOHANG) == 0) {
        assert_int_equal(kill(b->child, SIGTERM), 0);
        must(bus_handle(&b->bus, ANSWER_MS, &handled));
        assert_true(clock_now_s() - start_s < GIVE_UP_S);
    }
    b->child = 0;
    assert_true(WIFEXITED(result));
    assert_int_equal(WEXITSTATUS(result), 130);
    read_errors(b, errors);
    assert_non_null(strstr(errors, "before END"));
}

static void without_end_the_grace_is_bounded(void **fixture)
{
    struct bench *b = *fixture;
    struct wall_state state = first_state();
    start_control(b);
    exchange(b, &state, 0);
    double start_s = clock_now_s();
    assert_int_equal(kill(b->child, SIGTERM), 0);
    assert_int_equal(exit_code(b), 130);
    assert_true(clock_now_s() - start_s >= 5); /* the grace */
}

static void wrong_command_lines_are_refused(void **fixture)
{
    struct bench *b = *fixture;
    const char *const no_run[] = {"wallctl", b->scene_path, NULL};
    const char *const no_scene[] = {"wallctl", "--run-id", "1", NULL};
    const char *const bad_key[] = {"wallctl", b->scene_path, "--run-id", "1", "--set", "nonsense=1", NULL};
    const char *const missing[] = {"wallctl", "/nowhere/scene.cfg", "--run-id", "1", NULL};
    start(b, no_run);
    assert_int_equal(exit_code(b), 2);
    start(b, no_scene);
    assert_int_equal(exit_code(b), 2);
    start(b, bad_key);
    assert_int_equal(exit_code(b), 3);
    start(b, missing);
    assert_int_equal(exit_code(b), 5);
}

/* ---- replay ---- */

enum damage { DAMAGE_NONE, DAMAGE_BIT, DAMAGE_NO_END, DAMAGE_NO_COMMANDS };

/* A log as sim --in-process or the recorder writes it, with something wrong in it. */
static void log_write(const struct bench *b, enum damage damage)
{
    char url[128];
    unsigned char bytes[WALL_MESSAGE_MAX];
    struct wall_state state = first_state();
    struct bench follower = {.scene = b->scene};
    struct bus log;
    (void)remove(b->log_path); /* of a case before */
    snprintf(url, sizeof url, "file://%s?mode=w", b->log_path);
    must(bus_open(&log, url));
    for (int k = 0; k == 0 || step_on(&follower, &state); k++) {
        must(wallctl_law(b->scene, &state, &follower.last));
        must(bus_publish(&log, CHANNEL_WALL_STATE, bytes, wall_state_encode(&state, RUN, k, bytes)));
        size_t size = wall_command_encode(&follower.last, RUN, k, state.time_s, bytes);
        if (damage == DAMAGE_BIT && k == 40)
            bytes[size - 1] ^= 1; /* last bit of the last wall's damping */
        if (damage != DAMAGE_NO_COMMANDS)
            must(bus_publish(&log, CHANNEL_WALL_COMMAND, bytes, size));
    }
    if (damage != DAMAGE_NO_END)
        end_send(&log, RUN);
    must(bus_flush(&log));
    bus_close(&log);
}

static int replay(struct bench *b, enum damage damage, char errors[4096])
{
    const char *const arguments[] = {"wallctl", "--replay", b->log_path, b->scene_path, NULL};
    log_write(b, damage);
    start(b, arguments);
    int code = exit_code(b);
    read_errors(b, errors);
    return code;
}

static void a_replay_gives_the_same_bits(void **fixture)
{
    struct bench *b = *fixture;
    char errors[4096];
    assert_int_equal(replay(b, DAMAGE_NONE, errors), 0);
    assert_string_equal(errors, "");
}

static void a_replay_finds_one_wrong_bit(void **fixture)
{
    struct bench *b = *fixture;
    char errors[4096];
    assert_int_equal(replay(b, DAMAGE_BIT, errors), 6);
    assert_non_null(strstr(errors, "step 118: damping_kg_per_s[3]")); /* 100 + 6 x 3 */
}

static void a_replay_wants_end_and_commands(void **fixture)
{
    struct bench *b = *fixture;
    char errors[4096];
    assert_int_equal(replay(b, DAMAGE_NO_END, errors), 9);
    assert_non_null(strstr(errors, "no END"));
    assert_int_equal(replay(b, DAMAGE_NO_COMMANDS, errors), 9);
    assert_non_null(strstr(errors, "record.walls"));
}

static void another_scene_is_found_out(void **fixture)
{
    struct bench *b = *fixture;
    const char *const arguments[] = {
        "wallctl", "--replay", b->log_path, b->scene_path, "--set", "stages.1.walls.z.strain=0.036", NULL};
    char errors[4096];
    log_write(b, DAMAGE_NONE);
    start(b, arguments);
    assert_int_equal(exit_code(b), 6);
    read_errors(b, errors);
    assert_non_null(strstr(errors, "step 100:")); /* the first of the stage */
}

#define RUN_TEST(test) cmocka_unit_test_setup_teardown(test, setup, teardown)

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        RUN_TEST(a_run_goes_through),
        RUN_TEST(lost_commands_change_nothing),
        RUN_TEST(a_kill_changes_nothing),
        RUN_TEST(nonsense_is_dropped_and_counted),
        RUN_TEST(a_signal_leaves_time_for_the_end),
        RUN_TEST(a_second_signal_ends_it_at_once),
        RUN_TEST(without_end_the_grace_is_bounded),
        RUN_TEST(wrong_command_lines_are_refused),
        RUN_TEST(a_replay_gives_the_same_bits),
        RUN_TEST(a_replay_finds_one_wrong_bit),
        RUN_TEST(a_replay_wants_end_and_commands),
        RUN_TEST(another_scene_is_found_out),
    };
    if (argc != 2) {
        fprintf(stderr, "usage: test_wallctl PATH_OF_WALLCTL\n");
        return 2;
    }
    wallctl_path = argv[1];
    return cmocka_run_group_tests(tests, NULL, NULL);
}
