#include "common/udp_receiver.h"

#include <arpa/inet.h>
#include <errno.h>
#include <linux/filter.h>
#include <math.h>
#include <netinet/in.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

enum { WAIT_SLACK_NS = 1000 };
enum { CHANNELS_MAX = 16, NAME_MAX_LENGTH = 63, DATAGRAM_MAX = 65536, RECEIVE_BUFFER = 4194304 };

/* Offsets: the filter counts from the UDP header. */
enum {
    UDP_HEADER = 8,
    MAGIC_SIZE = 4,
    MESSAGE_HEADER = 8,
    FILTER_MAX = CHANNELS_MAX * (2 * (NAME_MAX_LENGTH + 1) + 1) + 1
};
static const char MAGIC[MAGIC_SIZE] = {'L', 'C', '0', '2'};

/* Longer waits are left to the socket, which saves a call but counts in ticks of the kernel (4 ms and more). */
static const double FINE_WAIT_S = 0.05;

struct channel {
    char name[NAME_MAX_LENGTH + 1]; /* "": free */
    lcm_msg_handler_t handler;
    void *user;
};

struct udp_receiver {
    int socket;
    double timeout_s; /* the socket's */
    struct channel channel[CHANNELS_MAX];
    unsigned char datagram[DATAGRAM_MAX];
};

/* false: not a numeric address and a port. */
static bool group_of(const char *url, struct sockaddr_in *group)
{
    char address[16];
    int port = 0;
    *group = (struct sockaddr_in){.sin_family = AF_INET};
    if (sscanf(url, "udpm://%15[0-9.]:%d", address, &port) != 2 || port < 1 || port > 65535)
        return false;
    group->sin_port = htons((uint16_t)port);
    return inet_pton(AF_INET, address, &group->sin_addr) == 1;
}

/* Bound to the group itself: another group on the same port is not received. */
static bool socket_join(struct udp_receiver *receiver, const struct sockaddr_in *group)
{
    const int on = 1, size = RECEIVE_BUFFER;
    struct ip_mreq membership = {.imr_multiaddr = group->sin_addr};
    receiver->socket = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    return receiver->socket >= 0 && setsockopt(receiver->socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) == 0 &&
           setsockopt(receiver->socket, SOL_SOCKET, SO_REUSEPORT, &on, sizeof on) == 0 &&
           setsockopt(receiver->socket, SOL_SOCKET, SO_RCVBUF, &size, sizeof size) == 0 &&
           bind(receiver->socket, (const struct sockaddr *)group, sizeof *group) == 0 &&
           setsockopt(receiver->socket, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) == 0;
}

/* Classic BPF: name and NUL of each channel, byte by byte; whatever is none of them is dropped. */
static bool socket_filter(const struct udp_receiver *receiver)
{
    struct sock_filter code[FILTER_MAX];
    unsigned short n = 0;
    for (int c = 0; c < CHANNELS_MAX; c++) {
        const char *name = receiver->channel[c].name;
        const unsigned length = (unsigned)strlen(name) + 1;
        if (length == 1)
            continue;
        for (unsigned k = 0; k < length; k++) {
            /* to the next channel: over the rest of this one's pairs and its return */
            const unsigned char next = (unsigned char)(2 * (length - 1 - k) + 1);
            code[n++] = (struct sock_filter)BPF_STMT(BPF_LD | BPF_B | BPF_ABS, UDP_HEADER + MESSAGE_HEADER + k);
            code[n++] = (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, (unsigned char)name[k], 0, next);
        }
        code[n++] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, UINT32_MAX);
    }
    code[n++] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, 0);
    const struct sock_fprog program = {.len = n, .filter = code};
    return setsockopt(receiver->socket, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program) == 0;
}

enum status udp_receiver_open(struct udp_receiver **result, const char *url)
{
    struct sockaddr_in group;
    *result = NULL;
    if (!group_of(url, &group))
        return STATUS_OK;
    struct udp_receiver *receiver = calloc(1, sizeof *receiver);
    if (!receiver)
        return status_fail(STATUS_NO_MEMORY, "no memory for a receiver");
    if (!socket_join(receiver, &group) || !socket_filter(receiver)) {
        enum status status =
            status_fail(STATUS_BUS, "cannot receive from the LCM bus \"%s\": %s", url, strerror(errno));
        udp_receiver_close(receiver);
        return status;
    }
    (void)prctl(PR_SET_TIMERSLACK, WAIT_SLACK_NS, 0, 0, 0); /* else this thread's waits take 50 us more */
    *result = receiver;
    return STATUS_OK;
}

