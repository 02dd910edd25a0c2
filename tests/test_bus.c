/* The bus, what is read from a message before it is decoded, the record stream, signals and the command line.
 * Runs in a network namespace of its own (in_namespace.sh). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <arpa/inet.h>
#include <cmocka.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/bus.h"
#include "common/command_line.h"
#include "common/coupling.h"
#include "common/message.h"
#include "common/record_sender.h"
#include "common/signals.h"
#include "shakedown_record_ack_t.h"
#include "shakedown_wall_state_t.h"

static void must(enum status status)
{
    if (status != STATUS_OK)
        fail_msg("%s: %s", status_text(status), status_message());
}

static void count_message(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    (void)buffer;
    (void)channel;
    ++*(int *)user;
}

/* Handles messages until none comes for quiet_ms; returns their number. */
static int drain(struct bus *bus, int quiet_ms)
{
    bool handled = true;
    int count = 0;
    while (count < 1000000) {
        must(bus_handle(bus, quiet_ms, &handled));
        if (!handled)
            break;
        count++;
    }
    return count;
}

/* ---- bus ---- */

static void publish_has_a_limit(void **unused)
{
    static unsigned char data[BUS_MESSAGE_MAX + 1];
    struct bus bus;
    (void)unused;
    must(bus_open(&bus, "memq://"));
    must(bus_publish(&bus, "A", data, BUS_MESSAGE_MAX));
    assert_int_equal(bus_publish(&bus, "A", data, sizeof data), STATUS_LIMIT);
    bus_close(&bus);
}

/* LCM's own default keeps 30. memq:// loses nothing else, so every missing message is the queue's. */
static void a_burst_fits_the_queue(void **unused)
{
    struct bus bus;
    int count = 0;
    (void)unused;
    must(bus_open(&bus, "memq://"));
    must(bus_subscribe(&bus, "A", count_message, &count));
    for (int k = 0; k < 20000; k++)
        must(bus_publish(&bus, "A", &k, sizeof k));
    drain(&bus, 0);
    assert_int_equal(count, 20000);
    bus_close(&bus);
}

static void channels_are_names_not_patterns(void **unused)
{
    struct bus bus;
    int count = 0;
    (void)unused;
    must(bus_open(&bus, "memq://"));
    must(bus_subscribe(&bus, "A.B+", count_message, &count));
    must(bus_publish(&bus, "AxB", "", 1));
    must(bus_publish(&bus, "A.BB", "", 1));
    must(bus_publish(&bus, "A.B+", "", 1));
    drain(&bus, 0);
    assert_int_equal(count, 1);
    assert_int_equal(bus_subscribe(&bus, "", count_message, &count), STATUS_LIMIT);
    bus_close(&bus);
}

static void two_buses_talk(void **unused)
{
    struct bus one, two;
    int count = 0;
    (void)unused;
    must(bus_open(&one, NULL));
    must(bus_open(&two, "udpm://239.255.76.67:7667?ttl=0"));
    must(bus_subscribe(&two, "A", count_message, &count));
    must(bus_publish(&one, "A", "x", 1));
    must(bus_publish(&one, "B", "x", 1));
    bool handled = false;
    must(bus_handle(&two, 5000, &handled));
    assert_true(handled && count == 1);
    bus_close(&one);
    bus_close(&two);
}

/* ---- sealed ---- */

static void key_write(const char *path, const char *digits, mode_t mode)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_true(fprintf(file, "%s\n", digits) > 0);
    assert_int_equal(fclose(file), 0);
    assert_int_equal(chmod(path, mode), 0);
}

/* Whatever comes within a tenth of a second. */
static int hears(struct bus *bus, const int *count)
{
    bool handled;
    const double until = clock_now_s() + 0.1;
    while (clock_now_s() < until)
        must(bus_handle(bus, 20, &handled));
    return *count;
}

/* Two who share a key hear each other, through LCM's receiver and without. Who has none or another is not heard, nor a
 * copy on another channel; and LCM's decoders read a sealed message. */
static void a_sealed_bus_hears_its_own(void **unused)
{
    char path[] = "/tmp/test-key-XXXXXX";
    struct bus ours, receiver[2], stranger, other;
    int count[2] = {0, 0};
    unsigned char state[WALL_MESSAGE_MAX + SEAL_SIZE], end[WALL_MESSAGE_MAX + SEAL_SIZE];
    const struct wall_state empty = {.n_walls = 4};
    shakedown_wall_state_t decoded;
    (void)unused;
    close(mkstemp(path));
    must(bus_open(&stranger, NULL));
    key_write(path, "00112233445566778899aabbccddeeff", 0600);
    assert_int_equal(setenv("SHAKEDOWN_KEY", path, 1), 0);
    must(bus_open(&ours, NULL));
    must(bus_open(&receiver[0], NULL));
    must(bus_open_direct(&receiver[1], NULL));
    key_write(path, "ff112233445566778899aabbccddeeff", 0600);
    must(bus_open(&other, NULL));
    for (int k = 0; k < 2; k++)
        must(bus_subscribe(&receiver[k], "A", count_message, &count[k]));
    const size_t size = wall_state_encode(&empty, 1, 0, state);
    must(bus_publish(&stranger, "A", state, size));
    must(bus_publish(&other, "A", state, size));
    must(message_seal_add(ours.seal, "B", state, size, end));
    must(bus_publish(&stranger, "A", end, size + SEAL_SIZE));
    must(bus_publish(&stranger, "A", "short", 5));
    for (int k = 0; k < 2; k++) {
        assert_int_equal(hears(&receiver[k], &count[k]), 0);
        assert_int_equal(receiver[k].seal->refused, 4);
    }
    must(bus_publish(&ours, "A", state, size));
    for (int k = 0; k < 2; k++)
        assert_int_equal(hears(&receiver[k], &count[k]), 1);
    assert_true(shakedown_wall_state_t_decode(end, 0, (int)(size + SEAL_SIZE), &decoded) >= 0);
    assert_int_equal(decoded.n_walls, 4);
    shakedown_wall_state_t_decode_cleanup(&decoded);
    for (int k = 0; k < 2; k++)
        bus_close(&receiver[k]);
    bus_close(&ours);
    bus_close(&other);
    bus_close(&stranger);
    assert_int_equal(unsetenv("SHAKEDOWN_KEY"), 0);
    unlink(path);
}

