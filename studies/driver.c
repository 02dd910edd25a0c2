#include "studies/driver.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "studies/execute.h"
#include "studies/files.h"
#include "studies/plan.h"
#include "studies/report.h"
#include "studies/study.h"
#include "studies/task.h"

static enum status folder_make(const struct driver *driver, const struct study *study, char out[PATH_MAX])
{
    char path[CONFIG_STRING_MAX + 32];
    snprintf(path, sizeof path, "runs/study-%s", study->name);
    TRY(files_make_folder(driver->out ? driver->out : path));
    if (!realpath(driver->out ? driver->out : path, out))
        return status_fail(STATUS_IO, "%s: there is no such folder", driver->out ? driver->out : path);
    return STATUS_OK;
}

/* Whether `file` is one of ours, which is called by its name. */
static bool is_shipped(const struct study *study, const char *file)
{
    char end[CONFIG_STRING_MAX + 16];
    int length = snprintf(end, sizeof end, "/studies/%s.cfg", study->name);
    size_t size = strlen(file);
    return size >= (size_t)length && strcmp(file + size - (size_t)length, end) == 0;
}

/* The command line that makes this study again, without its folder. */
static enum status command_text(const struct driver *driver, const struct study *study, const char *file, char **text)
{
    size_t size = 0;
    FILE *out = open_memstream(text, &size);
    if (!out)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    fprintf(out, "./shakedown study %s", is_shipped(study, file) ? study->name : file);
    for (int k = 0; k < driver->n_set; k++)
        fprintf(out, " --set '%s'", driver->set[k]);
    return fclose(out) == 0 ? STATUS_OK : status_fail(STATUS_NO_MEMORY, "out of memory");
}

static enum status list(const struct plan *plan, const char *out)
{
    for (int k = 0; k < plan->n_runs; k++) {
        struct task task;
        TRY(task_open(&task, out, plan->run[k].name));
        bool done = strcmp(task.hash, plan->run[k].hash) == 0 && task_is_done(&task);
        printf("%-8s %s\n", done ? "done" : "to do", plan->run[k].name);
    }
    printf("%d runs, %d preparations\n", plan->n_runs, plan->n_preparations);
    return STATUS_OK;
}

static int cores(void)
{
    long n = sysconf(_SC_NPROCESSORS_ONLN);
    return n > 0 ? (int)n : 1;
}

/* Judges what is there, without running anything. */
static enum status judge_all(const struct execution *execution, struct outcome *outcome)
{
    for (int k = 0; k < execution->plan->n_runs; k++)
        TRY(outcome_judge(execution, k, &outcome[k]));
    return STATUS_OK;
}

static enum status execute(const struct driver *driver, const struct execution *execution, struct outcome *outcome)
{
    if (driver->report_only)
        return judge_all(execution, outcome);
    TRY(plan_write(execution->plan, execution->out));
    return driver->slurm ? execute_slurm(execution, outcome) : execute_local(execution, outcome);
}

static enum status failures_tell(const struct plan *plan, const struct outcome *outcome)
{
    int failed = 0;
    for (int k = 0; k < plan->n_runs; k++)
        failed += !outcome[k].done;
    if (failed > 0)
        return status_fail(STATUS_INCOMPLETE, "%d of %d runs failed; the report names them", failed, plan->n_runs);
    return STATUS_OK;
}

static enum status run_and_report(const struct driver *driver, const struct study *study, const struct plan *plan,
                                  const char *file, const char *out)
{
    struct outcome *outcome = calloc((size_t)plan->n_runs + 1, sizeof *outcome);
    char *command = NULL, bin[PATH_MAX];
    struct execution execution = {plan, out, bin, driver->jobs, driver->sbatch};
    if (driver->jobs == 0 && !driver->slurm)
        execution.jobs = cores();
    if (!outcome)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    enum status status = command_text(driver, study, file, &command);
    if (status == STATUS_OK && !realpath(driver->bin, bin))
        status = status_fail(STATUS_IO, "%s: there is no such folder", driver->bin);
    if (status == STATUS_OK)
        status = execute(driver, &execution, outcome);
    if (status == STATUS_OK) {
        struct report report = {study, plan, outcome, out, command, driver->pictures};
        status = report_write(&report);
    }
    if (status == STATUS_OK)
        status = failures_tell(plan, outcome);
    free(command);
    outcomes_free(outcome, plan->n_runs);
    return status;
}

static enum status study_run(const struct driver *driver, const struct study *study, const char *file)
{
    struct plan plan;
    char out[PATH_MAX];
    TRY(folder_make(driver, study, out));
    TRY(plan_make(&plan, study));
    enum status status = driver->list_only ? list(&plan, out) : run_and_report(driver, study, &plan, file, out);
    plan_free(&plan);
    return status;
}

enum status driver_run(const struct driver *driver, const char *file)
{
    struct study *study = malloc(sizeof *study);
    if (!study)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    enum status status = study_load(study, file, driver->set, driver->n_set);
    if (status == STATUS_OK) {
        status = study_run(driver, study, file);
        study_free(study);
    }
    free(study);
    return status;
}
