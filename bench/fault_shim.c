/* Faults at stated points, for tests and ./shakedown bench faults: preloaded (LD_PRELOAD) into the processes of a run.
 *
 * FAULTS_AT=NAME:CALL:N:SIGNAL[,...]: process NAME gets SIGNAL (KILL, STOP, TERM, INT, HUP) right after its N-th call
 * of rename, fsync, write or send (a datagram); `log`: an fsync of an event log.
 *
 * FAULTS_ONCE=PATH: each of these strikes once in all, and leaves the file PATH.K (K = 0, 1, ...).
 *
 * FAULTS_NET=loss=P,deaf=P,duplicate=P,reorder=P,delay_s=T[,seed=N]: datagrams of all processes: probabilities, and a
 * delay. What is lost reaches nobody, to what it is deaf a process misses alone; `reorder` delays by 1 ms more, so that
 * later ones overtake. */
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

enum call { CALL_RENAME, CALL_FSYNC, CALL_WRITE, CALL_SEND, CALL_LOG, CALLS };
enum { STRIKES_MAX = 64, WORD_MAX = 32 };
static const double OVERTAKEN_S = 1e-3;

struct strike {
    enum call call;
    long n;
    int signal_number;
    int index; /* in FAULTS_AT: names its file */
};

struct datagram {
    struct datagram *next;
    double due_s;
    int socket;
    struct sockaddr_storage to;
    socklen_t to_size;
    size_t size;
    unsigned char data[];
};

static struct strike strikes[STRIKES_MAX];
static int n_strikes;
static long calls[CALLS];
static double loss, deaf, duplicate, reorder, delay_s;
static uint64_t random_state;
static double clock_at_s, clock_step_s, begun_s;

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t more;
static struct datagram *waiting; /* by due_s */
static bool has_sender;

static int (*real_rename)(const char *, const char *);
static int (*real_fsync)(int);
static ssize_t (*real_write)(int, const void *, size_t);
static ssize_t (*real_sendmsg)(int, const struct msghdr *, int);
static ssize_t (*real_recvmsg)(int, struct msghdr *, int);
static ssize_t (*real_recv)(int, void *, size_t, int);
static int (*real_clock_gettime)(clockid_t, struct timespec *);

/* --- What is stood in for --- */

static void *original(const char *name)
{
    void *function = dlsym(RTLD_NEXT, name);
    if (!function)
        abort();
    return function;
}

/* Other libraries call these before ours begins. */
static void find_originals(void)
{
    if (real_sendmsg)
        return;
    *(void **)&real_rename = original("rename");
    *(void **)&real_fsync = original("fsync");
    *(void **)&real_write = original("write");
    *(void **)&real_clock_gettime = original("clock_gettime");
    *(void **)&real_recvmsg = original("recvmsg");
    *(void **)&real_recv = original("recv");
    *(void **)&real_sendmsg = original("sendmsg");
}

/* --- Strikes --- */

static int signal_of(const char *name)
{
    static const struct {
        const char *name;
        int number;
    } known[] = {{"KILL", SIGKILL}, {"STOP", SIGSTOP}, {"TERM", SIGTERM}, {"INT", SIGINT}, {"HUP", SIGHUP}};
    for (size_t k = 0; k < sizeof known / sizeof *known; k++)
        if (strcmp(known[k].name, name) == 0)
            return known[k].number;
    return 0;
}

static enum call call_of(const char *name)
{
    static const char *const names[CALLS] = {"rename", "fsync", "write", "send", "log"};
    enum call call = 0;
    while (call < CALLS && strcmp(names[call], name) != 0)
        call++;
    return call;
}

static void refuse(const char *variable, const char *text)
{
    fprintf(stderr, "faults: %s=%s is not understood\n", variable, text);
    _exit(2);
}

static void strike_read(const char *text, int index)
{
    char name[WORD_MAX], call[WORD_MAX], sign[WORD_MAX];
    long n;
    if (sscanf(text, "%31[^:]:%31[^:]:%ld:%31s", name, call, &n, sign) != 4 || call_of(call) == CALLS ||
        signal_of(sign) == 0 || n_strikes == STRIKES_MAX)
        refuse("FAULTS_AT", text);
    if (strcmp(name, program_invocation_short_name) == 0)
        strikes[n_strikes++] =
            (struct strike){.call = call_of(call), .n = n, .signal_number = signal_of(sign), .index = index};
}