/* Keys that others may read, that are none, that are not there. */
static void a_bad_key_is_refused(void **unused)
{
    char path[] = "/tmp/test-key-XXXXXX";
    struct message_seal *seal;
    (void)unused;
    close(mkstemp(path));
    key_write(path, "00112233445566778899aabbccddeeff", 0640);
    assert_int_equal(message_seal_create(&seal, path), STATUS_IO);
    key_write(path, "00112233445566778899aabbccddee", 0600);
    assert_int_equal(message_seal_create(&seal, path), STATUS_FORMAT);
    key_write(path, "0011223344556677x899aabbccddeeff", 0600);
    assert_int_equal(message_seal_create(&seal, path), STATUS_FORMAT);
    unlink(path);
    assert_int_equal(message_seal_create(&seal, path), STATUS_IO);
}

/* A namespace without any route, in a child so that this one keeps its own. */
/* ---- received without LCM's thread ---- */

struct heard {
    int count;
    size_t size;
    unsigned char first, last;
    char channel[64];
};

static void hear(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    struct heard *heard = user;
    const unsigned char *data = buffer->data;
    heard->count++;
    heard->size = buffer->data_size;
    heard->first = buffer->data_size ? data[0] : 0;
    heard->last = buffer->data_size ? data[buffer->data_size - 1] : 0;
    snprintf(heard->channel, sizeof heard->channel, "%s", channel);
}

static void direct_hears_what_lcm_says(void **unused)
{
    static unsigned char large[BUS_MESSAGE_MAX];
    struct bus lcm, direct;
    struct heard walls = {0}, ack = {0}, back = {0};
    void *handle;
    (void)unused;
    must(bus_open(&lcm, NULL));
    must(bus_open_direct(&direct, NULL));
    assert_non_null(direct.receiver);
    must(bus_subscribe(&direct, "WALL_COMMAND", hear, &walls));
    must(bus_subscribe_for_a_while(&direct, "RECORD_ACK", hear, &ack, &handle));
    must(bus_subscribe(&lcm, "WALL_STATE", hear, &back));
    large[0] = 1;
    large[BUS_MESSAGE_MAX - 1] = 2;
    must(bus_publish(&lcm, "WALL_COMMAND", large, BUS_MESSAGE_MAX)); /* the largest */
    must(bus_publish(&lcm, "WALL_COMMAN", "x", 1));                  /* names that begin alike */
    must(bus_publish(&lcm, "WALL_COMMANDS", "x", 1));
    must(bus_publish(&lcm, "RECORD_ACK", "abc", 3));
    must(bus_publish(&lcm, "WALL_COMMAND", "", 0));
    assert_int_equal(drain(&direct, 100), 3);
    assert_int_equal(walls.count, 2);
    assert_int_equal(walls.size, 0);
    assert_string_equal(walls.channel, "WALL_COMMAND");
    assert_true(ack.count == 1 && ack.size == 3 && ack.first == 'a' && ack.last == 'c');
    must(bus_publish(&lcm, "WALL_COMMAND", large, BUS_MESSAGE_MAX));
    assert_int_equal(drain(&direct, 100), 1);
    assert_true(walls.size == BUS_MESSAGE_MAX && walls.first == 1 && walls.last == 2);
    bus_unsubscribe(&direct, handle);
    must(bus_publish(&lcm, "RECORD_ACK", "abc", 3));
    assert_int_equal(drain(&direct, 100), 0);
    must(bus_publish(&direct, "WALL_STATE", "yes", 3));
    assert_int_equal(drain(&lcm, 100), 1);
    assert_true(back.count == 1 && back.size == 3);
    bus_close(&direct);
    bus_close(&lcm);
}

/* Datagrams that are no LCM messages, cut ones, and those of another group on the same port. */
static void direct_drops_nonsense(void **unused)
{
    static const char *const datagrams[] = {"LC02\0\0\0\0WALL", "LC03\0\0\0\0WALL_COMMAND", "XXXX\0\0\0\0WALL_COMMAND",
                                            "L"};
    static const size_t sizes[] = {12, 21, 21, 1};
    struct bus direct, other;
    struct heard walls = {0};
    (void)unused;
    must(bus_open_direct(&direct, "udpm://239.255.76.67:7667?ttl=0"));
    must(bus_subscribe(&direct, "WALL_COMMAND", hear, &walls));
    struct sockaddr_in group = {.sin_family = AF_INET, .sin_port = htons(7667)};
    group.sin_addr.s_addr = inet_addr("239.255.76.67");
    int sender = socket(AF_INET, SOCK_DGRAM, 0);
    assert_true(sender >= 0);
    for (int k = 0; k < 4; k++)
        assert_int_equal(sendto(sender, datagrams[k], sizes[k], 0, (struct sockaddr *)&group, sizeof group), sizes[k]);
    must(bus_open(&other, "udpm://239.255.76.68:7667?ttl=0"));
    must(bus_publish(&other, "WALL_COMMAND", "x", 1));
    bool handled;
    for (int k = 0; k < 8; k++)
        must(bus_handle(&direct, 20, &handled));
    assert_int_equal(walls.count, 0);
    assert_int_equal(sendto(sender, "LC02\0\0\0\0WALL_COMMAND\0yes", 24, 0, (struct sockaddr *)&group, sizeof group),
                     24);
    assert_int_equal(drain(&direct, 100), 1);
    assert_true(walls.count == 1 && walls.size == 3);
    close(sender);
    bus_close(&other);
    bus_close(&direct);
}

