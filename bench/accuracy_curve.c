#include "bench/accuracy_curve.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "common/event_log.h"
#include "common/message.h"

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

static enum status take_event(struct curve *curve, const struct event *event, enum curve_quantity quantity, int c,
                              bool *ended)
{
    const int kind = message_kind(event->channel);
    union message message;
    if (kind != RECORD_SAMPLE && kind != RECORD_END)
        return STATUS_OK;
    TRY(message_decode(kind, event->data, event->size, &message));
    enum status status = STATUS_OK;
    if (kind == RECORD_SAMPLE) {
        status = take_sample(curve, &message.sample, quantity, c);
    } else {
        *ended = message.end.status == 0;
        curve->hash = message.end.state_hash;
    }
    message_free(kind, &message);
    return status;
}

enum status curve_read(struct curve *curve, const char *path, enum curve_quantity quantity, int c)
{
    struct event_reader log;
    struct event event;
    bool ended = false, found = false;
    *curve = (struct curve){0};
    enum status status = event_reader_open(&log, path);
    if (status == STATUS_OK)
        status = event_reader_next(&log, &event, &found);
    while (status == STATUS_OK && found) {
        status = take_event(curve, &event, quantity, c, &ended);
        if (status == STATUS_OK)
            status = event_reader_next(&log, &event, &found);
    }
    event_reader_close(&log);
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
