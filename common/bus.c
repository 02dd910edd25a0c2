#include "common/bus.h"

#include <errno.h>
#include <math.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "common/udp_receiver.h"

#define DEFAULT_URL      "udpm://239.255.76.67:7667?ttl=0"
#define RECV_BUF_SIZE    "recv_buf_size=4194304"
#define UDPM_SCHEME      "udpm://"
#define LOG_SCHEME       "file://"
#define NO_MULTICAST_FIX "`ip link set lo up; ip route add 224.0.0.0/4 dev lo`, or run with --private"

enum { URL_MAX = 4096, QUEUE_CAPACITY = 65536, CHANNEL_NAME_MAX = 63 /* LCM's own limit */ };

#define RECORD_CHANNEL_NAME(name) #name,
const char *const record_channel_name[RECORD_CHANNELS] = {RECORD_CHANNEL_LIST(RECORD_CHANNEL_NAME)};
#undef RECORD_CHANNEL_NAME

double clock_now_s(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now); /* cannot fail with this clock */
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static bool starts_with(const char *text, const char *start)
{
    return strncmp(text, start, strlen(start)) == 0;
}

static const char *url_resolve(const char *url)
{
    const char *environment = getenv("LCM_DEFAULT_URL");
    if (url && url[0])
        return url;
    return environment && environment[0] ? environment : DEFAULT_URL;
}

/* Appends the options that Shakedown always wants. */
static enum status url_complete(const char *url, char full[URL_MAX])
{
    const char *option = NULL;
    if (starts_with(url, UDPM_SCHEME) && !strstr(url, "recv_buf_size="))
        option = RECV_BUF_SIZE;
    int length =
        snprintf(full, URL_MAX, "%s%s%s", url, option ? (strchr(url, '?') ? "&" : "?") : "", option ? option : "");
    return length < URL_MAX ? STATUS_OK : status_fail(STATUS_USAGE, "the LCM URL is longer than %d bytes", URL_MAX - 1);
}

static enum status open_failure(const char *url)
{
    if (starts_with(url, UDPM_SCHEME))
        return status_fail(STATUS_BUS,
                           "cannot open the LCM bus \"%s\": most likely there is no multicast route, or a firewall "
                           "drops multicast; try " NO_MULTICAST_FIX,
                           url);
    if (starts_with(url, LOG_SCHEME))
        return status_fail(STATUS_BUS, "cannot read the event log \"%s\": missing, empty or not an LCM log", url);
    return status_fail(STATUS_BUS, "cannot open the LCM bus \"%s\": not a URL that LCM knows", url);
}

static enum status log_open(struct bus *bus, const char *url, const char *mode)
{
    char path[URL_MAX];
    snprintf(path, sizeof path, "%s", url + strlen(LOG_SCHEME));
    char *options = strchr(path, '?');
    if (options)
        *options = '\0';
    if (mode) {
        TRY(event_writer_open(&bus->log, path, mode[0] == 'a' ? EVENT_START_APPEND : EVENT_START_NEW));
    } else {
        bus->replay = calloc(1, sizeof *bus->replay);
        if (!bus->replay)
            return status_fail(STATUS_NO_MEMORY, "no memory to read a log");
        if (event_reader_open(bus->replay, path) != STATUS_OK)
            return open_failure(url);
    }
    bus->lcm = lcm_create("memq://"); /* takes subscriptions; nothing comes of itself */
    return bus->lcm ? STATUS_OK : status_fail(STATUS_BUS, "cannot set up LCM without a network");
}

/* LCM's threads inherit this thread's signal mask. With everything blocked in them, signals reach the loop that looks
 * at them and never interrupt a receive. */
static lcm_t *lcm_create_quiet(const char *url, bool *receives)
{
    sigset_t all, before;
    bool masked = sigfillset(&all) == 0 && pthread_sigmask(SIG_SETMASK, &all, &before) == 0;
    lcm_t *lcm = lcm_create(url);
    *receives = lcm && lcm_get_fileno(lcm) >= 0; /* sets up the receiver, self test included */
    if (masked)
        pthread_sigmask(SIG_SETMASK, &before, NULL);
    return lcm;
}