/* Repeats of a state count on it. A socket's own limit counts in ticks, of 4 ms where there are 250 a second, and takes
 * one more; the shortest of many waits, as a busy machine makes some longer. */
static void short_waits_are_short(void **unused)
{
    struct bus bus;
    double shortest_s = 1;
    (void)unused;
    must(bus_open_direct(&bus, NULL));
    must(bus_subscribe(&bus, "QUIET", hear, NULL));
    for (int k = 0; k < 50; k++) {
        bool handled;
        const double start_s = clock_now_s();
        must(bus_wait(&bus, 0.0005, BUS_SLEEP, &handled));
        const double took_s = clock_now_s() - start_s;
        assert_false(handled);
        assert_true(took_s >= 0.0005);
        shortest_s = took_s < shortest_s ? took_s : shortest_s;
    }
    assert_true(shortest_s < 0.002);
    bus_close(&bus);
}

/* Looks while the last wait was short; not any more once others had a quarter of the time over 10 ms: for 0.1 s, 0.2 s
 * ... 10 s. */
static void waits_look_while_the_core_is_to_be_had(void **unused)
{
    struct short_wait wait = {0};
    double now_s = 100;
    (void)unused;
    assert_true(short_wait_looks(&wait, now_s));
    short_wait_note(&wait, 1.1 * SHORT_WAIT_S);
    assert_false(short_wait_looks(&wait, now_s));
    short_wait_note(&wait, 0.9 * SHORT_WAIT_S);
    assert_true(short_wait_looks(&wait, now_s));
    for (int k = 0; k < 100000; k++) { /* nobody takes it: a yield of 1 us; 0.1 s in all */
        now_s += 2e-6;
        short_wait_note_look(&wait, 1e-6, 1e-6, now_s);
        assert_true(short_wait_looks(&wait, now_s));
    }
    for (int k = 0; k < 100; k++) { /* a recorder that takes 0.2 ms of each 2 ms */
        now_s += 2e-3;
        short_wait_note_look(&wait, 1.8e-3, 2e-4, now_s);
        assert_true(short_wait_looks(&wait, now_s));
    }
    int looks = 0;
    for (double end_s = now_s + 20; now_s < end_s; now_s += 4e-3) { /* a program that computes takes each yield */
        if (!short_wait_looks(&wait, now_s))
            continue;
        looks++;
        short_wait_note_look(&wait, 1e-6, 4e-3, now_s);
    }
    assert_int_equal(looks, 3 * 8); /* three to a window, after 0, 0.1, 0.3, 0.7, 1.5, 3.1, 6.3 and 12.7 s */
    for (int k = 0; k < 100; k++) { /* it has ended */
        now_s += 12;
        short_wait_note_look(&wait, 1e-2, 1e-6, now_s);
        assert_true(short_wait_looks(&wait, now_s));
    }
    short_wait_note_look(&wait, 1e-6, 2e-2, now_s);
    assert_false(short_wait_looks(&wait, now_s + 0.09));
    assert_true(short_wait_looks(&wait, now_s + 0.11));
}

/* A message that comes is taken by each way of waiting, and none that comes is waited for no longer than asked. */
static void all_ways_of_waiting_hear_the_same(void **unused)
{
    struct bus bus;
    struct heard asked;
    (void)unused;
    must(bus_open_direct(&bus, NULL));
    must(bus_subscribe(&bus, "ASKED", hear, &asked));
    for (int way = BUS_SLEEP; way <= BUS_BUSY; way++) {
        bool handled;
        asked = (struct heard){0};
        must(bus_publish(&bus, "ASKED", "yes", 3));
        must(bus_wait(&bus, 5, (enum bus_patience)way, &handled));
        assert_true(handled && asked.count == 1 && asked.size == 3);
        const double start_s = clock_now_s();
        must(bus_wait(&bus, 0.003, (enum bus_patience)way, &handled));
        assert_false(handled);
        assert_true(clock_now_s() - start_s >= 0.003);
    }
    bus_close(&bus);
}

static void a_missing_route_is_named(void **unused)
{
    (void)unused;
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        struct bus bus;
        if (unshare(CLONE_NEWNET) != 0 || !freopen("/dev/null", "w", stderr)) /* LCM's own advice is long */
            _exit(2);
        if (bus_open(&bus, NULL) != STATUS_BUS || bus.lcm || bus_open_direct(&bus, NULL) != STATUS_BUS || bus.receiver)
            _exit(3);
        _exit(strstr(status_message(), "ip route add 224.0.0.0/4 dev lo") ? 0 : 4);
    }
    int result = 0;
    assert_int_equal(waitpid(child, &result, 0), child);
    assert_true(WIFEXITED(result));
    assert_int_equal(WEXITSTATUS(result), 0);
}

static void wrong_urls_are_refused(void **unused)
{
    struct bus bus;
    (void)unused;
    assert_int_equal(bus_open(&bus, "nonsense"), STATUS_BUS);
    assert_int_equal(bus_open(&bus, "file:///nowhere/at/all"), STATUS_BUS);
    assert_int_equal(bus_open(&bus, "file:///nowhere/at/all?mode=w"), STATUS_IO);
}

static void temporary_path(char path[64])
{
    snprintf(path, 64, "/tmp/shakedown-test-XXXXXX");
    int file = mkstemp(path);
    assert_true(file >= 0);
    assert_int_equal(close(file), 0);
}

