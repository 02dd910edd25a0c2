#include "sim/base/thread_team.h"

#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <time.h>

/* How long to spin before going to sleep: longer than the parts of a step differ and than what is between two jobs of a
 * step, shorter than it would matter to others. Waking up takes about as long. */
static const int64_t SPIN_NS = 50000;
enum { LINE = 128, SPINS_PER_LOOK = 16 };

/* What is left of a member's own pieces: number of the job, end and next piece in one word, so that a piece of a job
 * that is over cannot be taken. */
enum { PIECE_BITS = 20, JOB_BITS = 24 };
_Static_assert((1 << PIECE_BITS) > TEAM_PIECES_MAX && 2 * PIECE_BITS + JOB_BITS == 64, "ticket");

static uint64_t ticket_of(uint32_t job, int next, int end)
{
    return (uint64_t)job << 2 * PIECE_BITS | (uint64_t)end << PIECE_BITS | (uint64_t)next;
}

static uint32_t ticket_job(uint64_t ticket)
{
    return (uint32_t)(ticket >> 2 * PIECE_BITS);
}

static bool ticket_is_empty(uint64_t ticket)
{
    return (ticket & TEAM_PIECES_MAX) >= (ticket >> PIECE_BITS & TEAM_PIECES_MAX);
}

struct member {
    _Alignas(LINE) _Atomic uint64_t ticket;
    _Alignas(LINE) atomic_bool sleeps;
    pthread_mutex_t mutex;
    pthread_cond_t wake;
    pthread_t thread;
    struct thread_team *team;
    int index;
};

struct thread_team {
    int threads;   /* with the caller */
    int use;       /* of them */
    uint32_t last; /* job */
    _Alignas(LINE) _Atomic uint32_t job;
    atomic_bool over; /* threads shall end */
    /* Of the job: written before its tickets, and of use to who has taken a piece of it only. */
    _Atomic(thread_team_task *) task;
    _Atomic(void *) context;
    atomic_int members, pieces;
    _Alignas(LINE) atomic_int done; /* pieces */
    struct member member[];         /* 0: the caller */
};

int thread_team_cpus(void)
{
    cpu_set_t set;
    CPU_ZERO(&set);
    const int n = sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
    return n < 1 ? 1 : n > TEAM_MAX ? TEAM_MAX : n;
}

