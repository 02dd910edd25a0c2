#include "bench/accuracy_curve.h"

#include <lcm/eventlog.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "common/bus.h"
#include "shakedown_end_t.h"
#include "shakedown_sample_t.h"

static enum status grow(struct curve *curve)
{
    if ((curve->count & (curve->count - 1)) != 0) /* full at powers of two */
        return STATUS_OK;
    size_t size = (curve->count > 0 ? 2 * (size_t)curve->count : 1) * sizeof(double);
    double **member[] = {&curve->time_s, &curve->strain, &curve->value};
    for (size_t k = 0; k < sizeof member / sizeof *member; k++) {
        double *larger = realloc(*member[k], size);
        if (!larger)
            return status_fail(STATUS_NO_MEMORY, "out of memory");
        *member[k] = larger;
    }
    return STATUS_OK;
}

static enum status take_sample(struct curve *curve, const shakedown_sample_t *sample, enum curve_quantity quantity,
                               int c)
{
    if (c >= sample->dimension)
        return status_fail(STATUS_FORMAT, "a sample of dimension %d has no component %d", sample->dimension, c);
    TRY(grow(curve));
    curve->time_s[curve->count] = sample->time_s;
    curve->strain[curve->count] = sample->strain[c];
    curve->value[curve->count++] = quantity == CURVE_STRAIN ? sample->strain[c] : sample->stress_wall_pa[c];
    double work = sample->work_walls_j + sample->work_gravity_j;
    curve->residual_ratio = work != 0 ? fabs(sample->energy_residual_j / work) : 0;
    return STATUS_OK;
}

static enum status take_event(struct curve *curve, const lcm_eventlog_event_t *event, enum curve_quantity quantity,
                              int c, bool *ended)
{
    enum status status = STATUS_OK;
    if (strcmp(event->channel, record_channel_name[RECORD_SAMPLE]) == 0) {
        shakedown_sample_t sample;
        if (shakedown_sample_t_decode(event->data, 0, event->datalen, &sample) < 0)
            return status_fail(STATUS_FORMAT, "a sample that cannot be decoded");
        status = take_sample(curve, &sample, quantity, c);
        (void)shakedown_sample_t_decode_cleanup(&sample);
    } else if (strcmp(event->channel, record_channel_name[RECORD_END]) == 0) {
        shakedown_end_t end;
        if (shakedown_end_t_decode(event->data, 0, event->datalen, &end) < 0)
            return status_fail(STATUS_FORMAT, "an END that cannot be decoded");
        *ended = end.status == 0;
        curve->hash = end.state_hash;
        (void)shakedown_end_t_decode_cleanup(&end);
    }
    return status;
}

enum status curve_read(struct curve *curve, const char *path, enum curve_quantity quantity, int c)
{
    bool ended = false;
    *curve = (struct curve){0};
    lcm_eventlog_t *log = lcm_eventlog_create(path, "r");
    if (!log)
        return status_fail(STATUS_IO, "%s cannot be read", path);
    enum status status = STATUS_OK;
    lcm_eventlog_event_t *event;
    while (status == STATUS_OK && (event = lcm_eventlog_read_next_event(log)) != NULL) {
        status = take_event(curve, event, quantity, c, &ended);
        lcm_eventlog_free_event(event);
    }
    lcm_eventlog_destroy(log);
    if (status == STATUS_OK && (curve->count == 0 || !ended))
        status = status_fail(STATUS_FORMAT, "%s: %s", path, ended ? "no samples" : "the run did not end well");
    if (status != STATUS_OK)
        curve_free(curve);
    return status;
}

void curve_free(struct curve *curve)
{
    free(curve->time_s);
    free(curve->strain);
    free(curve->value);
    *curve = (struct curve){0};
}

enum status curve_error(const struct curve *a, const struct curve *b, double strain_max, double *error)
{
    double difference = 0, sum = 0;
    if (a->count != b->count)
        return status_fail(STATUS_FORMAT, "curves of %d and %d samples", a->count, b->count);
    for (int k = 0; k < b->count; k++) {
        /* times are multiples of different steps: equal but for rounding */
        if (fabs(a->time_s[k] - b->time_s[k]) > 1e-9 * fabs(b->time_s[b->count - 1]))
            return status_fail(STATUS_FORMAT, "sample %d was taken at %g s and at %g s", k, a->time_s[k], b->time_s[k]);
        if (fabs(b->strain[k]) > strain_max)
            continue;
        difference += (a->value[k] - b->value[k]) * (a->value[k] - b->value[k]);
        sum += b->value[k] * b->value[k];
    }
    if (!(sum > 0))
        return status_fail(STATUS_FORMAT, "a curve that is zero");
    *error = sqrt(difference / sum);
    return STATUS_OK;
}

double convergence_order(double step_a, double error_a, double step_b, double error_b)
{
    return log(error_a / error_b) / log(step_a / step_b);
}
