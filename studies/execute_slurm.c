/* Runs as a job array of Slurm. Exit codes, squeue's and sbatch's, say little (docs/studies.md): what counts is what
 * the runs leave in their folders. */
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/signals.h"
#include "studies/execute.h"
#include "studies/files.h"
#include "studies/process.h"
#include "studies/progress.h"

/* An array has at most MaxArraySize elements, 1001 unless configured: each takes every ARRAY_MAX-th run. */
enum { ARRAY_MAX = 1000, OPTIONS_MAX = 32, POLL_MS = 1000 };

struct array {
    const struct execution *execution;
    struct outcome *outcome;
    struct progress progress;
    char folder[2304]; /* OUT/slurm */
    char job[32];      /* number of the array in the queue; "": none */
};

/* Runs a command and gives what it says on stdout and stderr, to be freed. STATUS_IO if it fails. */
static enum status command(const struct array *array, const char *const *argv, char **said)
{
    char path[2400];
    int code;
    TRY(files_join(path, sizeof path, array->folder, "command.out"));
    TRY(files_remove(path));
    TRY(process_run(argv, NULL, path, &code));
    TRY(files_read(path, said));
    if (code == 0)
        return STATUS_OK;
    enum status status = code == 127 ? status_fail(STATUS_IO, "%s cannot be started: is Slurm here?", argv[0])
                                     : status_fail(STATUS_IO, "%s failed: %s", argv[0], *said);
    free(*said);
    *said = NULL;
    return status;
}

/* --- What the array does ----------------------------------------------------------------------------------------- */

/* In single quotes for the shell. */
static void quoted(FILE *out, const char *text)
{
    fputc('\'', out);
    for (; *text; text++)
        if (*text == '\'')
            fputs("'\\''", out);
        else
            fputc(*text, out);
    fputc('\'', out);
}

static void script_print(FILE *out, const struct array *array)
{
    fputs("#!/bin/bash\n# Each element takes its lines of the list.\nlist=", out);
    quoted(out, array->folder);
    fputs("/list\nbin=", out);
    quoted(out, array->execution->bin);
    fputs("\nout=", out);
    quoted(out, array->execution->out);
    fprintf(out,
            "\nsed -n \"$((SLURM_ARRAY_TASK_ID + 1))~%dp\" \"$list\" | while read -r run; do\n"
            "    \"$bin/studies/study\" --task \"$run\" --out \"$out\" --bin \"$bin\" </dev/null\ndone\n",
            ARRAY_MAX);
}

static void list_print(FILE *out, const struct array *array)
{
    for (int k = 0; k < array->execution->plan->n_runs; k++)
        if (!array->outcome[k].done && array->outcome[k].tries < EXECUTE_TRIES)
            fprintf(out, "%s\n", array->execution->plan->run[k].name);
}

static enum status file_make(const struct array *array, const char *name, void (*print)(FILE *, const struct array *))
{
    char path[2400], *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    print(out, array);
    enum status status = fclose(out) == 0 ? STATUS_OK : status_fail(STATUS_NO_MEMORY, "out of memory");
    if (status == STATUS_OK)
        status = files_join(path, sizeof path, array->folder, name);
    if (status == STATUS_OK)
        status = files_write(path, text);
    free(text);
    return status;
}

/* --- Submission -------------------------------------------------------------------------------------------------- */

/* Splits the user's options at blanks; `text` is changed. */
static enum status options_add(char *text, const char **argv, int *n)
{
    char *rest;
    for (char *word = strtok_r(text, " \t", &rest); word; word = strtok_r(NULL, " \t", &rest)) {
        if (*n + 2 >= OPTIONS_MAX)
            return status_fail(STATUS_USAGE, "--sbatch: more than %d options", OPTIONS_MAX / 2);
        argv[(*n)++] = word;
    }
    return STATUS_OK;
}

static enum status job_note(struct array *array, const char *job)
{
    char path[2400];
    snprintf(array->job, sizeof array->job, "%.*s", (int)strspn(job, "0123456789"), job);
    if (!array->job[0])
        return status_fail(STATUS_FORMAT, "sbatch says '%s' instead of a job's number", job);
    TRY(files_join(path, sizeof path, array->folder, "job"));
    return files_write(path, array->job);
}

static enum status submit(struct array *array, int n)
{
    const char *argv[OPTIONS_MAX] = {"sbatch", "--parsable", "--requeue", "--open-mode=append"};
    char elements[64], script[2400], output[2500], name[64], *options, *said = NULL;
    int used = 4;
    if (array->execution->jobs > 0)
        snprintf(elements, sizeof elements, "--array=0-%d%%%d", (n < ARRAY_MAX ? n : ARRAY_MAX) - 1,
                 array->execution->jobs);
    else
        snprintf(elements, sizeof elements, "--array=0-%d", (n < ARRAY_MAX ? n : ARRAY_MAX) - 1);
    TRY(files_join(script, sizeof script, array->folder, "script"));
    snprintf(output, sizeof output, "--output=%s/log-%%A_%%a", array->folder);
    snprintf(name, sizeof name, "--job-name=shakedown-study");
    argv[used++] = elements;
    argv[used++] = output;
    argv[used++] = name;
    options = strdup(array->execution->sbatch);
    enum status status = options ? options_add(options, argv, &used) : status_fail(STATUS_NO_MEMORY, "out of memory");
    argv[used++] = script;
    argv[used] = NULL;
    if (status == STATUS_OK)
        status = command(array, argv, &said);
    if (status == STATUS_OK)
        status = job_note(array, said);
    free(said);
    free(options);
    return status;
}

