#include "common/watch/progress.h"

#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "common/status.h"

enum { PART_MAX = 160 };

/* "12.3 µs/step", or ms, or s. "" if unknown. */
static void step_time_text(char *text, size_t size, double steps_per_second)
{
    double us = 1e6 / steps_per_second;
    if (!(steps_per_second > 0) || !isfinite(steps_per_second))
        text[0] = '\0';
    else if (us < 1e3)
        snprintf(text, size, "%.1f µs/step", us);
    else if (us < 1e6)
        snprintf(text, size, "%.1f ms/step", us / 1e3);
    else
        snprintf(text, size, "%.1f s/step", us / 1e6);
}

/* "1:23" or "2:05:09". */
static void duration_text(char *text, size_t size, double duration_s)
{
    long long seconds = (long long)fmin(duration_s + 0.5, 1e9); /* also keeps the cast defined */
    if (seconds < 3600)
        snprintf(text, size, "%lld:%02lld", seconds / 60, seconds % 60);
    else
        snprintf(text, size, "%lld:%02lld:%02lld", seconds / 3600, seconds / 60 % 60, seconds % 60);
}

/* Characters of a UTF-8 text: its bytes without the continuations. */
static int text_columns(const char *text)
{
    int columns = 0;
    for (; *text; text++)
        columns += ((unsigned char)*text & 0xC0) != 0x80;
    return columns;
}

struct line {
    char *text;
    int columns; /* room; 0: no limit */
    int used;
    size_t bytes;
    bool full;
};

/* Appends a part and two blanks before it, unless it, or one before it, does not fit. */
static void PRINTF_LIKE(2, 3) line_add(struct line *line, const char *format, ...)
{
    char part[PART_MAX];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(part, sizeof part, format, arguments);
    va_end(arguments);

    const char *gap = line->bytes ? "  " : "";
    int columns = (int)strlen(gap) + text_columns(part);
    line->full = line->full || (line->columns > 0 && line->used + columns > line->columns) ||
                 line->bytes + strlen(gap) + strlen(part) >= PROGRESS_TEXT_MAX;
    if (line->full || part[0] == '\0')
        return;
    line->bytes += (size_t)snprintf(line->text + line->bytes, PROGRESS_TEXT_MAX - line->bytes, "%s%s", gap, part);
    line->used += columns;
}

static const char *left_prefix(int kind)
{
    return kind == 0 ? "" : kind == 1 ? "about " : "at most ";
}

void progress_format(char *text, const shakedown_status_t *status, int columns)
{
    struct line line = {.text = text, .columns = columns};
    char part[PART_MAX];
    text[0] = '\0';
    line_add(&line, "stage %d/%d %.60s", status->stage + 1, status->n_stages, status->stage_name);
    line_add(&line, "%3.0f %%", 100 * status->fraction_done);
    step_time_text(part, sizeof part, status->steps_per_second);
    line_add(&line, "%s", part);
    if (status->time_left_s >= 0) {
        duration_text(part, sizeof part, status->time_left_s);
        line_add(&line, "%s%s left", left_prefix(status->time_left_kind), part);
    }
    line_add(&line, "energy residual %.1e", status->energy_residual_ratio);
    if (status->commands_repeated > 0 || status->records_repeated > 0)
        line_add(&line, "sent again: %lld commands, %lld records", (long long)status->commands_repeated,
                 (long long)status->records_repeated);
}

void progress_format_end(char *text, const shakedown_end_t *end)
{
    struct line line = {.text = text};
    char duration[PART_MAX], step_time[PART_MAX];
    text[0] = '\0';
    duration_text(duration, sizeof duration, fmax(end->elapsed_s, 0));
    step_time_text(step_time, sizeof step_time, end->elapsed_s > 0 ? (double)end->step / end->elapsed_s : 0);
    if (end->status == STATUS_OK)
        line_add(&line, "done: %lld steps in %s", (long long)end->step, duration);
    else
        line_add(&line, "stopped after %lld steps in %s: %.80s", (long long)end->step, duration, end->reason);
    line_add(&line, "%s", step_time);
}