/* "w", "a", or NULL for a log that is read. */
static const char *log_write_mode(const char *url)
{
    const char *options = strchr(url, '?');
    if (!options)
        return NULL;
    return strstr(options, "mode=w") ? "w" : strstr(options, "mode=a") ? "a" : NULL;
}

static enum status open_url(struct bus *bus, const char *url, bool direct)
{
    char full[URL_MAX];
    bool receives = false;
    memset(bus, 0, sizeof *bus);
    TRY(url_complete(url_resolve(url), full));
    bus->is_log = starts_with(full, LOG_SCHEME);
    if (bus->is_log) {
        enum status status = log_open(bus, full, log_write_mode(full));
        if (status != STATUS_OK)
            bus_close(bus);
        return status;
    }
    const char *key = getenv("SHAKEDOWN_KEY");
    if (key && *key && starts_with(full, UDPM_SCHEME))
        TRY(message_seal_create(&bus->seal, key));
    if (direct && udp_receiver_open(&bus->receiver, full) != STATUS_OK) {
        bus_close(bus);
        return open_failure(full);
    }
    bus->lcm = bus->receiver ? lcm_create(full) : lcm_create_quiet(full, &receives);
    if (receives || (bus->receiver && bus->lcm))
        return STATUS_OK;
    bus_close(bus);
    return open_failure(full);
}

enum status bus_open(struct bus *bus, const char *url)
{
    return open_url(bus, url, false);
}

enum status bus_open_direct(struct bus *bus, const char *url)
{
    return open_url(bus, url, true);
}

/* A subscription of a sealed bus. */
struct listener {
    struct listener *next;
    struct message_seal *seal;
    lcm_msg_handler_t handler;
    void *user;
    void *subscription;
};

static void seal_close(struct bus *bus)
{
    if (bus->seal && bus->seal->refused > 0)
        fprintf(stderr, "shakedown: warning: %lld messages without the seal of this run were ignored\n",
                (long long)bus->seal->refused);
    while (bus->listeners) {
        struct listener *first = bus->listeners;
        bus->listeners = first->next;
        free(first);
    }
    free(bus->seal);
}

void bus_close(struct bus *bus)
{
    udp_receiver_close(bus->receiver);
    if (bus->lcm)
        lcm_destroy(bus->lcm);
    if (event_writer_close(bus->log) != STATUS_OK)
        fprintf(stderr, "shakedown: warning: %s\n", status_message()); /* bus_flush says it in time */
    if (bus->replay)
        event_reader_close(bus->replay);
    free(bus->replay);
    seal_close(bus);
    memset(bus, 0, sizeof *bus);
}

enum status bus_flush(struct bus *bus)
{
    return bus->log ? event_writer_flush(bus->log) : STATUS_OK;
}

enum status bus_log_sync(struct bus *bus, int64_t *size)
{
    *size = 0;
    if (!bus->log)
        return STATUS_OK;
    TRY(event_writer_sync(bus->log));
    *size = event_writer_size(bus->log);
    return STATUS_OK;
}

enum status bus_log_cut(struct bus *bus, int64_t size)
{
    if (!bus->log)
        return status_fail(STATUS_FORMAT, "there is no event log to be gone on from");
    return event_writer_cut(bus->log, size);
}

/* LCM takes channels as regular expressions; a backslash makes every other sign stand for itself. */
static enum status channel_escape(const char *channel, char escaped[2 * CHANNEL_NAME_MAX + 1])
{
    size_t length = strlen(channel), out = 0;
    if (length == 0 || length > CHANNEL_NAME_MAX)
        return status_fail(STATUS_LIMIT, "a channel name has 1 to %d characters, \"%s\" has %zu", CHANNEL_NAME_MAX,
                           channel, length);
    for (size_t k = 0; k < length; k++) {
        if (strchr("\\^$.|?*+()[]{}", channel[k]))
            escaped[out++] = '\\';
        escaped[out++] = channel[k];
    }
    escaped[out] = '\0';
    return STATUS_OK;
}