static void a_log_ends_without_an_error(void **unused)
{
    char path[64], url[96];
    struct bus bus;
    int count = 0;
    bool handled = true;
    (void)unused;
    temporary_path(path);
    snprintf(url, sizeof url, "file://%s?mode=w", path);
    must(bus_open(&bus, url));
    assert_true(bus.is_log && bus.lcm);
    must(bus_subscribe(&bus, "A", count_message, &count));
    for (int k = 0; k < 3; k++)
        must(bus_publish(&bus, k == 1 ? "B" : "A", &k, sizeof k));
    must(bus_handle(&bus, 1000, &handled));
    assert_false(handled); /* nobody answers a log */
    must(bus_flush(&bus));
    bus_close(&bus);
    snprintf(url, sizeof url, "file://%s", path);
    must(bus_open(&bus, url));
    must(bus_subscribe(&bus, "A", count_message, &count));
    assert_int_equal(drain(&bus, 0), 3);
    assert_int_equal(drain(&bus, 0), 0);
    assert_int_equal(count, 2);
    bus_close(&bus);
    assert_int_equal(unlink(path), 0);
}

static void a_full_disk_is_noticed(void **unused)
{
    struct bus bus;
    (void)unused;
    must(bus_open(&bus, "file:///dev/full?mode=w"));
    enum status status = bus_publish(&bus, "A", "x", 1);
    if (status == STATUS_OK) /* still buffered */
        status = bus_flush(&bus);
    assert_int_equal(status, STATUS_IO);
    bus_close(&bus);
}

static void on_alarm(int signal_number)
{
    (void)signal_number;
}

/* A signal must end the wait: liblcm's own wait would go on without a limit. */
static void a_signal_ends_a_wait(void **unused)
{
    struct sigaction action = {.sa_handler = on_alarm}, before;
    /* again and again: the first may come before the wait where the machine is busy */
    struct itimerval soon = {.it_value = {0, 20000}, .it_interval = {0, 20000}}, never = {{0}, {0}};
    struct bus bus;
    bool handled = true;
    (void)unused;
    must(bus_open(&bus, NULL));
    assert_int_equal(sigaction(SIGALRM, &action, &before), 0);
    double start_s = clock_now_s();
    assert_int_equal(setitimer(ITIMER_REAL, &soon, NULL), 0);
    must(bus_handle(&bus, 30000, &handled));
    assert_false(handled);
    assert_true(clock_now_s() - start_s < 15); /* of 30 s; 20 ms are expected */
    assert_int_equal(setitimer(ITIMER_REAL, &never, NULL), 0);
    assert_int_equal(sigaction(SIGALRM, &before, NULL), 0);
    bus_close(&bus);
}

/* ---- messages ---- */

static struct wall_state some_state(int n_walls)
{
    struct wall_state state = {.step = 7,
                               .time_s = 0.1,
                               .stage = 2,
                               .stage_step = 5,
                               .stage_time_s = 0.3,
                               .interval_s = 1e-7,
                               .kinetic_energy_j = 1.5,
                               .elastic_energy_j = 2.5,
                               .energy_step = 6,
                               .command_step = 8,
                               .interface_residual_j = -0.0,
                               .interface_error = 0.25,
                               .interface_error_before = 0.125,
                               .n_walls = n_walls};
    for (int k = 0; k < n_walls; k++) {
        state.position_m[k] = 1 + k;
        state.velocity_m_per_s[k] = 10.1 + k;
        state.force_n[k] = 20.2 + k;
        state.stiffness_n_per_m[k] = 30.3 + k;
        state.damping_kg_per_s[k] = 40.4 + k;
        state.stage_position_m[k] = 50.5 + k;
        state.force_before_n[k] = 60.6 + k;
        state.ahead_position_m[k] = 70.7 + k;
        state.ahead_velocity_m_per_s[k] = 80.8 + k;
        state.acceleration_m_per_s2[k] = 90.9 + k;
    }
    return state;
}

/* Encoding what was decoded must give the same bytes, so every field made it both ways. */
static void walls_survive_the_bus(void **unused)
{
    unsigned char first[WALL_MESSAGE_MAX], second[WALL_MESSAGE_MAX];
    struct message_header header;
    (void)unused;
    for (int n_walls = 4; n_walls <= 6; n_walls += 2) {
        struct wall_state state = some_state(n_walls), state_back;
        size_t size = wall_state_encode(&state, 11, 12, first);
        assert_true(wall_state_decode(first, size, &header, &state_back));
        assert_true(header.run_id == 11 && header.seq == 12 && header.step == 7 && header.time_s == 0.1);
        assert_int_equal(wall_state_encode(&state_back, 11, 12, second), size);
        assert_memory_equal(first, second, size);
        assert_true(state_back.position_m[3] == 4 && state_back.stage_position_m[n_walls - 1] == 49.5 + n_walls);
        assert_true(state_back.interface_error == 0.25 && state_back.interface_error_before == 0.125);

        struct wall_command command = {.step = 9, .stage = 1, .finished = true, .n_steps = 3, .fraction_done = 0.5};
        struct wall_command command_back;
        command.n_walls = n_walls;
        command.position_m[1] = 1.25;
        command.velocity_m_per_s[2] = -0.0;
        command.acceleration_m_per_s2[n_walls - 1] = 1e300;
        command.drive[n_walls - 2] = DRIVE_IMPEDANCE;
        command.force_n[1] = 4.5;
        command.force_rate_n_per_s[2] = 5.5;
        command.force_rate2_n_per_s2[3] = 8.5;
        command.mass_kg[3] = 6.5;
        command.damping_kg_per_s[0] = 7.5;
        size = wall_command_encode(&command, 11, 13, 0.25, first);
        assert_true(wall_command_decode(first, size, &header, &command_back));
        assert_int_equal(wall_command_encode(&command_back, 11, 13, 0.25, second), size);
        assert_memory_equal(first, second, size);
        assert_true(command_back.finished && command_back.n_steps == 3 && command_back.position_m[1] == 1.25);
        assert_int_equal(command_back.drive[n_walls - 2], DRIVE_IMPEDANCE);
        assert_true(command_back.force_n[1] == 4.5 && command_back.force_rate_n_per_s[2] == 5.5);
        assert_true(command_back.force_rate2_n_per_s2[3] == 8.5);
        assert_true(command_back.mass_kg[3] == 6.5 && command_back.damping_kg_per_s[0] == 7.5);
    }
}

