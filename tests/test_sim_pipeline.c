/* The real processes on a small scene: the same bits in one process, over LCM with an exchange at every step, after the
 * controller was killed, and in replays of both sides. Run in a namespace of its own as
 * `test_sim_pipeline SIM WALLCTL RECORDER SCENE`. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/bus.h"
#include "common/coupling.h"
#include "common/message.h"
#include "shakedown_end_t.h"

enum { GIVE_UP_S = 60, PATH_MAX_LENGTH = 256, DISTURB_AT_STEP = 700 };

static const char *sim_path, *wallctl_path, *recorder_path, *scene_path;
static char directory[64];
static const char *scheme = "coupling.scheme=hold";  /* of every run and replay */
static const char *ahead = "coupling.ahead_steps=0"; /* for compensated */

static void must(enum status status)
{
    if (status != STATUS_OK)
        fail_msg("%s: %s", status_text(status), status_message());
}

/* "<directory>/<run>/<file>" */
static const char *path_in(const char *run, const char *file)
{
    static char path[4][PATH_MAX_LENGTH];
    static int next;
    char *to = path[next++ % 4];
    assert_true(snprintf(to, PATH_MAX_LENGTH, "%s/%s/%s", directory, run, file) < PATH_MAX_LENGTH);
    return to;
}

/* Starts a program; stdout and stderr go to `output`. `arguments` ends with NULL. */
static pid_t start(const char *output, const char *const *arguments)
{
    pid_t child = fork();
    assert_true(child >= 0);
    if (child > 0)
        return child;
    if (!freopen(output, "w", stderr) || dup2(STDERR_FILENO, STDOUT_FILENO) < 0)
        _exit(126);
    execvp(arguments[0], (char *const *)arguments);
    _exit(127);
}

static int exit_code(int result)
{
    return WIFEXITED(result) ? WEXITSTATUS(result) : 128 + WTERMSIG(result);
}

static int run_program(const char *output, const char *const *arguments)
{
    int result = 0;
    pid_t child = start(output, arguments);
    assert_int_equal(waitpid(child, &result, 0), child);
    return exit_code(result);
}

static void text_of(const char *path, char *text, size_t size)
{
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    size_t length = fread(text, 1, size - 1, file);
    text[length] = '\0';
    assert_int_equal(fclose(file), 0);
}

static void expect_success(const char *what, int code, const char *output)
{
    char text[2048];
    text_of(output, text, sizeof text);
    if (code != 0)
        fail_msg("%s ended with %d: %s", what, code, text);
}

static void make_directory(const char *run)
{
    assert_int_equal(mkdir(path_in(run, ""), 0777), 0);
}

/* ---- what a log says ---- */

struct log_end {
    bool found;
    int64_t step, state_hash, wall_states, repeated, records_repeated;
};

static void on_end(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    struct log_end *end = user;
    shakedown_end_t message = {0};
    (void)channel;
    assert_true(shakedown_end_t_decode(buffer->data, 0, (int)buffer->data_size, &message) >= 0);
    *end = (struct log_end){true,
                            message.step,
                            message.state_hash,
                            message.wall_states,
                            message.commands_repeated,
                            message.records_repeated};
    shakedown_end_t_decode_cleanup(&message);
}

static struct log_end end_of(const char *run)
{
    char url[PATH_MAX_LENGTH + 32];
    struct bus bus;
    struct log_end end = {0};
    bool handled = true;
    snprintf(url, sizeof url, "file://%s", path_in(run, "run.lcm"));
    must(bus_open(&bus, url));
    must(bus_subscribe(&bus, "END", on_end, &end));
    while (handled)
        must(bus_handle(&bus, 0, &handled));
    bus_close(&bus);
    assert_true(end.found);
    return end;
}

/* ---- runs ---- */

/* sim with the law inside, into <run>/run.lcm, and from that run.h5. */
static void run_in_process(const char *run, const char *setting)
{
    char url[PATH_MAX_LENGTH + 32];
    make_directory(run);
    snprintf(url, sizeof url, "file://%s?mode=w", path_in(run, "run.lcm"));
    const char *const sim[] = {sim_path, scene_path, "--in-process", "--lcm", url,   "--set",
                               setting,  "--set",    scheme,         "--set", ahead, NULL};
    expect_success("sim", run_program(path_in(run, "sim.txt"), sim), path_in(run, "sim.txt"));
    const char *const convert[] = {recorder_path, "--from", path_in(run, "run.lcm"), "--out", path_in(run, "."), NULL};
    expect_success("recorder", run_program(path_in(run, "recorder.txt"), convert), path_in(run, "recorder.txt"));
}

