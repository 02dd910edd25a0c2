#include "bench/trial_run.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "bench/child.h"
#include "common/bus.h"

enum { ARGUMENTS_MAX = 2 * TRIAL_OVERRIDES_MAX + 16, PATH_LENGTH = 1400 };
static const char URL[] = "udpm://239.255.76.67:7667?ttl=0";
static const double PATIENCE_S = 15; /* with the recorder, for the END that sim has sent */
static const double REST_S = 0.5;    /* with what is left of a run that failed */
static const double ALONE_S = 0.5;   /* with sim, once another process has failed: it may say better what is wrong */

/* A program of the run with what all of them are told. */
struct program {
    char path[PATH_LENGTH], log[PATH_LENGTH], run_id[32];
    const char *argv[ARGUMENTS_MAX];
    int n;
    pid_t pid; /* 0: not running */
    int exit_code;
};

static void add(struct program *program, const char *argument)
{
    if (program->n < ARGUMENTS_MAX - 1)
        program->argv[program->n++] = argument;
}

static void prepare(struct program *program, const struct trial *trial, const char *name, long long run_id)
{
    *program = (struct program){.exit_code = -1};
    snprintf(program->path, sizeof program->path, "%s/%s/%s", trial->bin, name, name);
    snprintf(program->log, sizeof program->log, "%s/%s.log", trial->folder, name);
    snprintf(program->run_id, sizeof program->run_id, "%lld", run_id);
    add(program, program->path);
}

static void add_scene(struct program *program, const struct trial *trial)
{
    add(program, trial->scene);
    for (int k = 0; k < trial->n_overrides; k++) {
        add(program, "--set");
        add(program, trial->override[k]);
    }
}

static void add_bus(struct program *program)
{
    add(program, "--run-id");
    add(program, program->run_id);
    add(program, "--lcm");
    add(program, URL);
}

static enum status start(struct program *program)
{
    const struct child child = {.argv = program->argv, .log = program->log};
    return child_start(&child, &program->pid);
}

static bool has_ended(struct program *program)
{
    int state;
    if (program->pid == 0)
        return true;
    if (waitpid(program->pid, &state, WNOHANG) != program->pid)
        return false;
    program->pid = 0;
    program->exit_code = WIFEXITED(state) ? WEXITSTATUS(state) : 128;
    return true;
}

/* Killed after `limit_s`. */
static void wait_for(struct program *program, double limit_s)
{
    const struct timespec pause = {.tv_nsec = 5000000};
    const double start_s = clock_now_s();
    while (!has_ended(program)) {
        if (clock_now_s() - start_s > limit_s && program->pid > 0)
            (void)kill(program->pid, SIGKILL);
        (void)nanosleep(&pause, NULL);
    }
}

static bool has_failed(struct program *program)
{
    return has_ended(program) && program->exit_code != 0;
}

/* Waits for sim, no longer than `limit_s`, and not as long as sim itself would wait for one that is not there: returns
 * which of the others failed before it, NULL if none did. */
static struct program *wait_for_sim(struct program *sim, struct program *recorder, struct program *wallctl,
                                    double limit_s)
{
    const struct timespec pause = {.tv_nsec = 5000000};
    const double start_s = clock_now_s();
    while (!has_ended(sim) && clock_now_s() - start_s <= limit_s) {
        struct program *culprit = has_failed(recorder) ? recorder : has_failed(wallctl) ? wallctl : NULL;
        if (culprit) {
            wait_for(sim, ALONE_S);
            return culprit;
        }
        (void)nanosleep(&pause, NULL);
    }
    wait_for(sim, 0);
    return NULL;
}

/* The last line of a log, without the program's name. */
static void last_line(const struct program *program, char *line, size_t size)
{
    char *text = NULL;
    line[0] = 0;
    if (file_read(program->log, &text) != STATUS_OK)
        return;
    size_t length = strlen(text);
    while (length > 0 && text[length - 1] == '\n')
        text[--length] = 0;
    const char *last = strrchr(text, '\n'), *said = strstr(last ? last : text, "error: ");
    snprintf(line, size, "%s", said ? said + strlen("error: ") : last ? last + 1 : text);
    free(text);
}

static void keep_message(struct trial *trial, const struct program *sim)
{
    trial->exit_code = sim->exit_code;
    trial->message[0] = 0;
    if (sim->exit_code != 0)
        last_line(sim, trial->message, sizeof trial->message);
}

static enum status failed(const struct program *program)
{
    char line[600];
    last_line(program, line, sizeof line);
    return status_fail(STATUS_IO, "%s ended with exit code %d: %s", strrchr(program->path, '/') + 1, program->exit_code,
                       line);
}

static enum status over_bus(struct trial *trial, long long run_id)
{
    struct program sim, wallctl, recorder;
    prepare(&sim, trial, "sim", run_id);
    prepare(&wallctl, trial, "wallctl", run_id);
    prepare(&recorder, trial, "recorder", run_id);
    add(&recorder, "--out");
    add(&recorder, trial->folder);
    add_scene(&wallctl, trial);
    add_scene(&sim, trial);
    add_bus(&recorder);
    add_bus(&wallctl);
    add_bus(&sim);
    enum status status = start(&wallctl);
    if (status == STATUS_OK)
        status = start(&recorder);
    if (status == STATUS_OK)
        status = start(&sim);
    const struct program *culprit = wait_for_sim(&sim, &recorder, &wallctl, trial->limit_s);
    wait_for(&wallctl, REST_S);
    wait_for(&recorder, sim.exit_code == 0 ? PATIENCE_S : REST_S);
    TRY(status);
    keep_message(trial, &sim);
    if (!culprit && sim.exit_code == 0 && recorder.exit_code != 0)
        culprit = &recorder;
    return culprit ? failed(culprit) : STATUS_OK;
}

/* sim writes a log, the recorder makes run.h5 of it. */
static enum status in_process(struct trial *trial, long long run_id)
{
    char log[PATH_LENGTH], url[PATH_LENGTH + 32];
    struct program sim, recorder;
    snprintf(log, sizeof log, "%s/run.lcm", trial->folder);
    snprintf(url, sizeof url, "file://%s?mode=w", log);
    prepare(&sim, trial, "sim", run_id);
    add_scene(&sim, trial);
    add(&sim, "--in-process");
    add(&sim, "--run-id");
    add(&sim, sim.run_id);
    add(&sim, "--lcm");
    add(&sim, url);
    TRY(start(&sim));
    wait_for(&sim, trial->limit_s);
    keep_message(trial, &sim);
    prepare(&recorder, trial, "recorder", run_id);
    add(&recorder, "--from");
    add(&recorder, log);
    add(&recorder, "--out");
    add(&recorder, trial->folder);
    TRY(start(&recorder));
    wait_for(&recorder, trial->limit_s);
    (void)remove(log);
    return trial->exit_code == 0 && recorder.exit_code != 0 ? failed(&recorder) : STATUS_OK;
}

enum status trial_run(struct trial *trial)
{
    static long long run_id = 1;
    char file[PATH_LENGTH];
    TRY(folder_make(trial->folder));
    static const char *const old[] = {"run.h5", "run.lcm", "run.xdmf"};
    for (size_t k = 0; k < sizeof old / sizeof *old; k++) {
        snprintf(file, sizeof file, "%s/%s", trial->folder, old[k]);
        (void)remove(file);
    }
    run_id++;
    return trial->in_process ? in_process(trial, run_id) : over_bus(trial, run_id);
}