static void on_sealed(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    const struct listener *listener = user;
    lcm_recv_buf_t opened = *buffer;
    if (!message_seal_check(listener->seal, channel, buffer->data, buffer->data_size))
        return;
    opened.data_size -= SEAL_SIZE;
    listener->handler(&opened, channel, listener->user);
}

static enum status subscribe(struct bus *bus, const char *channel, lcm_msg_handler_t handler, void *user, void **handle)
{
    char pattern[2 * CHANNEL_NAME_MAX + 1];
    *handle = NULL;
    TRY(channel_escape(channel, pattern));
    if (bus->receiver)
        return udp_receiver_subscribe(bus->receiver, channel, handler, user, handle);
    lcm_subscription_t *subscription = lcm_subscribe(bus->lcm, pattern, handler, user);
    *handle = subscription;
    if (!subscription)
        return status_fail(STATUS_BUS, "cannot subscribe to %s; if the LCM self test failed, try " NO_MULTICAST_FIX,
                           channel);
    /* The default of 30 drops the newest message without a word. */
    if (lcm_subscription_set_queue_capacity(subscription, QUEUE_CAPACITY) != 0)
        return status_fail(STATUS_BUS, "cannot set the queue capacity of %s", channel);
    return STATUS_OK;
}

enum status bus_subscribe_for_a_while(struct bus *bus, const char *channel, lcm_msg_handler_t handler, void *user,
                                      void **handle)
{
    *handle = NULL;
    if (!bus->seal)
        return subscribe(bus, channel, handler, user, handle);
    struct listener *listener = calloc(1, sizeof *listener);
    if (!listener)
        return status_fail(STATUS_NO_MEMORY, "no memory for a subscription");
    *listener = (struct listener){.next = bus->listeners, .seal = bus->seal, .handler = handler, .user = user};
    bus->listeners = listener;
    TRY(subscribe(bus, channel, on_sealed, listener, &listener->subscription));
    *handle = listener;
    return STATUS_OK;
}

enum status bus_subscribe(struct bus *bus, const char *channel, lcm_msg_handler_t handler, void *user)
{
    void *subscription = NULL;
    return bus_subscribe_for_a_while(bus, channel, handler, user, &subscription);
}

void bus_unsubscribe(struct bus *bus, void *handle)
{
    const struct listener *listener = handle; /* freed with the bus */
    void *subscription = bus->seal && listener ? listener->subscription : handle;
    if (bus->receiver)
        udp_receiver_unsubscribe(bus->receiver, subscription);
    else if (subscription && lcm_unsubscribe(bus->lcm, subscription) != 0)
        fprintf(stderr, "shakedown: warning: LCM does not know a subscription that is to end\n");
}

/* Whoever writes a log itself is told of a full disk at once. */
static enum status log_write(struct bus *bus, const char *channel, const void *data, size_t size)
{
    TRY(event_writer_add(bus->log, channel, data, size));
    return event_writer_is_full(bus->log) ? event_writer_flush(bus->log) : STATUS_OK;
}

enum status bus_publish(struct bus *bus, const char *channel, const void *data, size_t size)
{
    if (size > BUS_MESSAGE_MAX)
        return status_fail(STATUS_LIMIT, "a message of %zu bytes on %s; the limit is %d", size, channel,
                           BUS_MESSAGE_MAX);
    if (bus->log)
        return log_write(bus, channel, data, size);
    unsigned char sealed[BUS_MESSAGE_MAX + SEAL_SIZE];
    if (bus->seal) {
        TRY(message_seal_add(bus->seal, channel, data, size, sealed));
        data = sealed;
        size += SEAL_SIZE;
    }
    if (lcm_publish(bus->lcm, channel, data, (unsigned)size) != 0)
        return status_fail(STATUS_BUS, "cannot publish %zu bytes on %s: %s", size, channel, strerror(errno));
    return STATUS_OK;
}