static int64_t now_ns(void)
{
    struct timespec t;
    (void)clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

static void pause_cpu(void)
{
#if defined(__x86_64__)
    for (int k = 0; k < SPINS_PER_LOOK; k++)
        __builtin_ia32_pause();
#endif
}

/* Takes the next piece of member m, if the job is still `job`; below 0: there is none. */
static int take(struct thread_team *team, int m, uint32_t job)
{
    uint64_t ticket = atomic_load_explicit(&team->member[m].ticket, memory_order_acquire);
    while (ticket_job(ticket) == job && !ticket_is_empty(ticket))
        if (atomic_compare_exchange_weak_explicit(&team->member[m].ticket, &ticket, ticket + 1, memory_order_acq_rel,
                                                  memory_order_acquire))
            return (int)(ticket & TEAM_PIECES_MAX);
    return -1;
}

static void wake_up(struct member *member)
{
    if (!atomic_load(&member->sleeps))
        return;
    pthread_mutex_lock(&member->mutex);
    pthread_cond_signal(&member->wake);
    pthread_mutex_unlock(&member->mutex);
}

/* Pieces of the job, as long as there are any: one's own first, then those of who comes next. */
static void work(struct thread_team *team, int self, uint32_t job)
{
    const int members = atomic_load_explicit(&team->members, memory_order_relaxed);
    for (int k = 0; k < members; k++)
        for (int piece; (piece = take(team, (self + k) % members, job)) >= 0;) {
            thread_team_task *task = atomic_load_explicit(&team->task, memory_order_relaxed);
            task(atomic_load_explicit(&team->context, memory_order_relaxed), piece);
            const int pieces = atomic_load_explicit(&team->pieces, memory_order_relaxed);
            if (atomic_fetch_add(&team->done, 1) + 1 == pieces && self != 0)
                wake_up(&team->member[0]);
        }
}

/* Whether what is waited for has come: a job other than `job` that this member has a part in, or, for the caller, the
 * end of `job`. */
static bool has_come(struct thread_team *team, int self, uint32_t job)
{
    if (self == 0)
        return atomic_load(&team->done) == atomic_load_explicit(&team->pieces, memory_order_relaxed);
    return atomic_load(&team->over) ||
           (atomic_load(&team->job) != job && self < atomic_load_explicit(&team->members, memory_order_relaxed));
}

static void wait_for(struct thread_team *team, int self, uint32_t job)
{
    struct member *member = &team->member[self];
    for (int64_t start = now_ns(); !has_come(team, self, job) && now_ns() - start < SPIN_NS;)
        pause_cpu();
    if (has_come(team, self, job))
        return;
    pthread_mutex_lock(&member->mutex);
    atomic_store(&member->sleeps, true);
    while (!has_come(team, self, job))
        pthread_cond_wait(&member->wake, &member->mutex);
    atomic_store(&member->sleeps, false);
    pthread_mutex_unlock(&member->mutex);
}

static void *be_member(void *argument)
{
    const struct member *member = argument;
    struct thread_team *team = member->team;
    for (uint32_t job = 0;;) {
        wait_for(team, member->index, job);
        if (atomic_load(&team->over))
            return NULL;
        job = atomic_load(&team->job);
        work(team, member->index, job);
    }
}

static void end_threads(struct thread_team *team)
{
    atomic_store(&team->over, true);
    for (int m = 1; m < team->threads; m++) {
        wake_up(&team->member[m]);
        (void)pthread_join(team->member[m].thread, NULL);
    }
}

/* Signals are for the thread that waits for messages. Fewer threads than asked for are no error. */
static void start_threads(struct thread_team *team, int threads)
{
    sigset_t all, before;
    (void)sigfillset(&all);
    (void)pthread_sigmask(SIG_SETMASK, &all, &before);
    for (team->threads = 1; team->threads < threads; team->threads++) {
        struct member *member = &team->member[team->threads];
        if (pthread_create(&member->thread, NULL, be_member, member) != 0)
            break;
    }
    (void)pthread_sigmask(SIG_SETMASK, &before, NULL);
}

enum status thread_team_create(struct thread_team **to, int threads)
{
    const size_t size = sizeof(struct thread_team) + (size_t)threads * sizeof(struct member);
    struct thread_team *team = aligned_alloc(LINE, (size + LINE - 1) / LINE * LINE);
    *to = team;
    if (!team)
        return status_fail(STATUS_NO_MEMORY, "no memory for threads");
    *team = (struct thread_team){.threads = 1, .use = threads};
    for (int m = 0; m < threads; m++) {
        struct member *member = &team->member[m];
        *member = (struct member){.team = team, .index = m};
        (void)pthread_mutex_init(&member->mutex, NULL);
        (void)pthread_cond_init(&member->wake, NULL);
    }
    start_threads(team, threads);
    for (int m = team->threads; m < threads; m++) {
        (void)pthread_mutex_destroy(&team->member[m].mutex);
        (void)pthread_cond_destroy(&team->member[m].wake);
    }
    team->use = team->threads;
    return STATUS_OK;
}

void thread_team_free(struct thread_team *team)
{
    if (!team)
        return;
    end_threads(team);
    for (int m = 0; m < team->threads; m++) {
        (void)pthread_mutex_destroy(&team->member[m].mutex);
        (void)pthread_cond_destroy(&team->member[m].wake);
    }
    free(team);
}

void thread_team_use(struct thread_team *team, int threads)
{
    team->use = threads < 1 ? 1 : threads > team->threads ? team->threads : threads;
}

int thread_team_in_use(const struct thread_team *team)
{
    return team ? team->use : 1;
}

/* The tickets come last: with them the job begins for those who are still awake from the one before. */
static uint32_t begin(struct thread_team *team, int members, int pieces, thread_team_task *task, void *context)
{
    const uint32_t job = team->last = (team->last + 1) % (1u << JOB_BITS);
    atomic_store_explicit(&team->task, task, memory_order_relaxed);
    atomic_store_explicit(&team->context, context, memory_order_relaxed);
    atomic_store_explicit(&team->members, members, memory_order_relaxed);
    atomic_store_explicit(&team->pieces, pieces, memory_order_relaxed);
    atomic_store(&team->done, 0);
    for (int m = 0; m < members; m++) {
        const int first = (int)((int64_t)pieces * m / members), end = (int)((int64_t)pieces * (m + 1) / members);
        atomic_store_explicit(&team->member[m].ticket, ticket_of(job, first, end), memory_order_release);
    }
    atomic_store(&team->job, job);
    for (int m = 1; m < members; m++)
        wake_up(&team->member[m]);
    return job;
}

void thread_team_run(struct thread_team *team, int pieces, thread_team_task *task, void *context)
{
    const int use = thread_team_in_use(team), members = use < pieces ? use : pieces;
    if (members <= 1) {
        for (int k = 0; k < pieces; k++)
            task(context, k);
        return;
    }
    const uint32_t job = begin(team, members, pieces, task, context);
    work(team, 0, job);
    wait_for(team, 0, job);
}

struct ranges {
    team_range_task *task;
    void *context;
    int n, grain;
};

static void run_range(void *context, int k)
{
    const struct ranges *ranges = context;
    const int first = k * ranges->grain, rest = ranges->n - first;
    ranges->task(ranges->context, first, first + (rest < ranges->grain ? rest : ranges->grain));
}

void team_run_ranges(struct thread_team *team, int n, int grain, team_range_task *task, void *context)
{
    struct ranges ranges = {task, context, n, grain};
    if (thread_team_in_use(team) > 1)
        thread_team_run(team, (n + grain - 1) / grain, run_range, &ranges);
    else if (n > 0)
        task(context, 0, n);
}
