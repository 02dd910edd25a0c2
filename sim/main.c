/* sim: the discrete element model as a process. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "common/command_line.h"
#include "common/floating_point.h"
#include "common/scene_file.h"
#include "common/signals.h"
#include "sim/run/explain.h"
#include "sim/run/run.h"

static const char usage[] =
    "sim SCENE [--set key=value]... [--seed N] [--run-id N] [--lcm URL] [--in-process] [--progress]\n"
    "  --in-process  close the wall loops here, without wallctl; records only with --lcm\n"
    "  --progress    print the progress on stderr\n"
    "  --checkpoint FILE  write checkpoints there (scene key checkpoint_interval_s, and at stage ends)\n"
    "  --resume FILE      go on from a checkpoint of this scene and run id\n"
    "  --controller TEXT  record that this program commands the walls in place of wallctl\n"
    "  --check       only read and check the scene and its time steps, with --resume the checkpoint too\n"
    "  --explain     print what the scene models and what it costs\n"
    "  --effective   print the scene with all values that count in it\n"
    "sim --replay LOG SCENE [--run-id N] [--set key=value]... [--seed N]\n"
    "  carries out the wall commands in an event log again and compares the wall states with those in the log, bit for "
    "bit\n"
    "sim --reference prints the scene reference\n";

struct options {
    bool in_process, progress, check, explain, effective, reference;
    const char *replay, *checkpoint, *resume, *controller;
};

static enum status replay_log(const struct scene *scene, const struct command_line *line, const char *path)
{
    struct replay replay;
    TRY(replay_open(&replay, path, line->run_id_given, line->run_id));
    struct run_options run = {.run_id = line->run_id, .replay = &replay};
    enum status status = run_scene(scene, &run);
    replay_close(&replay);
    printf("%" PRId64 " wall states equal, %" PRId64 " commands carried out, %" PRId64
           " messages of other runs, %" PRId64 " malformed\n",
           replay.counts.states, replay.counts.commands, replay.counts.foreign, replay.counts.malformed);
    return status;
}

static enum status act(const struct scene *scene, const struct command_line *line, const struct options *options)
{
    if (options->check)
        return options->resume ? run_check_resume(scene, options->resume) : explain_check(scene);
    if (options->explain)
        return explain_scene(stdout, scene);
    if (options->effective) {
        scene_print(stdout, scene);
        return STATUS_OK;
    }
    TRY(signals_install());
    if (options->replay)
        return replay_log(scene, line, options->replay);
    struct run_options run = {.run_id = line->run_id,
                              .in_process = options->in_process,
                              .progress = options->progress,
                              .checkpoint = options->checkpoint,
                              .resume = options->resume,
                              .controller = options->controller,
                              .url = line->lcm_url};
    return run_scene(scene, &run);
}

static enum status load_and_act(const struct command_line *line, const struct options *options)
{
    if (line->n_positional != 1)
        return status_fail(STATUS_USAGE, "exactly one scene file is needed (see --help)");
    struct scene *scene = calloc(1, sizeof *scene);
    if (!scene)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    enum status status = scene_load(scene, line->positional[0], line->override, line->n_overrides);
    if (options->controller)
        scene->coupling.ahead_steps = 0; /* a program of one's own is asked when its command is wanted */
    if (status == STATUS_OK)
        status = act(scene, line, options);
    scene_free(scene);
    free(scene);
    return status;
}

int main(int argc, char **argv)
{
    struct options options = {0};
    const struct command_line_option own[] = {{"in-process", NULL, &options.in_process},
                                              {"progress", NULL, &options.progress},
                                              {"check", NULL, &options.check},
                                              {"explain", NULL, &options.explain},
                                              {"effective", NULL, &options.effective},
                                              {"reference", NULL, &options.reference},
                                              {"replay", &options.replay, NULL},
                                              {"checkpoint", &options.checkpoint, NULL},
                                              {"resume", &options.resume, NULL},
                                              {"controller", &options.controller, NULL},
                                              {NULL, NULL, NULL}};
    struct command_line line;
    floating_point_flush_subnormals();
    enum status status = command_line_parse(&line, argc, argv, own);
    if (status == STATUS_OK && (line.help || options.reference)) {
        if (line.help)
            fputs(usage, stdout);
        else
            scene_print_reference(stdout);
        return 0;
    }
    if (status == STATUS_OK && line.version) {
        puts(SHAKEDOWN_VERSION);
        return 0;
    }
    if (status == STATUS_OK)
        status = load_and_act(&line, &options);
    return status_report("sim", status);
}
