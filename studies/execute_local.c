/* Runs as processes on this machine. */
#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>

#include "common/signals.h"
#include "studies/execute.h"
#include "studies/files.h"
#include "studies/process.h"
#include "studies/progress.h"
#include "studies/task.h"

enum { POLL_MS = 100, SHOW_EVERY = 10 };

struct slot {
    pid_t pid; /* 0: free */
    int run;
};

struct pool {
    const struct execution *execution;
    struct outcome *outcome;
    struct slot *slot; /* [jobs] */
    struct progress progress;
    int *queue; /* [n_runs EXECUTE_TRIES], ring of runs to be started */
    int head, tail;
};

void outcomes_free(struct outcome *outcome, int n)
{
    for (int k = 0; outcome && k < n; k++)
        free(outcome[k].reason);
    free(outcome);
}

enum status outcome_judge(const struct execution *execution, int k, struct outcome *outcome)
{
    struct task task;
    TRY(task_open(&task, execution->out, execution->plan->run[k].name));
    /* of these settings: what others have left does not count */
    outcome->done = strcmp(task.hash, execution->plan->run[k].hash) == 0 && task_is_done(&task);
    free(outcome->reason);
    outcome->reason = NULL;
    if (outcome->done)
        return STATUS_OK;
    if (outcome->tries > 0)
        return task_failure(&task, &outcome->reason);
    outcome->reason = strdup("has not run");
    return outcome->reason ? STATUS_OK : status_fail(STATUS_NO_MEMORY, "out of memory");
}

/* What is there counts; the rest is queued. */
static enum status pool_fill(struct pool *pool)
{
    const struct plan *plan = pool->execution->plan;
    double cost = 0, before = 0;
    int done = 0;
    for (int k = 0; k < plan->n_runs; k++) {
        struct outcome *outcome = &pool->outcome[k];
        TRY(outcome_judge(pool->execution, k, outcome));
        cost += plan->run[k].cost;
        before += outcome->done ? plan->run[k].cost : 0;
        done += outcome->done;
        if (!outcome->done)
            pool->queue[pool->tail++] = k;
    }
    progress_start(&pool->progress, plan->n_runs, cost, done, before);
    return STATUS_OK;
}

static enum status slot_start(struct pool *pool, struct slot *slot, int run)
{
    const struct execution *execution = pool->execution;
    char program[4096], log[4096];
    TRY(files_join(program, sizeof program, execution->bin, "studies/study"));
    TRY(files_join(log, sizeof log, execution->out, "log"));
    const char *const argv[] = {
        program, "--task", execution->plan->run[run].name, "--out", execution->out, "--bin", execution->bin, NULL};
    TRY(process_start(argv, NULL, log, true, &slot->pid));
    slot->run = run;
    pool->outcome[run].tries++;
    pool->progress.running++;
    return STATUS_OK;
}

/* The run of a slot has ended: done, or again, or given up. */
static enum status slot_end(struct pool *pool, struct slot *slot)
{
    struct outcome *outcome = &pool->outcome[slot->run];
    const struct plan_run *run = &pool->execution->plan->run[slot->run];
    slot->pid = 0;
    pool->progress.running--;
    TRY(outcome_judge(pool->execution, slot->run, outcome));
    if (outcome->done) {
        pool->progress.done++;
        pool->progress.cost_done += run->cost;
    } else if (stop_requested()) {
        return STATUS_OK;
    } else if (outcome->tries < EXECUTE_TRIES) {
        progress_say(&pool->progress, "%s failed, once more: %s", run->name, outcome->reason);
        pool->queue[pool->tail++] = slot->run;
    } else {
        pool->progress.failed++;
        pool->progress.cost_done += run->cost;
        progress_say(&pool->progress, "%s failed again: %s", run->name, outcome->reason);
    }
    progress_show(&pool->progress);
    return STATUS_OK;
}

static enum status pool_collect(struct pool *pool)
{
    for (int k = 0; k < pool->execution->jobs; k++) {
        bool ended = false;
        int code;
        if (pool->slot[k].pid == 0)
            continue;
        TRY(process_poll(pool->slot[k].pid, &ended, &code));
        if (ended)
            TRY(slot_end(pool, &pool->slot[k]));
    }
    return STATUS_OK;
}

static enum status pool_start(struct pool *pool)
{
    for (int k = 0; k < pool->execution->jobs && pool->head < pool->tail && !stop_requested(); k++)
        if (pool->slot[k].pid == 0)
            TRY(slot_start(pool, &pool->slot[k], pool->queue[pool->head++]));
    return STATUS_OK;
}

static void pool_signal(const struct pool *pool, int signal)
{
    for (int k = 0; k < pool->execution->jobs; k++)
        if (pool->slot[k].pid != 0)
            (void)kill(-pool->slot[k].pid, signal);
}

static enum status pool_run(struct pool *pool)
{
    int told = 0;
    for (int turn = 0;; turn++) {
        TRY(pool_collect(pool));
        TRY(pool_start(pool));
        if (pool->progress.running == 0)
            break;
        for (; told < stop_request_count(); told++)
            pool_signal(pool, SIGTERM);
        if (pool->progress.terminal && turn % SHOW_EVERY == 0)
            progress_show(&pool->progress);
        (void)poll(NULL, 0, POLL_MS); /* a signal ends it early */
    }
    if (pool->progress.terminal)
        progress_say(&pool->progress, "%d of %d done", pool->progress.done, pool->progress.n);
    return stop_requested() ? status_fail(STATUS_INTERRUPTED, "interrupted; the same command goes on") : STATUS_OK;
}

enum status execute_local(const struct execution *execution, struct outcome *outcome)
{
    struct pool pool = {.execution = execution, .outcome = outcome};
    pool.slot = calloc((size_t)execution->jobs, sizeof *pool.slot);
    pool.queue = calloc((size_t)execution->plan->n_runs * EXECUTE_TRIES + 1, sizeof *pool.queue);
    enum status status = STATUS_OK;
    if (!pool.slot || !pool.queue)
        status = status_fail(STATUS_NO_MEMORY, "out of memory");
    if (status == STATUS_OK)
        status = pool_fill(&pool);
    if (status == STATUS_OK)
        status = pool_run(&pool);
    if (status != STATUS_OK && status != STATUS_INTERRUPTED && pool.slot)
        pool_signal(&pool, SIGKILL);
    free(pool.slot);
    free(pool.queue);
    return status;
}
