#include "studies/progress.h"

#include <stdarg.h>
#include <stdio.h>
#include <time.h>
#include <unistd.h>

static double now_s(void)
{
    struct timespec now;
    return clock_gettime(CLOCK_MONOTONIC, &now) == 0 ? (double)now.tv_sec + 1e-9 * (double)now.tv_nsec : 0;
}

void progress_start(struct progress *progress, int n, double cost, int done, double cost_before)
{
    *progress = (struct progress){.n = n,
                                  .done = done,
                                  .cost = cost,
                                  .cost_before = cost_before,
                                  .start_s = now_s(),
                                  .terminal = isatty(STDERR_FILENO) == 1};
}

/* "2 h 5 min", "3 min 20 s", "12 s". */
static const char *time_text(double s, char text[48])
{
    long t = (long)(s + 0.5);
    if (t >= 3600)
        snprintf(text, 48, "%ld h %ld min", t / 3600, t / 60 % 60);
    else if (t >= 60)
        snprintf(text, 48, "%ld min %ld s", t / 60, t % 60);
    else
        snprintf(text, 48, "%ld s", t);
    return text;
}

void progress_show(const struct progress *progress)
{
    char left[48] = "", gone[48];
    double elapsed_s = now_s() - progress->start_s;
    double rest = progress->cost - progress->cost_before - progress->cost_done;
    bool known = progress->cost_done > 0 && rest > 0;
    if (known)
        time_text(elapsed_s * rest / progress->cost_done, left);
    fprintf(stderr, "%sstudy: %d of %d done, %d running, %d failed, %s gone%s%s%s%s",
            progress->terminal ? "\r\033[K" : "", progress->done, progress->n, progress->running, progress->failed,
            time_text(elapsed_s, gone), known ? ", about " : "", left, known ? " left" : "",
            progress->terminal ? "" : "\n");
    (void)fflush(stderr);
}

void progress_say(const struct progress *progress, const char *format, ...)
{
    va_list arguments;
    fputs(progress->terminal ? "\r\033[Kstudy: " : "study: ", stderr);
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
}