/* Every length, and counts that overflow the generated decoder's arithmetic: 2^29 doubles are 0 bytes in an int. */
static void hostile_messages_are_refused(void **unused)
{
    static const uint32_t counts[] = {0, 3, 5, 6, 8, 0x20000000, 0x20000004, 0x7fffffff, 0x80000000, 0xffffffff};
    unsigned char bytes[WALL_MESSAGE_MAX];
    struct wall_state state = some_state(4), back;
    struct message_header header;
    (void)unused;
    size_t size = wall_state_encode(&state, 11, 12, bytes);
    for (size_t length = 0; length < WALL_MESSAGE_MAX; length++)
        assert_true(wall_state_decode(bytes, length, &header, &back) == (length == size));
    unsigned char *count_at = bytes + size - 4 * WALL_STATE_ARRAYS * sizeof(double) - 4;
    assert_int_equal(count_at[3], 4);
    for (size_t k = 0; k < sizeof counts / sizeof counts[0]; k++) {
        for (int byte = 0; byte < 4; byte++)
            count_at[byte] = (unsigned char)(counts[k] >> (24 - 8 * byte));
        assert_false(wall_state_decode(bytes, size, &header, &back));
    }
    size = wall_state_encode(&state, 11, 12, bytes);
    bytes[0] ^= 1; /* the type's fingerprint */
    assert_false(wall_state_decode(bytes, size, &header, &back));
}

/* ---- record stream ---- */

enum { RUN = 4711 };

/* A stand-in for the recorder, in a thread with a bus of its own. */
struct recorder {
    struct bus bus;
    pthread_t thread;
    atomic_bool stop;
    unsigned drop_one_in;     /* of so many records one "gets lost", at random; 0: none */
    unsigned drop_ack_one_in; /* and of acknowledgements */
    uint64_t random;
    bool silent, failed; /* never acknowledges; cannot write */
    int lost;
    int64_t next_seq[RECORD_CHANNELS];
    bool damaged; /* a record did not hold what its channel and number ask for */
};

/* Payload after the header: bytes that follow from channel and number. */
static unsigned char filler(int channel, int64_t seq, size_t k)
{
    return (unsigned char)(channel * 71 + seq * 31 + (int64_t)k * 7);
}

static size_t record_make(int channel, int64_t seq, size_t size, unsigned char *bytes)
{
    const uint64_t fields[5] = {0, RUN, (uint64_t)seq, 0, 0};
    for (size_t k = 0; k < 40; k++)
        bytes[k] = (unsigned char)(fields[k / 8] >> (56 - 8 * (k % 8)));
    for (size_t k = 40; k < size; k++)
        bytes[k] = filler(channel, seq, k);
    return size;
}

/* At random, as losses at every n-th could fall on the same record in every round. */
static bool is_lost(struct recorder *r, unsigned one_in)
{
    r->random = r->random * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return one_in > 0 && (r->random >> 33) % one_in == 0;
}

static void ack_send(struct recorder *r, int64_t run_id, bool complete)
{
    unsigned char buffer[256];
    shakedown_record_ack_t ack = {.run_id = run_id,
                                  .n_channels = RECORD_CHANNELS,
                                  .next_seq = r->next_seq,
                                  .complete = complete,
                                  .failed = r->failed};
    if (r->silent || is_lost(r, r->drop_ack_one_in))
        return;
    int size = shakedown_record_ack_t_encode(buffer, 0, sizeof buffer, &ack);
    if (size < 0 || bus_publish(&r->bus, CHANNEL_RECORD_ACK, buffer, (size_t)size) != STATUS_OK)
        r->damaged = true;
}

static void on_record(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    struct recorder *r = user;
    struct message_header header;
    int c = 0;
    while (c < RECORD_CHANNELS && strcmp(channel, record_channel_name[c]) != 0)
        c++;
    if (is_lost(r, r->drop_one_in)) {
        r->lost++;
        return;
    }
    if (c == RECORD_CHANNELS || !message_header_read(buffer->data, buffer->data_size, &header)) {
        r->damaged = true;
        return;
    }
    if (header.seq == r->next_seq[c]) {
        r->next_seq[c]++;
        for (size_t k = 40; k < buffer->data_size; k++)
            r->damaged |= ((const unsigned char *)buffer->data)[k] != filler(c, header.seq, k);
    }
    /* This recorder knows END's totals: it comes last, so all is there when it is taken in order with the others. */
    ack_send(r, RUN,
             r->next_seq[RECORD_END] > 0 && r->next_seq[RECORD_SAMPLE] == 60 && r->next_seq[RECORD_PARTICLES] == 1);
}

static void *recorder_run(void *user)
{
    struct recorder *r = user;
    while (!atomic_load(&r->stop)) {
        bool handled = false;
        if (bus_handle(&r->bus, 20, &handled) != STATUS_OK)
            r->damaged = true;
    }
    return NULL;
}