/* --- Waiting ----------------------------------------------------------------------------------------------------- */

/* Whether elements of the array wait or run. A job that Slurm has forgotten has ended. */
static enum status is_queued(const struct array *array, bool *queued)
{
    const char *const argv[] = {"squeue", "--noheader", "--format=%i", "--jobs", array->job, NULL};
    char *said = NULL;
    enum status status = command(array, argv, &said);
    *queued = status == STATUS_OK && said[0];
    free(said);
    return status == STATUS_OK || strstr(status_message(), "Invalid job id") ? STATUS_OK : status;
}

static enum status cancel(const struct array *array)
{
    const char *const argv[] = {"scancel", array->job, NULL};
    char *said = NULL;
    TRY(command(array, argv, &said));
    free(said);
    return status_fail(STATUS_INTERRUPTED, "interrupted, the array is cancelled; the same command goes on");
}

static enum status judge_all(struct array *array)
{
    const struct plan *plan = array->execution->plan;
    int before = array->progress.done;
    for (int k = 0; k < plan->n_runs; k++) {
        if (array->outcome[k].done)
            continue;
        TRY(outcome_judge(array->execution, k, &array->outcome[k]));
        array->progress.done += array->outcome[k].done;
        array->progress.cost_done += array->outcome[k].done ? plan->run[k].cost : 0;
    }
    if (array->progress.done != before || array->progress.terminal)
        progress_show(&array->progress);
    return STATUS_OK;
}

static enum status array_wait(struct array *array)
{
    char path[2400];
    bool queued = true;
    while (queued) {
        if (stop_requested())
            return cancel(array);
        (void)poll(NULL, 0, POLL_MS); /* a signal ends it early */
        TRY(is_queued(array, &queued));
        TRY(judge_all(array));
    }
    TRY(files_join(path, sizeof path, array->folder, "job"));
    return files_remove(path);
}

/* The array of a study that was killed, if it is still in the queue, is waited for: two would do the same work. */
static enum status array_left(struct array *array)
{
    char path[2400], *job;
    TRY(files_join(path, sizeof path, array->folder, "job"));
    if (!files_exist(path))
        return STATUS_OK;
    TRY(files_read(path, &job));
    enum status status = job_note(array, job);
    free(job);
    TRY(status);
    progress_say(&array->progress, "waiting for job %s, which is in the queue from before", array->job);
    return array_wait(array);
}

static void failures_say(const struct array *array, bool again)
{
    for (int k = 0; k < array->execution->plan->n_runs; k++)
        if (!array->outcome[k].done)
            progress_say(&array->progress, "%s failed%s: %s", array->execution->plan->run[k].name,
                         again ? ", once more" : " again", array->outcome[k].reason);
}

/* One array with everything that is not done. */
static enum status array_try(struct array *array, int *left)
{
    *left = 0;
    for (int k = 0; k < array->execution->plan->n_runs; k++)
        *left += !array->outcome[k].done;
    if (*left == 0)
        return STATUS_OK;
    TRY(file_make(array, "list", list_print));
    TRY(file_make(array, "script", script_print));
    for (int k = 0; k < array->execution->plan->n_runs; k++)
        array->outcome[k].tries += !array->outcome[k].done;
    TRY(submit(array, *left));
    progress_say(&array->progress, "job %s, %d runs", array->job, *left);
    TRY(array_wait(array));
    *left = array->execution->plan->n_runs - array->progress.done;
    return STATUS_OK;
}

enum status execute_slurm(const struct execution *execution, struct outcome *outcome)
{
    struct array array = {.execution = execution, .outcome = outcome};
    double cost = 0;
    int left = 1;
    TRY(files_join(array.folder, sizeof array.folder, execution->out, "slurm"));
    TRY(files_make_folder(array.folder));
    for (int k = 0; k < execution->plan->n_runs; k++)
        cost += execution->plan->run[k].cost;
    progress_start(&array.progress, execution->plan->n_runs, cost, 0, 0);
    TRY(judge_all(&array));
    array.progress.cost_before = array.progress.cost_done;
    array.progress.cost_done = 0;
    TRY(array_left(&array));
    for (int k = 0; k < EXECUTE_TRIES && left > 0; k++) {
        TRY(array_try(&array, &left));
        if (left > 0)
            failures_say(&array, k + 1 < EXECUTE_TRIES);
    }
    return STATUS_OK;
}