void udp_receiver_close(struct udp_receiver *receiver)
{
    if (receiver && receiver->socket >= 0)
        close(receiver->socket);
    free(receiver);
}

enum status udp_receiver_subscribe(struct udp_receiver *receiver, const char *name, lcm_msg_handler_t handler,
                                   void *user, void **handle)
{
    *handle = NULL;
    for (int c = 0; c < CHANNELS_MAX; c++) {
        struct channel *channel = &receiver->channel[c];
        if (channel->name[0])
            continue;
        *channel = (struct channel){.handler = handler, .user = user};
        snprintf(channel->name, sizeof channel->name, "%s", name);
        *handle = channel;
        return socket_filter(receiver) ? STATUS_OK
                                       : status_fail(STATUS_BUS, "cannot subscribe to %s: %s", name, strerror(errno));
    }
    return status_fail(STATUS_LIMIT, "no more than %d channels are received directly", CHANNELS_MAX);
}

void udp_receiver_unsubscribe(struct udp_receiver *receiver, void *handle)
{
    struct channel *channel = handle;
    if (!channel)
        return;
    channel->name[0] = '\0';
    (void)socket_filter(receiver); /* without it, what still comes has no handler */
}

static void socket_limit_wait(struct udp_receiver *receiver, double timeout_s)
{
    const struct timeval timeout = {.tv_sec = (time_t)timeout_s, .tv_usec = (suseconds_t)(1e6 * fmod(timeout_s, 1))};
    if (timeout_s == receiver->timeout_s)
        return;
    if (setsockopt(receiver->socket, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof timeout) == 0)
        receiver->timeout_s = timeout_s;
}

static bool comes_within(const struct udp_receiver *receiver, double timeout_s)
{
    const struct timespec timeout = {.tv_nsec = (long)(1e9 * timeout_s)};
    struct pollfd waiting = {.fd = receiver->socket, .events = POLLIN};
    const int ready = ppoll(&waiting, 1, &timeout, NULL);
    if (ready == 0)
        errno = EAGAIN;
    return ready > 0;
}

static bool receive(struct udp_receiver *receiver, double timeout_s, size_t *size)
{
    const bool long_wait = timeout_s >= FINE_WAIT_S;
    *size = 0;
    if (long_wait)
        socket_limit_wait(receiver, timeout_s);
    else if (timeout_s > 0 && !comes_within(receiver, timeout_s))
        return false;
    ssize_t got = recv(receiver->socket, receiver->datagram, sizeof receiver->datagram, long_wait ? 0 : MSG_DONTWAIT);
    *size = got > 0 ? (size_t)got : 0;
    return got >= 0;
}

/* The handlers of a datagram's channel; true if there was one. */
static bool dispatch(struct udp_receiver *receiver, size_t size)
{
    const char *name = (const char *)receiver->datagram + MESSAGE_HEADER;
    bool handled = false;
    if (size <= MESSAGE_HEADER || memcmp(receiver->datagram, MAGIC, MAGIC_SIZE) != 0)
        return false;
    const size_t length = strnlen(name, size - MESSAGE_HEADER) + 1;
    if (length > size - MESSAGE_HEADER || length > NAME_MAX_LENGTH + 1 || length == 1)
        return false;
    lcm_recv_buf_t buffer = {.data = receiver->datagram + MESSAGE_HEADER + length,
                             .data_size = (uint32_t)(size - MESSAGE_HEADER - length)};
    for (int c = 0; c < CHANNELS_MAX; c++)
        if (strcmp(receiver->channel[c].name, name) == 0) {
            receiver->channel[c].handler(&buffer, name, receiver->channel[c].user);
            handled = true;
        }
    return handled;
}

enum status udp_receiver_handle(struct udp_receiver *receiver, double timeout_s, bool *handled)
{
    size_t size;
    *handled = false;
    if (receive(receiver, timeout_s, &size))
        *handled = dispatch(receiver, size);
    else if (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR)
        return status_fail(STATUS_BUS, "cannot receive from the bus: %s", strerror(errno));
    return STATUS_OK;
}