static void recorder_start(struct recorder *r)
{
    must(bus_open(&r->bus, NULL));
    for (int c = 0; c < RECORD_CHANNELS; c++)
        must(bus_subscribe(&r->bus, record_channel_name[c], on_record, r));
    assert_int_equal(pthread_create(&r->thread, NULL, recorder_run, r), 0);
}

static void recorder_stop(struct recorder *r)
{
    atomic_store(&r->stop, true);
    assert_int_equal(pthread_join(r->thread, NULL), 0);
    bus_close(&r->bus);
    assert_false(r->damaged);
}

static enum status record_publish(struct record_sender *stream, enum record_channel channel, size_t size)
{
    static unsigned char bytes[BUS_MESSAGE_MAX];
    int64_t seq = record_sender_next_seq(stream, channel);
    return record_sender_publish(stream, channel, bytes, record_make(channel, seq, size, bytes));
}

/* 1 + 1 + 60 + 1 records of 40 B to 60 kB; returns what flush says. */
static enum status run_publish(struct record_sender *stream)
{
    TRY(record_publish(stream, RECORD_RUN_INFO, 60000));
    TRY(record_publish(stream, RECORD_PARTICLES, 49000));
    for (int k = 0; k < 60; k++) {
        TRY(record_publish(stream, RECORD_SAMPLE, (size_t)(40 + k * 997)));
        TRY(record_sender_service(stream));
    }
    TRY(record_publish(stream, RECORD_END, 1000));
    return record_sender_flush(stream);
}

static void stream_run(struct recorder *recorder, int64_t *repeated)
{
    struct record_sender *stream = NULL;
    struct bus bus;
    recorder_start(recorder);
    must(bus_open(&bus, NULL));
    must(record_sender_create(&stream, &bus, RUN, 60));
    must(run_publish(stream));
    assert_int_equal(record_sender_waiting(stream), 0);
    assert_int_equal(record_sender_total(stream, RECORD_SAMPLE), 60);
    assert_int_equal(record_sender_total(stream, RECORD_END), 1);
    *repeated = record_sender_repeated(stream);
    recorder_stop(recorder);
    for (int c = 0; c < RECORD_CHANNELS; c++)
        assert_int_equal(recorder->next_seq[c], record_sender_total(stream, (enum record_channel)c));
    record_sender_free(stream);
    bus_close(&bus);
}

static void stream_arrives(void **unused)
{
    struct recorder recorder = {0};
    int64_t repeated;
    (void)unused;
    stream_run(&recorder, &repeated);
    print_message("no loss: %lld records repeated\n", (long long)repeated);
}

/* One in 7 records and one in 3 acknowledgements lost. This recorder keeps nothing that comes early, so that each loss
 * costs a round; a round of 0.2 s at most moves a record on, six times of seven, and 60 s of silence do not come. */
static void stream_survives_loss(void **unused)
{
    struct recorder recorder = {.drop_one_in = 7, .drop_ack_one_in = 3, .random = 1};
    int64_t repeated;
    (void)unused;
    stream_run(&recorder, &repeated);
    print_message("one in 7 lost: %d; %lld repeated for 63 records\n", recorder.lost, (long long)repeated);
    assert_true(recorder.lost > 0 && repeated >= recorder.lost); /* each loss costs at least the lost one */
}

/* Without a recorder: 128 kB leave, no more; then STATUS_TIMEOUT that names the recorder, in time. */
static void stream_gives_up(void **unused)
{
    struct recorder recorder = {.silent = true};
    struct record_sender *stream = NULL;
    struct bus bus;
    (void)unused;
    must(bus_open(&bus, NULL));
    must(record_sender_create(&stream, &bus, RUN, 1));
    double start_s = clock_now_s();
    for (int k = 0; k < 10; k++)
        must(record_publish(stream, RECORD_FRAME_CONTACTS, 50000));
    must(bus_open(&recorder.bus, NULL));
    assert_int_equal(record_sender_waiting(stream), 10);
    assert_int_equal(record_sender_flush(stream), STATUS_TIMEOUT);
    assert_non_null(strstr(status_message(), "nothing heard of the recorder of run 4711"));
    assert_true(clock_now_s() - start_s < 15); /* of 1 s */
    /* Rounds of the two that fit the window; one will do on a machine that is busy. */
    assert_true(record_sender_repeated(stream) >= 2);
    record_sender_free(stream);
    bus_close(&recorder.bus);
    bus_close(&bus);
}

static void walls_acknowledge(struct bus *bus, int64_t exchanges)
{
    unsigned char buffer[256];
    int64_t none[RECORD_CHANNELS] = {0};
    const shakedown_record_ack_t ack = {
        .run_id = RUN, .next_wall_seq = exchanges, .n_channels = RECORD_CHANNELS, .next_seq = none};
    int size = shakedown_record_ack_t_encode(buffer, 0, sizeof buffer, &ack);
    assert_true(size > 0);
    must(bus_publish(bus, CHANNEL_RECORD_ACK, buffer, (size_t)size));
}

/* A window of wall exchanges without a recorder: they go out again in rounds, each time all of them as they are; the
 * next one waits, and then STATUS_TIMEOUT. */