/* Gives the next message of the log to those who have subscribed to its channel. */
static enum status log_handle(struct bus *bus, bool *handled)
{
    struct event event;
    TRY(event_reader_next(bus->replay, &event, handled));
    if (!*handled)
        return STATUS_OK;
    if (lcm_publish(bus->lcm, event.channel, event.data, (unsigned)event.size) != 0)
        return status_fail(STATUS_BUS, "cannot pass on a message of %s", event.channel);
    struct pollfd waiting = {.fd = lcm_get_fileno(bus->lcm), .events = POLLIN};
    if (poll(&waiting, 1, 0) > 0 && lcm_handle(bus->lcm) != 0)
        return status_fail(STATUS_BUS, "cannot handle a message of %s", event.channel);
    return STATUS_OK;
}

/* lcm_handle_timeout is not used: when a signal interrupts its wait it goes on to block without a limit. */
static enum status handle_within(struct bus *bus, double timeout_s, bool *handled)
{
    *handled = false;
    if (bus->log) /* nobody to wait for */
        return STATUS_OK;
    if (bus->replay)
        return log_handle(bus, handled);
    if (bus->receiver)
        return udp_receiver_handle(bus->receiver, timeout_s, handled);
    struct pollfd waiting = {.fd = lcm_get_fileno(bus->lcm), .events = POLLIN};
    const struct timespec timeout = {(time_t)timeout_s, (long)(1e9 * fmod(timeout_s, 1))};
    const int ready = ppoll(&waiting, 1, &timeout, NULL);
    if (ready < 0 && errno != EINTR)
        return status_fail(STATUS_BUS, "cannot wait for messages: %s", strerror(errno));
    if (ready <= 0)
        return STATUS_OK;
    *handled = lcm_handle(bus->lcm) == 0;
    if (!*handled)
        return status_fail(STATUS_BUS, "LCM cannot handle a message: %s", strerror(errno));
    return STATUS_OK;
}

enum status bus_handle(struct bus *bus, int timeout_ms, bool *handled)
{
    return handle_within(bus, 1e-3 * timeout_ms, handled);
}

/* Looks until `until_s`; `patient`: goes on for as long as short_wait_looks says. Others who wait for this core go
 * first: the recorder, or the one waited for. */
static enum status look(struct bus *bus, double until_s, bool patient, bool *handled)
{
    double now_s = clock_now_s();
    do {
        const double start_s = now_s;
        TRY(handle_within(bus, 0, handled));
        if (*handled)
            return STATUS_OK;
        const double looked_s = clock_now_s();
        sched_yield();
        now_s = clock_now_s();
        short_wait_note_look(&bus->wait, looked_s - start_s, now_s - looked_s, now_s);
    } while (now_s < until_s && (!patient || short_wait_looks(&bus->wait, now_s)));
    return STATUS_OK;
}

enum status bus_wait(struct bus *bus, double timeout_s, enum bus_patience patience, bool *handled)
{
    const double start_s = clock_now_s(), end_s = start_s + timeout_s;
    *handled = false;
    if (patience == BUS_SLEEP || bus->log || bus->replay)
        return handle_within(bus, timeout_s, handled);
    if (patience == BUS_BUSY)
        return look(bus, end_s, false, handled);
    if (short_wait_looks(&bus->wait, start_s))
        TRY(look(bus, fmin(end_s, start_s + SHORT_WAIT_S), true, handled));
    if (!*handled)
        TRY(handle_within(bus, fmax(0, end_s - clock_now_s()), handled));
    short_wait_note(&bus->wait, clock_now_s() - start_s);
    return STATUS_OK;
}