struct live {
    struct bus bus;
    pid_t sim, wallctl, recorder;
    int64_t step;        /* of the last wall state seen */
    struct relay *relay; /* the recorder hears this run through it; NULL: as the others do */
    int64_t disturb_at;  /* step at which wallctl is killed and started again, or sim interrupted; 0: none */
    bool interrupts;
    bool disturbed;   /* on a busy machine the run may end before its step is seen here */
    int wallctl_code; /* -1: it runs */
};

/* Between the bus of the run and one of the recorder's own, on another port; does not let through the first copy of
 * every LOSE_EVERY-th state and command. */
enum { LOSE_EVERY = 250 };
struct relay {
    struct bus *run, recorder;
    int64_t last_seq[2]; /* of the states and commands that came */
    int lost;
};
#define RECORDER_URL "udpm://239.255.76.67:7999?ttl=0"

static void on_state(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    struct live *live = user;
    struct message_header header;
    (void)channel;
    assert_true(message_header_read(buffer->data, buffer->data_size, &header));
    live->step = header.step;
}

static void to_recorder(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    struct relay *relay = user;
    struct message_header header;
    assert_true(message_header_read(buffer->data, buffer->data_size, &header));
    const bool command = strcmp(channel, CHANNEL_WALL_COMMAND) == 0;
    if (command || strcmp(channel, CHANNEL_WALL_STATE) == 0) {
        const bool first = header.seq > relay->last_seq[command];
        if (first)
            relay->last_seq[command] = header.seq;
        if (first && header.seq % LOSE_EVERY == 0) {
            relay->lost++;
            return;
        }
    }
    must(bus_publish(&relay->recorder, channel, buffer->data, buffer->data_size));
}

static void to_sim(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    struct relay *relay = user;
    must(bus_publish(relay->run, channel, buffer->data, buffer->data_size));
}

static void relay_start(struct relay *relay, struct bus *run)
{
    *relay = (struct relay){.run = run, .last_seq = {-1, -1}};
    must(bus_open(&relay->recorder, RECORDER_URL));
    for (int c = 0; c < RECORD_CHANNELS; c++)
        must(bus_subscribe(run, record_channel_name[c], to_recorder, relay));
    must(bus_subscribe(run, CHANNEL_WALL_STATE, to_recorder, relay));
    must(bus_subscribe(run, CHANNEL_WALL_COMMAND, to_recorder, relay));
    must(bus_subscribe(&relay->recorder, CHANNEL_RECORD_ACK, to_sim, relay));
}

static pid_t start_wallctl(const char *run, const char *setting)
{
    const char *const arguments[] = {wallctl_path, scene_path, "--run-id", "5",   "--set", setting,
                                     "--set",      scheme,     "--set",    ahead, NULL};
    return start(path_in(run, "wallctl.txt"), arguments);
}

static void disturb(struct live *live, const char *run, const char *setting)
{
    int result;
    live->disturbed = true;
    if (live->interrupts) {
        assert_int_equal(kill(live->sim, SIGINT), 0);
        return;
    }
    assert_int_equal(kill(live->wallctl, SIGKILL), 0); /* it may have ended: nobody has waited for it yet */
    assert_int_equal(waitpid(live->wallctl, &result, 0), live->wallctl);
    live->wallctl_code = exit_code(result);
    live->disturbed = live->wallctl_code == 128 + SIGKILL;
    if (!live->disturbed)
        return;
    live->wallctl_code = -1;
    live->wallctl = start_wallctl(run, setting);
}

/* Handles what is there, 10 ms at most; the messages that come pass the time. */
static void listen_to(struct live *live)
{
    bool handled;
    must(bus_handle(&live->bus, live->relay ? 1 : 10, &handled));
    while (handled && live->relay)
        must(bus_handle(&live->bus, 0, &handled));
    for (handled = live->relay != NULL; handled;)
        must(bus_handle(&live->relay->recorder, 0, &handled));
}

