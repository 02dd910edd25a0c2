/* Threads that share out the pieces of a job: each begins with pieces of its own, the same ones in every job of so many
 * pieces, so that they stay in the caches of its core, and helps others when it has done them. A job is over when all
 * pieces are done; a thread that was not there in time is not waited for. Who waits spins for a moment and then sleeps.
 */
#ifndef SHAKEDOWN_SIM_BASE_THREAD_TEAM_H
#define SHAKEDOWN_SIM_BASE_THREAD_TEAM_H

#include "common/status.h"

enum { TEAM_MAX = 256, TEAM_PIECES_MAX = (1 << 20) - 1 };

struct thread_team;
typedef void thread_team_task(void *context, int piece);

/* CPUs that this process may use. */
int thread_team_cpus(void);

/* A team of 1 ... TEAM_MAX threads, the caller one of them, all of them at work. Errors: STATUS_NO_MEMORY (no thread
 * could be started). */
enum status thread_team_create(struct thread_team **team, int threads) MUST_USE;
void thread_team_free(struct thread_team *team); /* NULL: none */

/* How many of the threads are at work from the next job on, 1 ... as many as there are; and how many are. */
void thread_team_use(struct thread_team *team, int threads);
int thread_team_in_use(const struct thread_team *team);

/* task(context, k) for k = 0 ... pieces - 1, at most TEAM_PIECES_MAX, in no order, by all threads at work; returns when
 * all are done. Without a team (NULL), or with a single thread, by the caller in rising order. Not to be called by a
 * task. */
void thread_team_run(struct thread_team *team, int pieces, thread_team_task *task, void *context);

/* The same for ranges first ... end - 1 of 0 ... n - 1, each of `grain` members but the last. */
typedef void team_range_task(void *context, int first, int end);
void team_run_ranges(struct thread_team *team, int n, int grain, team_range_task *task, void *context);

#endif
