#include "bench/timing.h"

#include <linux/perf_event.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

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

/* One addition waits for the other, and each takes one cycle. */
static double chain_ghz(void)
{
    enum { ADDITIONS = 200000 };
    uint64_t x = 0;
    double start = cpu_now_us();
    for (int k = 0; k < ADDITIONS; k++)
        __asm__ volatile("add $1, %0" : "+r"(x));
    return 1e-3 * ADDITIONS / (cpu_now_us() - start);
}

double timing_core_ghz(void)
{
    double most = 0;
    for (int k = 0; k < 5; k++) {
        double ghz = chain_ghz();
        most = ghz > most ? ghz : most;
    }
    return most;
}

void timing_core_print(double before_ghz, double after_ghz)
{
    printf("core: %.2f GHz before, %.2f GHz after (chain of additions)\n", before_ghz, after_ghz);
}