static bool is_first(const struct strike *strike)
{
    char path[4096];
    const char *once = getenv("FAULTS_ONCE");
    if (!once)
        return true;
    snprintf(path, sizeof path, "%s.%d", once, strike->index);
    int file = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file < 0)
        return false;
    close(file);
    return true;
}

static void count(enum call call)
{
    const int error = errno;
    const long n = __atomic_add_fetch(&calls[call], 1, __ATOMIC_RELAXED);
    for (int k = 0; k < n_strikes; k++)
        if (strikes[k].call == call && strikes[k].n == n && is_first(&strikes[k]))
            kill(getpid(), strikes[k].signal_number);
    errno = error;
}

int rename(const char *from, const char *to)
{
    find_originals();
    int result = real_rename(from, to);
    count(CALL_RENAME);
    return result;
}

static bool is_event_log(int file)
{
    char link[64], path[4096];
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    const ssize_t length = readlink(link, path, sizeof path);
    return length > 4 && memcmp(path + length - 4, ".lcm", 4) == 0;
}

int fsync(int file)
{
    find_originals();
    int result = real_fsync(file);
    count(CALL_FSYNC);
    if (is_event_log(file))
        count(CALL_LOG);
    return result;
}

ssize_t write(int file, const void *data, size_t size)
{
    find_originals();
    ssize_t result = real_write(file, data, size);
    count(CALL_WRITE);
    return result;
}