static void stream_gives_up_walls(void **unused)
{
    struct record_sender *stream = NULL;
    struct bus bus, listener;
    unsigned char state[400], command[300];
    int states = 0, commands = 0;
    (void)unused;
    must(bus_open(&listener, NULL));
    must(bus_subscribe(&listener, CHANNEL_WALL_STATE, count_message, &states));
    must(bus_subscribe(&listener, CHANNEL_WALL_COMMAND, count_message, &commands));
    must(bus_open(&bus, NULL));
    must(record_sender_create(&stream, &bus, RUN, 1));
    for (int64_t seq = 0; seq < WALLS_WINDOW; seq++) {
        must(record_sender_wait_for_walls(stream, seq));
        record_sender_keep_wall(stream, false, seq, state, record_make(0, seq, sizeof state, state));
        record_sender_keep_wall(stream, true, seq, command, record_make(1, seq, sizeof command, command));
    }
    drain(&listener, 100);
    assert_int_equal(states + commands, 0); /* whoever keeps them has sent them */
    assert_int_equal(record_sender_wait_for_walls(stream, WALLS_WINDOW), STATUS_TIMEOUT);
    assert_non_null(strstr(status_message(), "16 exchanges of the walls wait for it"));
    drain(&listener, 100);
    walls_acknowledge(&listener, WALLS_WINDOW + 2); /* of what never was: not to be believed */
    assert_int_equal(record_sender_wait_for_walls(stream, WALLS_WINDOW), STATUS_TIMEOUT);
    walls_acknowledge(&listener, 1);
    enum status status = STATUS_TIMEOUT; /* until LCM's thread has handed it over */
    for (int k = 0; k < 1000 && status == STATUS_TIMEOUT; k++)
        status = record_sender_wait_for_walls(stream, WALLS_WINDOW);
    must(status);
    drain(&listener, 100);
    assert_true(states >= WALLS_WINDOW && commands >= WALLS_WINDOW);
    assert_int_equal(record_sender_repeated(stream), states + commands);
    record_sender_free(stream);
    bus_close(&listener);
    bus_close(&bus);
}

static void stream_keeps_its_window(void **unused)
{
    struct record_sender *stream = NULL;
    struct bus bus, listener;
    int count = 0;
    (void)unused;
    must(bus_open(&listener, NULL));
    must(bus_subscribe(&listener, "FRAME_CONTACTS", count_message, &count));
    must(bus_open(&bus, NULL));
    must(record_sender_create(&stream, &bus, RUN, 30));
    for (int k = 0; k < 10; k++)
        must(record_publish(stream, RECORD_FRAME_CONTACTS, 50000));
    bool handled = true;
    while (count < 2 && handled)
        must(bus_handle(&listener, 10000, &handled));
    drain(&listener, 200);
    /* 2 x 50 kB fit into 128 kB, 3 do not; if this took over 100 ms the same two may have been repeated. */
    assert_int_equal(count, 2 + record_sender_repeated(stream));
    record_sender_free(stream);
    bus_close(&listener);
    bus_close(&bus);
}

static void stream_hears_of_a_failed_recorder(void **unused)
{
    struct recorder recorder = {.failed = true};
    struct record_sender *stream = NULL;
    struct bus bus;
    (void)unused;
    recorder_start(&recorder);
    must(bus_open(&bus, NULL));
    must(record_sender_create(&stream, &bus, RUN, 60));
    assert_int_equal(run_publish(stream), STATUS_IO);
    assert_non_null(strstr(status_message(), "has failed; what it says itself"));
    assert_int_equal(record_publish(stream, RECORD_SAMPLE, 100), STATUS_IO); /* and it stays so */
    recorder_stop(&recorder);
    record_sender_free(stream);
    bus_close(&bus);
}

/* Acknowledgements of another run, of what was never sent, and of the wrong form must not count. */
static void stream_believes_only_its_recorder(void **unused)
{
    struct recorder liar = {0};
    struct record_sender *stream = NULL;
    struct bus bus;
    unsigned char bytes[256] = {0};
    int64_t counts[7] = {1, 1, 1, 1, 1, 1, 1};
    shakedown_record_ack_t ack = {.run_id = RUN, .n_channels = 7, .next_seq = counts, .complete = 1};
    (void)unused;
    must(bus_open(&liar.bus, NULL));
    must(bus_open(&bus, NULL));
    must(record_sender_create(&stream, &bus, RUN, 0.4));
    must(record_publish(stream, RECORD_SAMPLE, 1000));
    liar.next_seq[RECORD_SAMPLE] = 1;
    ack_send(&liar, RUN + 1, true);
    liar.next_seq[RECORD_SAMPLE] = 2;
    ack_send(&liar, RUN, true);
    int size = shakedown_record_ack_t_encode(bytes, 0, sizeof bytes, &ack);
    must(bus_publish(&liar.bus, CHANNEL_RECORD_ACK, bytes, (size_t)size));
    bytes[8 + 32] = 0x20; /* the count */
    must(bus_publish(&liar.bus, CHANNEL_RECORD_ACK, bytes, (size_t)size));
    must(bus_publish(&liar.bus, CHANNEL_RECORD_ACK, bytes, 3));
    assert_int_equal(record_sender_flush(stream), STATUS_TIMEOUT);
    assert_int_equal(record_sender_waiting(stream), 1);
    assert_false(liar.damaged);
    record_sender_free(stream);
    bus_close(&liar.bus);
    bus_close(&bus);
}

static void stream_checks_its_records(void **unused)
{
    static unsigned char bytes[BUS_MESSAGE_MAX + 1];
    struct record_sender *stream = NULL;
    struct bus bus;
    (void)unused;
    must(bus_open(&bus, NULL));
    must(record_sender_create(&stream, &bus, RUN + 1, 1));
    assert_int_equal(record_publish(stream, RECORD_SAMPLE, 100), STATUS_FORMAT); /* run_id */
    record_sender_free(stream);
    must(record_sender_create(&stream, &bus, RUN, 1));
    assert_int_equal(record_sender_publish(stream, RECORD_SAMPLE, bytes, record_make(0, 1, 100, bytes)), STATUS_FORMAT);
    assert_int_equal(record_sender_publish(stream, RECORD_SAMPLE, bytes, 10), STATUS_FORMAT);
    assert_int_equal(record_sender_publish(stream, RECORD_SAMPLE, bytes, sizeof bytes), STATUS_LIMIT);
    assert_int_equal(record_sender_total(stream, RECORD_SAMPLE), 0);
    record_sender_free(stream);
    bus_close(&bus);
}

