#include "bench/scaling_model.h"

#include <math.h>
#include <stdbool.h>

enum { THREADS_MAX = 256 };

/* The member whose next piece the thread takes: its own or, in a circle, the first that has one left; -1: none. */
static int owner_of_next(const int *next, const int *end, int threads, int self)
{
    for (int k = 0; k < threads; k++)
        if (next[(self + k) % threads] < end[(self + k) % threads])
            return (self + k) % threads;
    return -1;
}

static int first_to_finish(const double *busy_us, int threads)
{
    int first = 0;
    for (int t = 1; t < threads; t++)
        first = busy_us[t] < busy_us[first] ? t : first;
    return first;
}

double scaling_model_makespan(const double *piece_us, int n, int threads)
{
    double busy_us[THREADS_MAX] = {0}, longest = 0;
    int next[THREADS_MAX], end[THREADS_MAX];
    for (int t = 0; t < threads; t++) {
        next[t] = (int)((long long)n * t / threads);
        end[t] = (int)((long long)n * (t + 1) / threads);
    }
    for (int done = 0; done < n; done++) {
        const int t = first_to_finish(busy_us, threads), owner = owner_of_next(next, end, threads, t);
        busy_us[t] += piece_us[next[owner]++];
    }
    for (int t = 0; t < threads; t++)
        longest = fmax(longest, busy_us[t]);
    return longest;
}

/* All pieces of the walls take as long. */
static double walls_us(const struct scaling_model *model, int threads)
{
    double rounds = 0, pieces = 0;
    for (int k = 0; k < model->n_axes; k++) {
        rounds += ceil((double)model->n_pieces[k] / threads);
        pieces += model->n_pieces[k];
    }
    return pieces > 0 ? model->walls_us * rounds / pieces : 0;
}

double scaling_model_step_us(const struct scaling_model *model, int threads)
{
    const double blocks = scaling_model_makespan(model->block_us, model->n_blocks, threads);
    const double jobs = threads > 1 ? model->n_jobs * model->job_us : 0;
    const double us = model->serial_us + blocks + walls_us(model, threads) + jobs;
    const bool cached = model->data_mb <= threads * model->cache_mb;
    return threads > 1 && !cached ? fmax(us, 1e3 * model->bytes_mb / model->bandwidth_gb_per_s) : us;
}
