#include "bench/timing.h"

#include <limits.h>
#include <linux/perf_event.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "common/bus.h"
#include "sim/base/aligned_array.h"

enum { BLOCKS_MAX = 100 };

/* File descriptor of a counter of this thread's instructions; -1: there is none. */
static int counter_open(void)
{
    struct perf_event_attr attr = {.type = PERF_TYPE_HARDWARE,
                                   .size = sizeof attr,
                                   .config = PERF_COUNT_HW_INSTRUCTIONS,
                                   .exclude_kernel = 1,
                                   .exclude_hv = 1};
    return (int)syscall(SYS_perf_event_open, &attr, 0, -1, -1, 0);
}

bool timing_counts_instructions(void)
{
    int counter = counter_open();
    if (counter < 0) {
        printf("*** NO PERFORMANCE COUNTERS HERE: INSTRUCTIONS ARE NOT COUNTED ***\n");
        return false;
    }
    close(counter);
    return true;
}

static double cpu_now_us(void)
{
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return 1e6 * (double)now.tv_sec + 1e-3 * (double)now.tv_nsec;
}

static int rising(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double counted(int counter)
{
    uint64_t value = 0;
    if (counter < 0 || read(counter, &value, sizeof value) != (ssize_t)sizeof value)
        return -1;
    return (double)value;
}

static enum status take(timed_part *part, void *user, int blocks, int repeats, double *us)
{
    for (int b = 0; b < blocks; b++) {
        double start = cpu_now_us();
        for (int k = 0; k < repeats; k++)
            TRY(part(user));
        us[b] = (cpu_now_us() - start) / repeats;
    }
    return STATUS_OK;
}

enum status timing_take(timed_part *part, void *user, int blocks, int repeats, struct timing *timing)
{
    double us[BLOCKS_MAX];
    int counter = counter_open();
    blocks = blocks < BLOCKS_MAX ? blocks : BLOCKS_MAX;
    enum status status = take(part, user, blocks, repeats, us);
    double instructions = counted(counter);
    if (counter >= 0)
        close(counter);
    TRY(status);
    qsort(us, (size_t)blocks, sizeof *us, rising);
    *timing = (struct timing){us[0], us[blocks / 2], instructions < 0 ? -1 : instructions / blocks / repeats};
    return STATUS_OK;
}

double timing_rank(double *values, int n, double part)
{
    qsort(values, (size_t)n, sizeof *values, rising);
    return values[(int)(part * (n - 1) + 0.5)];
}

enum { ROUNDS = 5000, ADDITIONS = 32 };

/* One addition waits for the other, and each takes one cycle. Not of a constant: that some cores add without waiting.
 */
static double chain_us(uint64_t one)
{
    uint64_t x = 0;
    double start = cpu_now_us();
    for (int k = 0; k < ROUNDS; k++)
        __asm__ volatile(".rept 32\n\tadd %1, %0\n\t.endr" : "+r"(x) : "r"(one));
    return cpu_now_us() - start;
}

/* Eight chains side by side: as many additions at a time as the core has left. */
static double side_by_side_us(uint64_t one)
{
    uint64_t x[8] = {0};
    double start = cpu_now_us();
    for (int k = 0; k < ROUNDS; k++)
        __asm__ volatile(".rept 4\n\tadd %8, %0\n\tadd %8, %1\n\tadd %8, %2\n\tadd %8, %3\n\t"
                         "add %8, %4\n\tadd %8, %5\n\tadd %8, %6\n\tadd %8, %7\n\t.endr"
                         : "+r"(x[0]), "+r"(x[1]), "+r"(x[2]), "+r"(x[3]), "+r"(x[4]), "+r"(x[5]), "+r"(x[6]),
                           "+r"(x[7])
                         : "r"(one));
    return cpu_now_us() - start;
}

struct timing_core timing_core(void)
{
    struct timing_core most = {0, 0};
    for (int k = 0; k < 10; k++) {
        double ghz = 1e-3 * ROUNDS * ADDITIONS / chain_us(1), per_ns = 1e-3 * ROUNDS * ADDITIONS / side_by_side_us(1);
        most.ghz = ghz > most.ghz ? ghz : most.ghz;
        most.additions_per_ns = per_ns > most.additions_per_ns ? per_ns : most.additions_per_ns;
    }
    return most;
}

static void add_one(void *context, int first, int end)
{
    double *array = context;
    for (int i = first; i < end; i++)
        array[i] += 1;
}

double timing_stream_gb_per_s(double bytes, struct thread_team *team)
{
    enum { GRAIN = 1 << 17, PASSES = 6 };
    const bool alone = thread_team_in_use(team) == 1;
    double least_us = INFINITY, *array = NULL;
    const int count = (int)fmin(bytes / sizeof *array + 1, INT_MAX - ARRAY_PADDING), turns = 1 + (int)(1e7 / bytes);
    if (array_resize(&array, sizeof *array, (size_t)count, 0) != STATUS_OK)
        return 0;
    for (int k = 0; k < PASSES; k++) { /* the first one takes the memory */
        const double start_us = alone ? cpu_now_us() : 1e6 * clock_now_s();
        for (int turn = 0; turn < turns; turn++)
            team_run_ranges(team, count, GRAIN, add_one, array);
        least_us = fmin(least_us, (alone ? cpu_now_us() : 1e6 * clock_now_s()) - start_us);
    }
    free(array);
    return 2e-3 * (double)turns * (double)count * sizeof *array / least_us;
}

void timing_core_print(const struct timing_core *before, const struct timing_core *after)
{
    printf("core: %.2f GHz (chain of additions), %.1f additions per ns side by side; afterwards %.2f GHz, %.1f\n",
           before->ghz, before->additions_per_ns, after->ghz, after->additions_per_ns);
}

json_t *timing_core_json(const struct timing_core *before, const struct timing_core *after)
{
    return json_pack("{s:[f, f], s:[f, f]}", "ghz", before->ghz, after->ghz, "additions_per_ns",
                     before->additions_per_ns, after->additions_per_ns);
}
