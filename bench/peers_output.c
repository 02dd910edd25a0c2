#include "bench/peers_output.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The last place where `mark` stands at the start of a line; NULL: nowhere. */
static const char *last_line(const char *text, const char *mark)
{
    const char *found = NULL;
    for (const char *at = strstr(text, mark); at; at = strstr(at + 1, mark))
        if (at == text || at[-1] == '\n' || at[-1] == '\r')
            found = at;
    return found;
}

/* Our line of it, among others of sim; NULL: there is none. */
static const char *our_loop(const char *log, long *steps, double *seconds)
{
    static const char form[] = "sim: %ld steps, %lf s";
    for (const char *at = log; at; at = strchr(at, '\n') ? strchr(at, '\n') + 1 : NULL)
        if (sscanf(at, form, steps, seconds) == 2)
            return at;
    return NULL;
}

enum status peers_read_loop(const char *log, int processes, double *us_per_step)
{
    double seconds;
    long steps;
    int found = processes;
    const char *line = last_line(log, "Loop time of ");
    if (line) {
        if (sscanf(line, "Loop time of %lf on %d procs for %ld steps", &seconds, &found, &steps) != 3)
            return status_fail(STATUS_FORMAT, "a log with an unknown kind of loop time: %.60s", line);
    } else {
        line = our_loop(log, &steps, &seconds);
        if (!line)
            return status_fail(STATUS_FORMAT, "a log without the time of the loop");
    }
    if (steps < 1 || !(seconds > 0) || found != processes)
        return status_fail(STATUS_FORMAT, "no time per step of %d process%s in: %.60s", processes,
                           processes == 1 ? "" : "es", line);
    *us_per_step = 1e6 * seconds / (double)steps;
    return STATUS_OK;
}

/* Rows of an id and n_vectors vectors from the line after `at`. */
static enum status read_rows(const char *at, int count, int n_vectors, double *const *vector)
{
    at = strchr(at, '\n');
    for (int i = 0; i < count; i++) {
        double number[10];
        for (int k = 0; k < 3 * n_vectors + 1; k++) {
            char *end = NULL;
            number[k] = at ? strtod(at, &end) : 0;
            if (!at || end == at || !isfinite(number[k]))
                return status_fail(STATUS_FORMAT, "a dump that ends, or has no number, at particle %d of %d", i + 1,
                                   count);
            at = end;
        }
        if (number[0] != i + 1)
            return status_fail(STATUS_FORMAT, "a dump with particle %g in place of %d", number[0], i + 1);
        for (int k = 0; k < n_vectors; k++)
            memcpy(vector[k] + 3 * (size_t)i, number + 1 + 3 * k, 3 * sizeof *number);
    }
    return STATUS_OK;
}

enum status peers_read_dump(const char *text, int count, double *position_m, double *force_n)
{
    const char *at = last_line(text, "ITEM: ATOMS id x y z fx fy fz");
    if (!at)
        return status_fail(STATUS_FORMAT, "a dump without particles");
    return read_rows(at, count, 2, (double *const[]){position_m, force_n});
}

enum status peers_read_snapshot(const char *text, int snapshot, int count, double *position_m, double *velocity_m_per_s,
                                double *force_n)
{
    static const char head[] = "ITEM: ATOMS id x y z vx vy vz fx fy fz";
    const char *at = strstr(text, head);
    for (int k = 0; at && k < snapshot; k++)
        at = strstr(at + 1, head);
    if (!at)
        return status_fail(STATUS_FORMAT, "a dump without snapshot %d", snapshot);
    return read_rows(at, count, 3, (double *const[]){position_m, velocity_m_per_s, force_n});
}

struct peers_difference peers_compare(const double *a, const double *b, int count)
{
    struct peers_difference difference = {0};
    double sum = 0;
    for (int i = 0; i < count; i++) {
        double d2 = 0;
        for (int c = 0; c < 3; c++)
            d2 += (a[3 * i + c] - b[3 * i + c]) * (a[3 * i + c] - b[3 * i + c]);
        sum += d2;
        difference.largest = fmax(difference.largest, sqrt(d2));
    }
    difference.rms = count > 0 ? sqrt(sum / count) : 0;
    return difference;
}