static double now_s(void)
{
    struct timespec now;
    real_clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* --- The wall clock --- */

int clock_gettime(clockid_t clock, struct timespec *now)
{
    find_originals();
    int result = real_clock_gettime(clock, now);
    if (result == 0 && clock_step_s != 0 && (clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE) &&
        now_s() - begun_s > clock_at_s)
        now->tv_sec += (time_t)clock_step_s;
    return result;
}

int gettimeofday(struct timeval *restrict now, void *restrict zone)
{
    struct timespec fine;
    (void)zone;
    int result = clock_gettime(CLOCK_REALTIME, &fine);
    *now = (struct timeval){fine.tv_sec, fine.tv_nsec / 1000};
    return result;
}

time_t time(time_t *result)
{
    struct timespec fine;
    clock_gettime(CLOCK_REALTIME, &fine);
    if (result)
        *result = fine.tv_sec;
    return fine.tv_sec;
}

/* --- The network --- */

/* splitmix64: whether something of this probability happens */
static bool happens(double probability)
{
    uint64_t z = random_state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return (double)((z ^ z >> 31) >> 11) * 0x1p-53 < probability;
}

static void net_read(const char *text)
{
    char words[256], *rest = words;
    snprintf(words, sizeof words, "%s", text);
    for (char *word = strtok_r(rest, ",", &rest); word; word = strtok_r(NULL, ",", &rest)) {
        unsigned long long seed = 0;
        if (sscanf(word, "seed=%llu", &seed) == 1)
            random_state = seed;
        else if (sscanf(word, "loss=%lf", &loss) != 1 && sscanf(word, "deaf=%lf", &deaf) != 1 &&
                 sscanf(word, "duplicate=%lf", &duplicate) != 1 && sscanf(word, "reorder=%lf", &reorder) != 1 &&
                 sscanf(word, "delay_s=%lf", &delay_s) != 1)
            refuse("FAULTS_NET", text);
    }
    for (const char *sign = program_invocation_short_name; *sign; sign++)
        random_state = random_state * 31 + (unsigned char)*sign;
}

static void datagram_send(struct datagram *datagram)
{
    struct iovec bytes = {datagram->data, datagram->size};
    struct msghdr message = {
        .msg_name = &datagram->to, .msg_namelen = datagram->to_size, .msg_iov = &bytes, .msg_iovlen = 1};
    (void)real_sendmsg(datagram->socket, &message, 0); /* what fails here is one more loss */
    free(datagram);
}

static void *sender(void *unused)
{
    pthread_mutex_lock(&lock);
    for (;;) {
        if (!waiting) {
            pthread_cond_wait(&more, &lock);
        } else if (waiting->due_s > now_s()) {
            const struct timespec due = {(time_t)waiting->due_s,
                                         (long)(1e9 * (waiting->due_s - (double)(time_t)waiting->due_s))};
            pthread_cond_timedwait(&more, &lock, &due);
        } else {
            struct datagram *first = waiting;
            waiting = first->next;
            datagram_send(first);
        }
    }
    return unused;
}

static size_t bytes_of(const struct msghdr *message)
{
    size_t size = 0;
    for (size_t k = 0; k < message->msg_iovlen; k++)
        size += message->msg_iov[k].iov_len;
    return size;
}

/* With `lock` held. */
static void send_later(int file, const struct msghdr *message, double wait_s)
{
    struct datagram *datagram = malloc(sizeof *datagram + bytes_of(message)), **link = &waiting;
    pthread_t thread;
    if (!datagram || message->msg_namelen > sizeof datagram->to)
        abort();
    *datagram = (struct datagram){.due_s = now_s() + wait_s, .socket = file, .to_size = message->msg_namelen};
    memcpy(&datagram->to, message->msg_name, message->msg_namelen);
    for (size_t k = 0; k < message->msg_iovlen; k++) {
        memcpy(datagram->data + datagram->size, message->msg_iov[k].iov_base, message->msg_iov[k].iov_len);
        datagram->size += message->msg_iov[k].iov_len;
    }
    while (*link && (*link)->due_s <= datagram->due_s)
        link = &(*link)->next;
    datagram->next = *link;
    *link = datagram;
    if (!has_sender)
        has_sender = pthread_create(&thread, NULL, sender, NULL) == 0;
    pthread_cond_signal(&more);
}

static void send_copy(int file, const struct msghdr *message, int flags)
{
    const double wait_s = delay_s + (happens(reorder) ? OVERTAKEN_S : 0);
    if (wait_s > 0)
        send_later(file, message, wait_s);
    else
        (void)real_sendmsg(file, message, flags);
}

ssize_t sendmsg(int file, const struct msghdr *message, int flags)
{
    const struct sockaddr *to = message->msg_name;
    find_originals();
    ssize_t result = (ssize_t)bytes_of(message);
    if (loss + duplicate + reorder + delay_s <= 0 || !to || to->sa_family != AF_INET) {
        result = real_sendmsg(file, message, flags);
    } else {
        pthread_mutex_lock(&lock);
        const bool lost = happens(loss), twice = happens(duplicate);
        if (!lost)
            send_copy(file, message, flags);
        if (!lost && twice)
            send_copy(file, message, flags);
        pthread_mutex_unlock(&lock);
    }
    count(CALL_SEND);
    return result;
}

/* A message of LCM that is not heard is one that nobody understands: who waits for it is not left waiting. */
static void maybe_muffle(void *data)
{
    if (deaf <= 0 || memcmp(data, "LC0", 3) != 0)
        return;
    pthread_mutex_lock(&lock);
    if (happens(deaf))
        memcpy(data, "lost", 4);
    pthread_mutex_unlock(&lock);
}

ssize_t recv(int file, void *data, size_t size, int flags)
{
    find_originals();
    const ssize_t got = real_recv(file, data, size, flags);
    if (got >= 4 && size >= 4)
        maybe_muffle(data);
    return got;
}

ssize_t recvmsg(int file, struct msghdr *message, int flags)
{
    find_originals();
    const ssize_t got = real_recvmsg(file, message, flags);
    if (got >= 4 && message->msg_iovlen > 0 && message->msg_iov[0].iov_len >= 4)
        maybe_muffle(message->msg_iov[0].iov_base);
    return got;
}

/* --- Begin and end --- */

__attribute__((constructor)) static void begin(void)
{
    find_originals();
    pthread_condattr_t monotonic;
    if (pthread_condattr_init(&monotonic) != 0 || pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC) != 0 ||
        pthread_cond_init(&more, &monotonic) != 0)
        abort();
    begun_s = now_s();
    const char *at = getenv("FAULTS_AT"), *net = getenv("FAULTS_NET"), *clock = getenv("FAULTS_CLOCK");
    if (clock && *clock && sscanf(clock, "%lf:%lf", &clock_at_s, &clock_step_s) != 2)
        refuse("FAULTS_CLOCK", clock);
    for (int k = 0; at && *at; k++) {
        char text[4 * WORD_MAX];
        const size_t length = strcspn(at, ",");
        snprintf(text, sizeof text, "%.*s", (int)length, at);
        strike_read(text, k);
        at += length + (at[length] == ',');
    }
    if (net && *net)
        net_read(net);
}

/* What is on its way arrives although its sender has ended. */
__attribute__((destructor)) static void end(void)
{
    pthread_mutex_lock(&lock);
    while (waiting) {
        struct datagram *first = waiting;
        waiting = first->next;
        datagram_send(first);
    }
    pthread_mutex_unlock(&lock);
}
