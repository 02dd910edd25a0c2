#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/coupling_bench.h"
#include "common/coupling.h"

static int rising(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double coupling_median_ratio(const struct coupling_point *point)
{
    double ratio[COUPLING_ROUNDS_MAX];
    const int n = point->n_ratios;
    if (n == 0)
        return NAN;
    memcpy(ratio, point->ratio, sizeof ratio);
    qsort(ratio, (size_t)n, sizeof *ratio, rising);
    return n % 2 ? ratio[n / 2] : 0.5 * (ratio[n / 2 - 1] + ratio[n / 2]);
}

json_t *coupling_number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

static json_t *errors_json(const struct curve_errors *e)
{
    return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "stress", coupling_number(e->stress), "early",
                     coupling_number(e->early), "peak", coupling_number(e->peak), "position",
                     coupling_number(e->position), "strain", coupling_number(e->strain), "gain",
                     coupling_number(e->gain), "residual", coupling_number(e->residual), "controller_residual",
                     coupling_number(e->controller_residual));
}

static json_t *point_json(const struct coupling_work *work, const struct coupling_point *point)
{
    char name[64];
    coupling_point_name(point, name, sizeof name);
    char *space = strchr(name, ' ');
    *space = 0;
    json_t *row = json_pack("{s:s, s:i, s:o, s:b, s:b, s:i}", "scheme", name, "interval_steps", point->n, "tolerance",
                            point->tolerance > 0 ? json_real(point->tolerance) : json_null(), "ran", point->ran,
                            "failed", point->failed, "exit_code", point->exit_code);
    if (point->message[0])
        json_object_set_new(row, "message", json_string(point->message));
    if (!point->ran)
        return row;
    json_t *ratios = json_array();
    for (int k = 0; k < point->n_ratios; k++)
        json_array_append_new(ratios, json_real(point->ratio[k]));
    json_object_set_new(row, "time_ratio", coupling_number(coupling_median_ratio(point)));
    json_object_set_new(row, "time_ratios", ratios);
    json_object_set_new(row, "error", coupling_number(coupling_error(work->at, &point->errors)));
    json_object_set_new(row, "exchanges", json_integer(point->errors.exchanges));
    json_object_set_new(row, "errors", errors_json(&point->errors));
    return row;
}

static void print_errors(const struct curve_errors *e)
{
    printf(" %9.1e %9.1e %9.1e %9.1e %9.1e %9.1e %9.1e %9.1e", e->stress, e->early, e->peak, e->position, e->strain,
           e->gain, e->residual, e->controller_residual);
}

static void print_point(const struct coupling_point *point)
{
    char name[64];
    coupling_point_name(point, name, sizeof name);
    printf("  %-16s", name);
    if (!point->ran) {
        printf(" %s: %s\n", point->failed ? "failed" : "unstable", point->message);
        return;
    }
    printf(" %7.3f %8" PRId64, coupling_median_ratio(point), point->errors.exchanges);
    print_errors(&point->errors);
    printf("\n");
}

/* The cheapest point that is accurate enough. */
static const struct coupling_point *cheapest(const struct coupling_work *work, double error)
{
    const struct coupling_point *best = NULL;
    for (int k = 0; k < work->n; k++) {
        const struct coupling_point *point = &work->point[k];
        if (point->ran && coupling_error(work->at, &point->errors) <= error &&
            (!best || coupling_median_ratio(point) < coupling_median_ratio(best)))
            best = point;
    }
    return best;
}

static json_t *report_targets(const struct coupling_work *work)
{
    json_t *targets = json_array();
    for (int t = 0; t < COUPLING_TARGETS_MAX && work->at->target[t].error > 0; t++) {
        const struct coupling_target *target = &work->at->target[t];
        const struct coupling_point *best = cheapest(work, target->error);
        char name[64] = "none";
        double ratio = best ? coupling_median_ratio(best) : NAN;
        if (best)
            coupling_point_name(best, name, sizeof name);
        bool met = best && ratio <= target->ratio;
        printf("  target: at most %.2f times at an error of at most %g: %s", target->ratio, target->error,
               met ? "met" : "missed");
        if (best)
            printf(" by %s, %.3f times at %.1e", name, ratio, coupling_error(work->at, &best->errors));
        printf("\n");
        json_array_append_new(targets,
                              json_pack("{s:f, s:f, s:b, s:s, s:o}", "error", target->error, "ratio", target->ratio,
                                        "met", met, "by", name, "time_ratio", coupling_number(ratio)));
    }
    return targets;
}

static void shipped_print(const struct coupling_work *work, const struct coupling_point *point)
{
    if (point->ran)
        printf("  %5.2f %8.1e", coupling_median_ratio(point), coupling_error(work->at, &point->errors));
    else
        printf("  %5s %8s", "-", point->failed ? "failed" : "unstable");
}

void coupling_shipped_report(const struct coupling_work *work, int n)
{
    printf("\n%-24s %8s %4s %6s  %-14s  %-14s %9s  %s\n", "scene", "us/step", "n", "ahead", "as it is", "impedance",
           "floor", "time over in process, error of");
    for (int w = 0; w < n; w++) {
        const struct coupling_work *at = &work[w];
        const int ahead = coupling_ahead_steps(&at->own, (int)at->own.interval_steps);
        printf("%-24s %8.1f %4" PRId64 " %6d", at->at->name, 1e6 * at->reference_s / (double)at->steps,
               at->own.interval_steps, ahead);
        for (int k = 0; k < at->n; k++)
            shipped_print(at, &at->point[k]);
        printf(" %9.1e  %s\n", coupling_error(at->at, &at->floor),
               at->at->measure == MEASURE_STRAIN ? "strain" : "stress, to 1.5 %");
    }
}

json_t *coupling_report(const struct coupling_work *work)
{
    static const char *const measure[] = {
        [MEASURE_STRESS] = "stress", [MEASURE_EARLY] = "early", [MEASURE_STRAIN] = "strain"};
    const double us = 1e6 * work->reference_s / (double)work->steps;
    json_t *points = json_array();
    printf("\n%s: %" PRId64 " steps, in process %.2f s (%.2f us per step); what counts: %s\n", work->at->title,
           work->steps, work->reference_s, us, measure[work->at->measure]);
    printf("  %-16s %7s %8s %9s %9s %9s %9s %9s %9s %9s %9s\n", "scheme", "time", "exchange", "stress", "early", "peak",
           "position", "strain", "gain", "residual", "at wallct");
    printf("  %-16s %7s %8s", "floor", "", "");
    print_errors(&work->floor);
    printf("\n");
    for (int k = 0; k < work->n; k++) {
        if (!work->point[k].ran && work->point[k].exit_code == 0 && !work->point[k].failed)
            continue; /* not tried */
        print_point(&work->point[k]);
        json_array_append_new(points, point_json(work, &work->point[k]));
    }
    return json_pack("{s:s, s:s, s:I, s:f, s:f, s:s, s:o, s:o, s:o, s:o}", "name", work->at->name, "title",
                     work->at->title, "steps", (json_int_t)work->steps, "in_process_s", work->reference_s,
                     "us_per_step", us, "measure", measure[work->at->measure], "floor",
                     coupling_number(coupling_error(work->at, &work->floor)), "floor_errors", errors_json(&work->floor),
                     "points", points, "targets", report_targets(work));
}
