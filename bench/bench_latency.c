/* bench_latency [--json FILE] [--rounds N]: where an exchange between sim and wallctl spends its time. Two processes
 * answer each other, layer by layer: a byte through pipes (one wake-up each way), a datagram over multicast loopback
 * (sockets added), LCM (its receiver thread, queue and pipe added), wall messages and the control law (encoding,
 * checks, physics added); then with a third process on the same bus, with waits that do not sleep, and with a pause of
 * 0.1 ms before each round in which the asking process computes, as sim does between exchanges. Least and median of
 * many rounds in microseconds, context switches per round of both processes. */
#include <arpa/inet.h>
#include <jansson.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/bus.h"
#include "common/coupling.h"
#include "common/scene_file.h"
#include "wallctl/control_law.h"

enum { ROUNDS = 4000, WARM_UP = 200, GIVE_UP_MS = 2000 };
#define GROUP "239.255.76.67"
enum { PORT = 17667, LCM_PORT = 17668 };

/* One end of a connection; `serve`: wait for the question and answer it, else ask and wait for the answer. */
struct end {
    int in, out; /* pipe */
    int socket;
    struct sockaddr_in group;
    struct bus bus;
    const struct scene *scene;
    enum bus_patience patience;
    bool law, direct, is_server;
    int64_t seen;
};

struct layer {
    const char *name, *what;
    void (*open)(struct end *end);
    void (*round)(struct end *end, int64_t k);
    bool law, listener, direct;
    enum bus_patience patience;
    double pause_s; /* before a round */
};

static void must(bool good, const char *what)
{
    if (good)
        return;
    perror(what);
    exit(1);
}

static void must_ok(enum status status)
{
    if (status == STATUS_OK)
        return;
    fprintf(stderr, "bench_latency: error: %s\n", status_message());
    exit((int)status);
}

/* ---- pipes ---- */

static void pipe_open(struct end *end)
{
    (void)end; /* made before the fork */
}

static void pipe_round(struct end *end, int64_t k)
{
    char byte = (char)k;
    if (!end->is_server)
        must(write(end->out, &byte, 1) == 1, "write");
    must(read(end->in, &byte, 1) == 1, "read");
    if (end->is_server)
        must(write(end->out, &byte, 1) == 1, "write");
}

/* ---- datagrams ---- */

static void socket_open(struct end *end)
{
    const int on = 1;
    end->socket = socket(AF_INET, SOCK_DGRAM, 0);
    must(end->socket >= 0, "socket");
    end->group = (struct sockaddr_in){.sin_family = AF_INET, .sin_port = htons(PORT)};
    end->group.sin_addr.s_addr = inet_addr(GROUP);
    struct sockaddr_in here = end->group;
    here.sin_addr.s_addr = htonl(INADDR_ANY);
    struct ip_mreq membership = {.imr_multiaddr = end->group.sin_addr};
    must(setsockopt(end->socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) == 0, "SO_REUSEADDR");
    must(setsockopt(end->socket, SOL_SOCKET, SO_REUSEPORT, &on, sizeof on) == 0, "SO_REUSEPORT");
    const struct timeval patience = {.tv_sec = GIVE_UP_MS / 1000, .tv_usec = GIVE_UP_MS % 1000 * 1000};
    must(setsockopt(end->socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience) == 0, "SO_RCVTIMEO");
    must(bind(end->socket, (struct sockaddr *)&here, sizeof here) == 0, "bind");
    must(setsockopt(end->socket, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) == 0, "multicast");
}

static void datagram_send(struct end *end, int64_t value)
{
    char data[500] = {0};
    memcpy(data, &value, sizeof value);
    must(sendto(end->socket, data, sizeof data, 0, (struct sockaddr *)&end->group, sizeof end->group) == sizeof data,
         "sendto");
}

/* Everyone hears everything, oneself included: questions are even, answers odd. */
static void datagram_wait(struct end *end, int64_t value)
{
    char data[512];
    int64_t got = -1;
    while (got != value) {
        must(recv(end->socket, data, sizeof data, 0) > 0, "recv");
        memcpy(&got, data, sizeof got);
    }
}

static void socket_round(struct end *end, int64_t k)
{
    if (end->is_server) {
        datagram_wait(end, 2 * k);
        datagram_send(end, 2 * k + 1);
    } else {
        datagram_send(end, 2 * k);
        datagram_wait(end, 2 * k + 1);
    }
}

/* ---- LCM ---- */

static void on_message(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    struct end *end = user;
    struct message_header header;
    (void)channel;
    if (message_header_read(buffer->data, buffer->data_size, &header))
        end->seen = header.seq;
}

