/* bench_odd_scenes SIM FOLDER COUNT SEED LIMIT_S: runs random scenes and looks at how they end. Those that do not end
 * as they should stay in FOLDER. */
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bench/child.h"
#include "bench/odd_scene.h"

enum ending { SOUND, DOUBTFUL, REFUSED, STOPPED, WRONG, ENDINGS };

struct run {
    const char *sim, *limit_s;
    char scene[512], log[512];
};

/* The figures of all "ended" notes in the log of a run that calls itself sound. */
static const char *sound_is_not(const char *log)
{
    for (const char *at = strstr(log, "largest overlap "); at; at = strstr(at + 1, "largest overlap ")) {
        const char *residual = strstr(at, "ledger residual ");
        if (!(atof(at + strlen("largest overlap ")) <= 0.3))
            return "sound with an overlap above 30 %";
        const double ratio = residual ? atof(residual + strlen("ledger residual ")) : 0;
        if (!(ratio <= 0.0105 && ratio >= -0.0105)) /* printed with two digits */
            return "sound with a residual above 1 %";
    }
    return strstr(log, "verdict: sound") ? NULL : "ended well without a verdict";
}

/* Whether the log has a line of that start with something to say. */
static bool says(const char *log, const char *start)
{
    const char *line = strstr(log, start);
    return line && strlen(line) > strlen(start) + 20;
}

static enum ending judge(const char *log, int code, const char **why)
{
    *why = NULL;
    switch (code) {
    case STATUS_OK:
        *why = sound_is_not(log);
        return *why ? WRONG : SOUND;
    case STATUS_DOUBTFUL:
        *why = says(log, "verdict: doubtful") ? NULL : "doubtful without a reason";
        return *why ? WRONG : DOUBTFUL;
    case STATUS_CONFIG:
        *why = says(log, "sim: error: ") ? NULL : "refused without a reason";
        return *why ? WRONG : REFUSED;
    case STATUS_UNSTABLE:
    case STATUS_LIMIT:
        *why = says(log, "sim: error: ") ? NULL : "stopped without a reason";
        return *why ? WRONG : STOPPED;
    case 124:
        *why = "did not end in time";
        return WRONG;
    default:
        *why = "another exit code, or a crash";
        return WRONG;
    }
}

static enum status scene_file(const char *path, uint64_t seed, int index)
{
    FILE *file = fopen(path, "w");
    if (!file)
        return status_fail(STATUS_IO, "%s cannot be written", path);
    odd_scene_write(file, seed, index);
    return fclose(file) == 0 ? STATUS_OK : status_fail(STATUS_IO, "%s cannot be written", path);
}

static enum status try_one(const struct run *run, int *count)
{
    const char *argv[] = {"timeout", run->limit_s, run->sim, run->scene, "--in-process", "--progress", NULL};
    struct child child = {.argv = argv, .log = run->log};
    char *log;
    const char *why;
    const enum status ran = child_run(&child); /* a failure is what is looked at */
    if (ran != STATUS_OK && child.exit_code == 0)
        return ran; /* it was not started */
    TRY(file_read(run->log, &log));
    const enum ending ending = judge(log, child.exit_code, &why);
    count[ending]++;
    if (ending == WRONG) {
        const char *last = strrchr(log, '\n');
        while (last && last > log && last[-1] != '\n')
            last--;
        printf("%s: %s (exit code %d): %s", run->scene, why, child.exit_code, last ? last : log);
    } else if (ending != DOUBTFUL && ending != STOPPED) {
        (void)unlink(run->scene);
        (void)unlink(run->log);
    }
    free(log);
    return STATUS_OK;
}

static enum status all(const char *const *argv, int *count)
{
    struct run run = {.sim = argv[1], .limit_s = argv[5]};
    const uint64_t seed = strtoull(argv[4], NULL, 10);
    TRY(folder_make(argv[2]));
    for (int k = 0; k < atoi(argv[3]); k++) {
        snprintf(run.scene, sizeof run.scene, "%s/odd-%d.cfg", argv[2], k);
        snprintf(run.log, sizeof run.log, "%s/odd-%d.log", argv[2], k);
        TRY(scene_file(run.scene, seed, k));
        TRY(try_one(&run, count));
    }
    return STATUS_OK;
}

int main(int argc, char **argv)
{
    int count[ENDINGS] = {0};
    if (argc != 6)
        return status_report("bench_odd_scenes", status_fail(STATUS_USAGE, "SIM FOLDER COUNT SEED LIMIT_S"));
    const enum status status = all((const char *const *)argv, count);
    printf("sound %d, doubtful %d, refused %d, stopped %d, wrong %d\n", count[SOUND], count[DOUBTFUL], count[REFUSED],
           count[STOPPED], count[WRONG]);
    if (status != STATUS_OK)
        return status_report("bench_odd_scenes", status);
    return count[WRONG] > 0;
}
