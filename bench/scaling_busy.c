#include "bench/scaling_busy.h"

#include <errno.h>
#include <math.h>
#include <sched.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/bus.h"
#include "sim/run/sample_source.h"
#include "sim/sample/step_completion.h"
#include "sim/sample/time_step.h"

enum { TURNS = 6, RELAX_STEPS = 300 };
static const double TURN_S = 1;

struct contestant {
    struct scene scene;
    struct sample *sample;
};

static enum status open_contestant(struct contestant *c, const struct scaling_busy *busy, int threads)
{
    TRY(lattice_scene(&c->scene, busy->kind, threads, busy->precision, busy->count));
    TRY(sample_from_scene(&c->sample, &c->scene));
    TRY(lattice_pack(c->sample, busy->kind, false));
    TRY(lattice_begin(c->sample, 0));
    TRY(lattice_steps(c->sample, RELAX_STEPS));
    return lattice_begin(c->sample, 1);
}

static void close_contestant(struct contestant *c)
{
    sample_free(c->sample);
    scene_free(&c->scene);
}

static enum status time_turn(struct contestant *c, int steps, double *s)
{
    const double start = clock_now_s();
    TRY(lattice_steps(c->sample, steps));
    (void)sample_complete(c->sample);
    *s = clock_now_s() - start;
    return STATUS_OK;
}

/* Steps that take one thread about as long as a turn is to be. */
static enum status find_steps(struct contestant *one, int *steps)
{
    double s = 0;
    for (*steps = 8; *steps < 1 << 20; *steps *= 2) {
        TRY(time_turn(one, *steps, &s));
        if (s > 0.1 * TURN_S)
            break;
    }
    *steps = (int)fmax(1, *steps * TURN_S / s);
    return STATUS_OK;
}

struct turns {
    double one_s, many_s, worst;
};

static enum status take_turns(struct contestant *one, struct contestant *many, int steps, struct turns *all)
{
    *all = (struct turns){0};
    for (int k = 0; k < TURNS; k++) {
        double one_s = 0, many_s = 0;
        TRY(time_turn(one, steps, &one_s));
        TRY(time_turn(many, steps, &many_s));
        all->one_s += one_s;
        all->many_s += many_s;
        all->worst = fmax(all->worst, many_s / one_s);
    }
    return STATUS_OK;
}

/* Never waits, on the first of the cores that it may use; ends with this process. */
static void keep_busy(void)
{
    cpu_set_t set;
    int core = 0;
    (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (sched_getaffinity(0, sizeof set, &set) != 0)
        _exit(1);
    while (core + 1 < CPU_SETSIZE && !CPU_ISSET(core, &set))
        core++;
    CPU_ZERO(&set);
    CPU_SET(core, &set);
    if (sched_setaffinity(0, sizeof set, &set) != 0)
        _exit(1);
    for (volatile unsigned turns = 0;; turns++)
        ;
}

static enum status take_turns_beside(struct contestant *one, struct contestant *many, int steps, struct turns *all)
{
    int state;
    const pid_t other = fork();
    if (other < 0)
        return status_fail(STATUS_IO, "no other program: %s", strerror(errno));
    if (other == 0)
        keep_busy();
    enum status status = take_turns(one, many, steps, all);
    if (waitpid(other, &state, WNOHANG) != 0)
        return status_fail(STATUS_IO, "the other program did not last");
    if (kill(other, SIGKILL) != 0 || waitpid(other, &state, 0) != other)
        return status_fail(STATUS_IO, "the other program: %s", strerror(errno));
    return status;
}

static enum status measure(struct scaling_busy *busy, struct contestant *one, struct contestant *many)
{
    struct turns before, beside;
    TRY(open_contestant(one, busy, 1));
    TRY(open_contestant(many, busy, busy->threads));
    TRY(find_steps(one, &busy->steps));
    TRY(take_turns(one, many, busy->steps, &before));
    TRY(take_turns_beside(one, many, busy->steps, &beside));
    busy->turns = TURNS;
    busy->one_us = 1e6 * beside.one_s / busy->steps / TURNS;
    busy->many_us = 1e6 * beside.many_s / busy->steps / TURNS;
    busy->worst = beside.worst;
    busy->undisturbed = before.many_s / before.one_s;
    return STATUS_OK;
}

enum status scaling_busy_measure(struct scaling_busy *busy)
{
    struct contestant *both = calloc(2, sizeof *both);
    if (!both)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    enum status status = measure(busy, &both[0], &both[1]);
    close_contestant(&both[0]);
    close_contestant(&both[1]);
    free(both);
    return status;
}