static void lcm_open(struct end *end)
{
    char url[64];
    snprintf(url, sizeof url, "udpm://" GROUP ":%d?ttl=0", LCM_PORT);
    end->seen = -1;
    must_ok((end->direct ? bus_open_direct : bus_open)(&end->bus, url));
    must_ok(bus_subscribe(&end->bus, end->is_server ? CHANNEL_WALL_STATE : CHANNEL_WALL_COMMAND, on_message, end));
}

static void lcm_wait(struct end *end, int64_t k)
{
    bool handled = true;
    while (end->seen != k && handled)
        must_ok(bus_wait(&end->bus, 1e-3 * GIVE_UP_MS, end->patience, &handled));
    if (!handled) {
        fprintf(stderr, "bench_latency: error: a message was lost\n");
        exit(STATUS_TIMEOUT);
    }
}

static struct wall_state some_state(int64_t k)
{
    struct wall_state state = {.step = k, .command_step = k, .stage_step = k % 1000, .n_walls = 4};
    for (int w = 0; w < 4; w++) {
        state.position_m[w] = state.ahead_position_m[w] = state.stage_position_m[w] = w % 2;
        state.force_n[w] = 1;
    }
    return state;
}

static void lcm_round(struct end *end, int64_t k)
{
    unsigned char bytes[WALL_MESSAGE_MAX];
    struct wall_state state = some_state(k);
    struct wall_command command = {.step = k, .n_walls = 4};
    if (!end->is_server) {
        must_ok(bus_publish(&end->bus, CHANNEL_WALL_STATE, bytes, wall_state_encode(&state, 1, k, bytes)));
        lcm_wait(end, k);
        return;
    }
    lcm_wait(end, k);
    if (end->law)
        must_ok(wallctl_law(end->scene, &state, &command));
    must_ok(bus_publish(&end->bus, CHANNEL_WALL_COMMAND, bytes, wall_command_encode(&command, 1, k, 0, bytes)));
}

/* Another process on the bus that wants none of these messages: what recorder is. */
static pid_t listener_start(void)
{
    pid_t child = fork();
    must(child >= 0, "fork");
    if (child > 0)
        return child;
    struct end end = {.is_server = true};
    char url[64];
    bool handled;
    snprintf(url, sizeof url, "udpm://" GROUP ":%d?ttl=0", LCM_PORT);
    must_ok(bus_open(&end.bus, url));
    must_ok(bus_subscribe(&end.bus, CHANNEL_STATUS, on_message, &end));
    for (int k = 0; k < 600; k++) /* a minute at most; killed before */
        must_ok(bus_handle(&end.bus, 100, &handled));
    _exit(0);
}

/* ---- measuring ---- */

static const char scene_text[] =
    "dimension = 2;\n"
    "sample = { count = 1; radius_min_m = 0.001; radius_max_m = 0.001; density_kg_per_m3 = 2000.0; };\n"
    "material = { kn_n_per_m = 1.0; };\n"
    "walls = { x = { mode = \"stress\"; pressure_pa = 1.0; mass_kg = 1.0; damping_kg_per_s = 1.0; };\n"
    "  z = { mode = \"strain\"; strain = 0.035; frequency_hz = 10.0; }; };\n"
    "stages = ( { name = \"a\"; dt_s = 1e-3; duration_s = 1e6; } );\n";

static const double PAUSE_S = 1e-4;
static const struct layer layers[] = {
    {"pipe", "one byte through a pipe and back", pipe_open, pipe_round, false, false, false, BUS_SLEEP, 0},
    {"datagram", "500 bytes over multicast loopback and back", socket_open, socket_round, false, false, false,
     BUS_SLEEP, 0},
    {"lcm", "the same through LCM", lcm_open, lcm_round, false, false, false, BUS_SLEEP, 0},
    {"law", "wall messages, with the control law", lcm_open, lcm_round, true, false, false, BUS_SLEEP, 0},
    {"listener", "with a third process on the bus", lcm_open, lcm_round, true, true, false, BUS_SLEEP, 0},
    {"direct", "received in the own thread, the rest filtered", lcm_open, lcm_round, true, true, true, BUS_SLEEP, 0},
    {"looking", "looking for it while nobody else wants the core", lcm_open, lcm_round, true, true, true, BUS_LOOK, 0},
    {"busy", "always looking (coupling.busy_poll)", lcm_open, lcm_round, true, true, true, BUS_BUSY, 0},
    {"direct, p", "direct, with a pause before each", lcm_open, lcm_round, true, true, true, BUS_SLEEP, PAUSE_S},
    {"looking, p", "looking, with a pause before each", lcm_open, lcm_round, true, true, true, BUS_LOOK, PAUSE_S},
};

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static long switches(int who)
{
    struct rusage usage;
    must(getrusage(who, &usage) == 0, "getrusage");
    return usage.ru_nvcsw + usage.ru_nivcsw;
}

