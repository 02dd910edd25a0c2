/* launcher: starts the processes of a run, watches over them, ends them. The script `shakedown` prepares the run's
 * folder and becomes this program. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/command_line.h"
#include "launcher/child.h"
#include "launcher/launch.h"
#include "launcher/restarts.h"
#include "launcher/scene_copy.h"

static const char usage[] =
    "usage: launcher --bin BUILD DIR [--resume] [--keep-going] [--restarts N]\n"
    "       launcher --prepare SCENE DIR [WORD]...\n"
    "Runs what the folder DIR says (scene.cfg, overrides, run-id, lcm-url, controller) with the programs of BUILD.\n"
    "  --resume      goes on from DIR/checkpoint.h5\n"
    "  --keep-going  a simulator that crashes goes on from its checkpoint\n"
    "  --restarts N  how often in an hour a process that dies is started again (default 5)\n"
    "  --prepare     writes DIR/scene.cfg and DIR/overrides\n"
    "SHAKEDOWN_STOP_WAIT_S: patience with a simulator that was asked to stop, in seconds (default 8)\n";

static enum status number_read(const char *name, const char *text, double lowest, double highest, double *number)
{
    char *end;
    if (!text)
        return STATUS_OK;
    *number = strtod(text, &end);
    if (end == text || *end || !(*number >= lowest && *number <= highest))
        return status_fail(STATUS_USAGE, "%s wants a number from %g to %g, not \"%s\"", name, lowest, highest, text);
    return STATUS_OK;
}

static enum status run(int argc, char **argv, int *exit_code)
{
    struct launch launch = {0};
    struct command_line line;
    const char *restarts_text = NULL;
    double restarts = 5, stop_wait_s = 8;
    const struct command_line_option own[] = {{"bin", &launch.bin, NULL},
                                              {"resume", NULL, &launch.resume},
                                              {"keep-going", NULL, &launch.keep_going},
                                              {"restarts", &restarts_text, NULL},
                                              {NULL, NULL, NULL}};
    TRY(command_line_parse(&line, argc, argv, own));
    if (line.help || line.version) {
        fputs(line.help ? usage : "launcher " SHAKEDOWN_VERSION "\n", stdout);
        return STATUS_OK;
    }
    if (line.n_positional != 1 || !launch.bin)
        return status_fail(STATUS_USAGE, "a folder and --bin are needed (see --help)");
    TRY(number_read("--restarts", restarts_text, 0, RESTARTS_MAX, &restarts));
    TRY(number_read("SHAKEDOWN_STOP_WAIT_S", getenv("SHAKEDOWN_STOP_WAIT_S"), 0.1, 3600, &stop_wait_s));
    launch.restarts = (int)restarts;
    enum status status = run_folder_read(&launch.folder, line.positional[0]);
    if (status == STATUS_OK)
        *exit_code = launch_run(&launch, stop_wait_s);
    run_folder_free(&launch.folder);
    return status;
}

int main(int argc, char **argv)
{
    int exit_code = 0;
    if (argc > 3 && strcmp(argv[1], "--exec") == 0)
        return status_report("shakedown", child_become((pid_t)atoi(argv[2]), argv + 3));
    if (argc > 3 && strcmp(argv[1], "--prepare") == 0)
        return status_report("shakedown", scene_copy(argv[2], argv[3], argv + 4));
    enum status status = run(argc, argv, &exit_code);
    return status == STATUS_OK ? exit_code : status_report("shakedown", status);
}