static void stream_into_a_log_waits_for_nobody(void **unused)
{
    char path[64], url[96];
    struct record_sender *stream = NULL;
    struct bus bus;
    (void)unused;
    temporary_path(path);
    snprintf(url, sizeof url, "file://%s?mode=w", path);
    must(bus_open(&bus, url));
    must(record_sender_create(&stream, &bus, RUN, 0.1));
    must(run_publish(stream));
    assert_int_equal(record_sender_waiting(stream), 0);
    record_sender_free(stream);
    bus_close(&bus);
    snprintf(url, sizeof url, "file://%s", path);
    must(bus_open(&bus, url));
    assert_int_equal(drain(&bus, 0), 63);
    bus_close(&bus);
    assert_int_equal(unlink(path), 0);
}

/* ---- signals and command line ---- */

static void signals_are_taken_even_if_ignored(void **unused)
{
    sigset_t set;
    (void)unused;
    assert_true(signal(SIGINT, SIG_IGN) != SIG_ERR);
    assert_int_equal(sigemptyset(&set), 0);
    assert_int_equal(sigaddset(&set, SIGTERM), 0);
    assert_int_equal(sigprocmask(SIG_BLOCK, &set, NULL), 0);
    assert_false(stop_requested());
    must(signals_install());
    assert_int_equal(raise(SIGINT), 0);
    assert_true(stop_requested());
    assert_int_equal(raise(SIGTERM), 0);
    assert_int_equal(stop_request_count(), 2);
}

static enum status parse(struct command_line *line, const char **value, bool *flag, int argc, const char *const *words)
{
    char *argv[16] = {(char *)"program"};
    const struct command_line_option own[] = {{"log", value, NULL}, {"quick", NULL, flag}, {NULL, NULL, NULL}};
    for (int k = 0; k < argc; k++)
        argv[k + 1] = (char *)words[k];
    return command_line_parse(line, argc + 1, argv, own);
}
#define PARSE(...)                                                                                                     \
    parse(&line, &value, &flag, sizeof((const char *[]){__VA_ARGS__}) / sizeof(char *), (const char *[]){__VA_ARGS__})

static void command_lines_are_parsed(void **unused)
{
    struct command_line line;
    const char *value = NULL;
    bool flag = false;
    (void)unused;
    must(PARSE("scene.cfg", "--set", "a.b=1", "--seed=5000000000", "--run-id", "-3", "--lcm", "memq://", "--quick",
               "--log=x"));
    assert_int_equal(line.n_positional, 1);
    assert_string_equal(line.positional[0], "scene.cfg");
    assert_int_equal(line.n_overrides, 2);
    assert_string_equal(line.override[0], "a.b=1");
    assert_string_equal(line.override[1], "seed=5000000000L");
    assert_true(line.run_id_given && line.run_id == -3 && flag);
    assert_string_equal(line.lcm_url, "memq://");
    assert_string_equal(value, "x");
    must(PARSE("--help"));
    assert_true(line.help && !line.run_id_given);
}

static void wrong_command_lines_are_refused(void **unused)
{
    struct command_line line;
    const char *value = NULL;
    bool flag = false;
    (void)unused;
    assert_int_equal(PARSE("--nonsense"), STATUS_USAGE);
    assert_int_equal(PARSE("--run-id", "12x"), STATUS_USAGE);
    assert_int_equal(PARSE("--run-id", "99999999999999999999"), STATUS_USAGE);
    assert_int_equal(PARSE("--run-id"), STATUS_USAGE);
    assert_int_equal(PARSE("--seed", ""), STATUS_USAGE);
    assert_int_equal(PARSE("--seed", "1", "--seed", "2"), STATUS_USAGE);
    assert_int_equal(PARSE("--set", "novalue"), STATUS_USAGE);
    assert_int_equal(PARSE("--quick=1"), STATUS_USAGE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(publish_has_a_limit),
        cmocka_unit_test(a_burst_fits_the_queue),
        cmocka_unit_test(channels_are_names_not_patterns),
        cmocka_unit_test(two_buses_talk),
        cmocka_unit_test(a_sealed_bus_hears_its_own),
        cmocka_unit_test(a_bad_key_is_refused),
        cmocka_unit_test(direct_hears_what_lcm_says),
        cmocka_unit_test(direct_drops_nonsense),
        cmocka_unit_test(short_waits_are_short),
        cmocka_unit_test(waits_look_while_the_core_is_to_be_had),
        cmocka_unit_test(all_ways_of_waiting_hear_the_same),
        cmocka_unit_test(a_missing_route_is_named),
        cmocka_unit_test(wrong_urls_are_refused),
        cmocka_unit_test(a_log_ends_without_an_error),
        cmocka_unit_test(a_full_disk_is_noticed),
        cmocka_unit_test(a_signal_ends_a_wait),
        cmocka_unit_test(walls_survive_the_bus),
        cmocka_unit_test(hostile_messages_are_refused),
        cmocka_unit_test(stream_arrives),
        cmocka_unit_test(stream_survives_loss),
        cmocka_unit_test(stream_gives_up),
        cmocka_unit_test(stream_gives_up_walls),
        cmocka_unit_test(stream_keeps_its_window),
        cmocka_unit_test(stream_hears_of_a_failed_recorder),
        cmocka_unit_test(stream_believes_only_its_recorder),
        cmocka_unit_test(stream_checks_its_records),
        cmocka_unit_test(stream_into_a_log_waits_for_nobody),
        cmocka_unit_test(signals_are_taken_even_if_ignored),
        cmocka_unit_test(command_lines_are_parsed),
        cmocka_unit_test(wrong_command_lines_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
