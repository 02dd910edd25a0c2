/* shakedown-watch: shows the progress of one run, as told by STATUS, until END. Only listens. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "common/bus.h"
#include "common/command_line.h"
#include "common/message.h"
#include "common/signals.h"
#include "common/watch/progress.h"

/* Between lines when the output is no terminal, and between looks at the clock. */
static const double plain_interval_s = 5;
enum { WAIT_MS = 200 };

struct watch {
    int64_t run_id;
    bool on_terminal;
    bool line_open; /* the cursor stands behind a progress line */
    bool ended;
    double last_message_s;
    double last_line_s;
};

static int terminal_columns(void)
{
    struct winsize size;
    if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0)
        return 80;
    return size.ws_col;
}

static void clear_line(struct watch *watch)
{
    if (watch->line_open)
        fputs("\r\033[K", stderr);
    watch->line_open = false;
}

static void show(struct watch *watch, const shakedown_status_t *status)
{
    char text[PROGRESS_TEXT_MAX];
    watch->last_message_s = clock_now_s();
    if (watch->on_terminal) {
        progress_format(text, status, terminal_columns() - 1);
        fprintf(stderr, "\r\033[K%s", text);
        watch->line_open = true;
    } else if (watch->last_message_s - watch->last_line_s >= plain_interval_s) {
        progress_format(text, status, 0);
        fprintf(stderr, "%s\n", text);
        watch->last_line_s = watch->last_message_s;
    }
}

static void on_status(const lcm_recv_buf_t *received, const char *channel, void *user)
{
    struct watch *watch = user;
    union message message;
    (void)channel;
    if (message_decode(MESSAGE_STATUS, received->data, received->data_size, &message) != STATUS_OK)
        return; /* for people only: the next one comes in 0.1 s */
    if (message.header.run_id == watch->run_id && !watch->ended)
        show(watch, &message.status);
    message_free(MESSAGE_STATUS, &message);
}

static void on_end(const lcm_recv_buf_t *received, const char *channel, void *user)
{
    struct watch *watch = user;
    union message message;
    char text[PROGRESS_TEXT_MAX];
    (void)channel;
    if (message_decode(RECORD_END, received->data, received->data_size, &message) != STATUS_OK)
        return; /* repeated until the recorder has it */
    if (message.header.run_id == watch->run_id && !watch->ended) {
        watch->ended = true;
        clear_line(watch);
        progress_format_end(text, &message.end);
        fprintf(stderr, "%s\n", text);
    }
    message_free(RECORD_END, &message);
}

/* Listens until END, a signal, or `timeout_s` of silence (0: no limit). */
static enum status watch_run(struct watch *watch, struct bus *bus, double timeout_s)
{
    TRY(bus_subscribe(bus, CHANNEL_STATUS, on_status, watch));
    TRY(bus_subscribe(bus, record_channel_name[RECORD_END], on_end, watch));
    watch->last_message_s = clock_now_s();
    while (!watch->ended && !stop_requested()) {
        bool handled;
        TRY(bus_handle(bus, WAIT_MS, &handled));
        if (timeout_s > 0 && clock_now_s() - watch->last_message_s > timeout_s)
            return status_fail(STATUS_TIMEOUT, "nothing heard of run %lld for %g s", (long long)watch->run_id,
                               timeout_s);
    }
    return STATUS_OK;
}

static enum status parse_timeout(const char *text, double *timeout_s)
{
    char *rest;
    *timeout_s = 0;
    if (!text)
        return STATUS_OK;
    *timeout_s = strtod(text, &rest);
    if (rest == text || *rest || !(*timeout_s > 0))
        return status_fail(STATUS_USAGE, "--timeout: %s is no time in seconds above 0", text);
    return STATUS_OK;
}

/* A folder may come from anywhere: a file:// URL in it would have watch write a file. */
static enum status url_check(const char *url)
{
    static const char *const networks[] = {"udpm://", "tcpq://", "memq://"};
    for (size_t k = 0; url && k < sizeof networks / sizeof *networks; k++) {
        if (strncmp(url, networks[k], strlen(networks[k])) == 0)
            return STATUS_OK;
    }
    if (!url || !url[0])
        return STATUS_OK;
    return status_fail(STATUS_USAGE, "\"%.200s\" is no bus to listen to: udpm://, tcpq:// or memq://", url);
}

static enum status run(int argc, char **argv)
{
    const char *timeout = NULL;
    const struct command_line_option own[] = {{"timeout", &timeout, NULL}, {0}};
    struct command_line line;
    struct watch watch = {.on_terminal = isatty(STDERR_FILENO)};
    struct bus bus;
    double timeout_s;
    TRY(command_line_parse(&line, argc, argv, own));
    if (line.help || line.version) {
        puts(line.help ? "usage: shakedown-watch --run-id N [--lcm URL] [--timeout SECONDS]" : SHAKEDOWN_VERSION);
        return STATUS_OK;
    }
    TRY(parse_timeout(timeout, &timeout_s));
    if (!line.run_id_given || line.n_positional > 0)
        return status_fail(STATUS_USAGE, "usage: shakedown-watch --run-id N [--lcm URL] [--timeout SECONDS]");
    watch.run_id = line.run_id;
    signal(SIGTTOU, SIG_IGN); /* it writes from the background */
    TRY(signals_install());
    TRY(url_check(line.lcm_url));
    TRY(bus_open_direct(&bus, line.lcm_url));
    enum status status = watch_run(&watch, &bus, timeout_s);
    clear_line(&watch);
    bus_close(&bus);
    return status;
}

int main(int argc, char **argv)
{
    return status_report("shakedown-watch", run(argc, argv));
}