/* Follows the run until sim ends. Returns its exit code. */
static int follow(struct live *live, const char *run, const char *setting)
{
    double deadline_s = clock_now_s() + GIVE_UP_S;
    int result;
    while (waitpid(live->sim, &result, WNOHANG) == 0) {
        assert_true(clock_now_s() < deadline_s);
        listen_to(live);
        if (live->disturb_at > 0 && live->step >= live->disturb_at && !live->disturbed && live->wallctl_code < 0)
            disturb(live, run, setting);
    }
    return exit_code(result);
}

/* sim, wallctl and recorder over the bus, into <run>/run.h5 and run.lcm. All of them end well, but for a sim that was
 * interrupted. */
static void run_with(struct live *live, const char *run, const char *setting)
{
    int result;
    live->step = live->wallctl_code = -1;
    make_directory(run);
    must(bus_open(&live->bus, NULL));
    must(bus_subscribe(&live->bus, CHANNEL_WALL_STATE, on_state, live));
    if (live->relay)
        relay_start(live->relay, &live->bus);
    const char *const recorder[] = {
        recorder_path, "--run-id", "5", "--out", path_in(run, "."), live->relay ? "--lcm" : NULL, RECORDER_URL, NULL};
    const char *const sim[] = {sim_path, scene_path, "--run-id", "5",   "--set", setting,
                               "--set",  scheme,     "--set",    ahead, NULL};
    live->recorder = start(path_in(run, "recorder.txt"), recorder);
    live->wallctl = start_wallctl(run, setting);
    live->sim = start(path_in(run, "sim.txt"), sim);
    int code = follow(live, run, setting);
    live->disturbed &= !live->interrupts || code != 0; /* 0: it had ended when the signal came */
    if (live->interrupts && live->disturbed)
        assert_int_equal(code, status_exit_code(STATUS_INTERRUPTED));
    else
        expect_success("sim", code, path_in(run, "sim.txt"));
    if (live->wallctl_code < 0) {
        assert_int_equal(waitpid(live->wallctl, &result, 0), live->wallctl);
        live->wallctl_code = exit_code(result);
    }
    expect_success("wallctl", live->wallctl_code, path_in(run, "wallctl.txt"));
    assert_int_equal(waitpid(live->recorder, &result, 0), live->recorder);
    expect_success("recorder", exit_code(result), path_in(run, "recorder.txt"));
    if (live->relay)
        bus_close(&live->relay->recorder);
    bus_close(&live->bus);
}

static void run_live(const char *run, const char *setting)
{
    struct live live = {0};
    run_with(&live, run, setting);
}

static void remove_run(const char *run)
{
    const char *const arguments[] = {"rm", "-rf", path_in(run, ""), NULL};
    assert_int_equal(run_program("/dev/null", arguments), 0);
}

/* The same, disturbed while it goes on: tried until it happened. */
static void run_disturbed(const char *run, const char *setting, bool interrupts)
{
    for (int attempt = 0; attempt < 20; attempt++) {
        struct live live = {.disturb_at = DISTURB_AT_STEP, .interrupts = interrupts};
        run_with(&live, run, setting);
        if (live.disturbed)
            return;
        remove_run(run);
    }
    fail_msg("the run always ended before it was disturbed");
}

/* ---- comparisons ---- */

static int compare_data(const char *a, const char *b, const char *group)
{
    const char *const arguments[] = {SAME_DATA_SCRIPT, path_in(a, "run.h5"), path_in(b, "run.h5"), group, NULL};
    return run_program(path_in(b, "h5diff.txt"), arguments);
}

static void same_data(const char *a, const char *b, const char *group)
{
    expect_success("same_data.sh", compare_data(a, b, group), path_in(b, "h5diff.txt"));
}

static void same_run(const char *a, const char *b)
{
    struct log_end first = end_of(a), second = end_of(b);
    assert_int_equal(first.step, second.step);
    assert_int_equal(first.wall_states, second.wall_states);
    assert_true(first.state_hash == second.state_hash);
    same_data(a, b, "/samples");
    same_data(a, b, "/observables");
    same_data(a, b, "/walls");
    same_data(a, b, "/particles");
}