static void serve(struct end *end, const struct layer *layer, int rounds)
{
    layer->open(end);
    must(write(end->out, "r", 1) == 1, "write"); /* ready */
    for (int64_t k = 0; k < rounds + WARM_UP; k++)
        layer->round(end, k);
    _exit(0);
}

static json_t *measure(const struct layer *layer, const struct scene *scene, int rounds)
{
    int there[2], back[2], result;
    char ready;
    double *round_us = calloc((size_t)rounds, sizeof *round_us);
    must(round_us && pipe(there) == 0 && pipe(back) == 0, "pipe");
    pid_t listener = layer->listener ? listener_start() : 0;
    long child_before = switches(RUSAGE_CHILDREN);
    pid_t server = fork();
    must(server >= 0, "fork");
    struct end end = {.scene = scene,
                      .law = layer->law,
                      .patience = layer->patience,
                      .direct = layer->direct,
                      .in = back[0],
                      .out = there[1]};
    if (server == 0) {
        end.is_server = true;
        end.in = there[0];
        end.out = back[1];
        must(close(there[1]) == 0 && close(back[0]) == 0, "close");
        serve(&end, layer, rounds);
    }
    must(close(there[0]) == 0 && close(back[1]) == 0, "close"); /* so that the end of the other is seen */
    layer->open(&end);
    must(read(end.in, &ready, 1) == 1, "the answering process");
    long before = 0;
    for (int64_t k = 0; k < rounds + WARM_UP; k++) {
        if (k == WARM_UP)
            before = switches(RUSAGE_SELF);
        const double until_s = clock_now_s() + layer->pause_s;
        while (clock_now_s() < until_s)
            continue;
        const double start = clock_now_s();
        layer->round(&end, k);
        if (k >= WARM_UP)
            round_us[k - WARM_UP] = 1e6 * (clock_now_s() - start);
    }
    long own = switches(RUSAGE_SELF) - before;
    must(waitpid(server, &result, 0) == server && result == 0, "the answering process");
    long child = switches(RUSAGE_CHILDREN) - child_before;
    if (listener) {
        must(kill(listener, SIGKILL) == 0 && waitpid(listener, &result, 0) == listener, "the third process");
    }
    if (end.bus.lcm)
        bus_close(&end.bus);
    if (end.socket > 0)
        close(end.socket);
    must(close(there[1]) == 0 && close(back[0]) == 0, "close");
    qsort(round_us, (size_t)rounds, sizeof *round_us, by_size);
    json_t *row = json_pack("{s:s, s:s, s:f, s:f, s:f, s:f}", "layer", layer->name, "what", layer->what, "least_us",
                            round_us[0], "median_us", round_us[rounds / 2], "p99_us", round_us[rounds * 99 / 100],
                            "switches", (double)(own + child) / rounds);
    printf("%-10s %8.1f %8.1f %8.1f %8.1f   %s\n", layer->name, round_us[0], round_us[rounds / 2],
           round_us[rounds * 99 / 100], (double)(own + child) / rounds, layer->what);
    fflush(stdout);
    free(round_us);
    return row;
}

int main(int argc, char **argv)
{
    const char *json = NULL;
    int rounds = ROUNDS;
    struct scene *scene = calloc(1, sizeof *scene);
    json_t *rows = json_array();
    for (int k = 1; k < argc; k++) {
        if (strcmp(argv[k], "--json") == 0 && k + 1 < argc)
            json = argv[++k];
        else if (strcmp(argv[k], "--rounds") == 0 && k + 1 < argc)
            rounds = atoi(argv[++k]);
        else
            rounds = 0;
    }
    if (rounds < 100 || rounds > 1000000) {
        fprintf(stderr, "usage: bench_latency [--json FILE] [--rounds 100 ... 1000000]\n");
        return STATUS_USAGE;
    }
    must(scene != NULL, "calloc");
    must_ok(scene_parse(scene, scene_text, "bench_latency"));
    printf("%-10s %8s %8s %8s %8s\n", "round trip", "least us", "median", "99 %", "switches");
    for (size_t k = 0; k < sizeof layers / sizeof *layers; k++)
        json_array_append_new(rows, measure(&layers[k], scene, rounds));
    must(!json || json_dump_file(rows, json, JSON_INDENT(1)) == 0, "the JSON file");
    json_decref(rows);
    scene_free(scene);
    free(scene);
    return 0;
}