/* Exit code of a replay of <run>/run.lcm; what it printed stays in replay.txt. */
static int replay(const char *program, const char *run, const char *log, const char *setting)
{
    const char *const arguments[] = {program, "--replay", path_in(run, log), scene_path, "--set", setting,
                                     "--set", scheme,     "--set",           ahead,      NULL};
    return run_program(path_in(run, "replay.txt"), arguments);
}

static void expect_replay(const char *program, const char *run, const char *log, const char *setting, int code,
                          const char *says)
{
    char text[2048];
    int got = replay(program, run, log, setting);
    text_of(path_in(run, "replay.txt"), text, sizeof text);
    if (got != code || !strstr(text, says))
        fail_msg("replay ended with %d instead of %d and without \"%s\": %s", got, code, says, text);
}

/* ---- the tests ---- */

static const char every_step[] = "coupling.interval_steps=1", every_seventh[] = "coupling.interval_steps=7";

static void the_same_seed_gives_the_same_bits(void **state)
{
    (void)state;
    run_in_process("one", every_step);
    run_in_process("two", every_step);
    same_run("one", "two");
    run_in_process("other", "seed=8");
    assert_true(end_of("one").state_hash != end_of("other").state_hash);
    assert_int_equal(compare_data("one", "other", "/samples"), 1); /* the comparison can fail */
}

static void over_the_bus_at_every_step_gives_the_same_bits(void **state)
{
    (void)state;
    run_live("bus", every_step);
    same_run("one", "bus");
}

static void a_killed_controller_changes_nothing(void **state)
{
    (void)state;
    run_disturbed("killed", every_step, false);
    same_run("one", "killed");
}

/* The first state and command, the last, and some between: sim sends them again, and the record is the same. */
static void what_the_recorder_alone_has_lost_comes_again(void **state)
{
    struct relay relay;
    struct live live = {.relay = &relay};
    (void)state;
    run_with(&live, "lossy", every_step);
    assert_int_equal(relay.lost, 2 * (2500 / LOSE_EVERY + 1)); /* of 2501 exchanges */
    /* END counts what came again before it was made. An exchange takes 20 to 50 us, 250 of them about as long as sim
     * waits at least for an acknowledgement (10 ms): the last three states and commands may come again after END. On a
     * busy machine sim repeats states to the controller as well: each such copy, and its answer, may be one that the
     * recorder lacked. */
    const struct log_end end = end_of("lossy");
    assert_true(end.records_repeated + 2 * end.repeated >= relay.lost - 2 * 3);
    same_run("one", "lossy");
    expect_replay(sim_path, "lossy", "run.lcm", every_step, 0, "2501 wall states equal, 2501 commands");
}

/* With the controller asked ahead there is always an answer on its way: the record is complete all the same, and what
 * it counts is there. */
static void an_interrupted_run_is_recorded_whole(void **state)
{
    (void)state;
    scheme = "coupling.scheme=pipelined";
    run_disturbed("interrupted", every_seventh, true);
    struct log_end end = end_of("interrupted");
    assert_true(end.step >= DISTURB_AT_STEP && end.wall_states > DISTURB_AT_STEP / 7);
    scheme = "coupling.scheme=hold";
}

/* Coarser exchange is another motion, but the same one on both sides of the bus. */
static void over_the_bus_at_every_seventh_step(void **state)
{
    (void)state;
    run_in_process("seven", every_seventh);
    run_live("bus7", every_seventh);
    same_run("seven", "bus7");
    assert_true(end_of("one").state_hash != end_of("seven").state_hash);
}

/* Each scheme: the same motion on both sides of the bus, also when the controller dies meanwhile, and in replays. */
static void every_scheme_gives_the_same_bits(void **state)
{
    static const char *const schemes[] = {"coupling.scheme=jacobian",    "coupling.scheme=pipelined",
                                          "coupling.scheme=adaptive",    "coupling.scheme=impedance",
                                          "coupling.scheme=compensated", "coupling.scheme=compensated"};
    (void)state;
    for (int k = 0; k < 6; k++) {
        char here[32], bus[40];
        scheme = schemes[k];
        ahead = k < 5 ? "coupling.ahead_steps=0" : "coupling.ahead_steps=3";
        snprintf(here, sizeof here, "%s%s", strchr(scheme, '=') + 1, k < 5 ? "" : "-ahead");
        snprintf(bus, sizeof bus, "%s-bus", here);
        run_in_process(here, every_seventh);
        run_disturbed(bus, every_seventh, false);
        same_run(here, bus);
        assert_true(end_of(here).state_hash != end_of("seven").state_hash);
        expect_replay(wallctl_path, bus, "run.lcm", every_seventh, 0, "commands equal");
        expect_replay(sim_path, bus, "run.lcm", every_seventh, 0, "wall states equal");
    }
    assert_true(end_of("compensated").state_hash != end_of("compensated-ahead").state_hash);
    scheme = "coupling.scheme=hold";
    ahead = "coupling.ahead_steps=0";
}

static void replays_give_the_same_bits(void **state)
{
    (void)state;
    static const char *const runs[] = {"one", "bus", "killed"};
    for (int k = 0; k < 3; k++) {
        expect_replay(wallctl_path, runs[k], "run.lcm", every_step, 0, "2501 commands equal");
        expect_replay(sim_path, runs[k], "run.lcm", every_step, 0, "2501 wall states equal, 2501 commands");
    }
    expect_replay(sim_path, "bus7", "run.lcm", every_seventh, 0, "359 wall states equal"); /* 215 + 143 + the end */
}

/* A material that differs in the last digits is found by the first force that it changes. */
static void a_replay_finds_another_material(void **state)
{
    (void)state;
    expect_replay(sim_path, "one", "run.lcm", "material.gamma_n_kg_per_s=0.1000000000001", 6, "in the log, is");
    expect_replay(wallctl_path, "one", "run.lcm", "stages.0.walls.x.pressure_pa=5000.000000001", 6, "the law says");
}

/* Copies the first `bytes` of a log. */
static void log_cut(const char *run, const char *name, long bytes)
{
    FILE *from = fopen(path_in(run, "run.lcm"), "rb"), *to = fopen(path_in(run, name), "wb");
    assert_true(from && to);
    for (long k = 0; k < bytes; k++) {
        int c = getc(from);
        assert_true(c != EOF && putc(c, to) != EOF);
    }
    assert_int_equal(fclose(from), 0);
    assert_int_equal(fclose(to), 0);
}

static void a_replay_wants_the_whole_log(void **state)
{
    struct stat info;
    (void)state;
    assert_int_equal(stat(path_in("one", "run.lcm"), &info), 0);
    log_cut("one", "half.lcm", (long)info.st_size / 2);
    expect_replay(sim_path, "one", "half.lcm", every_step, 9, "and no END");
    log_cut("one", "almost.lcm", (long)info.st_size - 8);
    expect_replay(sim_path, "one", "almost.lcm", every_step, 9, "no END");
    run_in_process("sampled", "record.walls=sampled");
    expect_replay(sim_path, "sampled", "run.lcm", every_step, 9, "record.walls = \"full\"");
    expect_replay(sim_path, "one", "missing.lcm", every_step, 7, "missing.lcm");
}

static int remove_all(void **state)
{
    const char *const arguments[] = {"rm", "-rf", directory, NULL};
    (void)state;
    return run_program("/dev/null", arguments);
}

static int make_all(void **state)
{
    (void)state;
    strcpy(directory, "/tmp/shakedown-pipeline-XXXXXX");
    return mkdtemp(directory) ? 0 : -1;
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_same_seed_gives_the_same_bits),
        cmocka_unit_test(over_the_bus_at_every_step_gives_the_same_bits),
        cmocka_unit_test(a_killed_controller_changes_nothing),
        cmocka_unit_test(what_the_recorder_alone_has_lost_comes_again),
        cmocka_unit_test(an_interrupted_run_is_recorded_whole),
        cmocka_unit_test(over_the_bus_at_every_seventh_step),
        cmocka_unit_test(every_scheme_gives_the_same_bits),
        cmocka_unit_test(replays_give_the_same_bits),
        cmocka_unit_test(a_replay_finds_another_material),
        cmocka_unit_test(a_replay_wants_the_whole_log),
    };
    if (argc != 5) {
        fprintf(stderr, "usage: test_sim_pipeline SIM WALLCTL RECORDER SCENE\n");
        return 2;
    }
    sim_path = argv[1];
    wallctl_path = argv[2];
    recorder_path = argv[3];
    scene_path = argv[4];
    return cmocka_run_group_tests(tests, make_all, remove_all);
}
