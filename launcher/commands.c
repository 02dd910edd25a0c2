#include "launcher/commands.h"

#include <glib.h>
#include <stdarg.h>

bool launch_in_process(const struct launch *launch)
{
    return launch->folder.url == NULL;
}

const char *role_name(const struct launch *launch, enum role role)
{
    static const char *const names[ROLES] = {"sim", "wallctl", "recorder", "watch", "recorder", "analyzer"};
    return role == ROLE_CONTROLLER && launch->folder.controller ? "controller" : names[role];
}

/* Words up to NULL. */
static void add(GPtrArray *words, ...)
{
    va_list list;
    va_start(list, words);
    for (const char *word = va_arg(list, const char *); word; word = va_arg(list, const char *))
        g_ptr_array_add(words, g_strdup(word));
    va_end(list);
}

static void add_all(GPtrArray *words, char *const *more)
{
    for (; *more; more++)
        add(words, *more, NULL);
}

static void add_program(GPtrArray *words, const struct launch *launch, const char *program)
{
    g_ptr_array_add(words, g_build_filename(launch->bin, program, NULL));
}

static void add_scene(GPtrArray *words, const struct launch *launch)
{
    add(words, launch->folder.scene, NULL);
    add_all(words, launch->folder.overrides);
    add(words, "--run-id", launch->folder.run_id, NULL);
}

/* In one process it works in the run's folder: an LCM URL cannot hold every path. */
static void sim_command(GPtrArray *words, const struct launch *launch, bool resume)
{
    const bool in_process = launch_in_process(launch);
    char *checkpoint = run_folder_file(&launch->folder, "checkpoint.h5");
    add_program(words, launch, "sim/sim");
    add_scene(words, launch);
    if (in_process)
        add(words, "--in-process", "--progress", "--lcm", resume ? "file://run.lcm?mode=a" : "file://run.lcm?mode=w",
            NULL);
    else
        add(words, "--lcm", launch->folder.url, NULL);
    if (launch->folder.controller) {
        char *text = g_strjoinv(" ", launch->folder.controller);
        add(words, "--controller", text, NULL);
        g_free(text);
    }
    add(words, "--checkpoint", checkpoint, NULL);
    if (resume)
        add(words, "--resume", checkpoint, NULL);
    g_free(checkpoint);
}

static void controller_command(GPtrArray *words, const struct launch *launch)
{
    if (launch->folder.controller)
        add_all(words, launch->folder.controller);
    else
        add_program(words, launch, "wallctl/wallctl");
    add_scene(words, launch);
    add(words, "--lcm", launch->folder.url, NULL);
}

static void recorder_command(GPtrArray *words, const struct launch *launch, bool resume)
{
    add_program(words, launch, "recorder/recorder");
    add(words, "--run-id", launch->folder.run_id, "--out", launch->folder.path, "--lcm", launch->folder.url, NULL);
    if (resume)
        add(words, "--resume", NULL);
}

char **role_command(const struct launch *launch, enum role role, bool resume)
{
    GPtrArray *words = g_ptr_array_new();
    switch (role) {
    case ROLE_SIM:
        sim_command(words, launch, resume);
        break;
    case ROLE_CONTROLLER:
        controller_command(words, launch);
        break;
    case ROLE_RECORDER:
        recorder_command(words, launch, resume);
        break;
    case ROLE_WATCH:
        add_program(words, launch, "common/watch/shakedown-watch");
        add(words, "--run-id", launch->folder.run_id, "--lcm", launch->folder.url, NULL);
        break;
    case ROLE_CONVERTER: /* in the run's folder, for the same reason */
        add_program(words, launch, "recorder/recorder");
        add(words, "--from", "run.lcm", "--out", ".", "--replace", NULL);
        break;
    default:
        add_program(words, launch, "analyzer/analyzer");
        add(words, launch->folder.path, NULL);
        break;
    }
    g_ptr_array_add(words, NULL);
    return (char **)g_ptr_array_free(words, FALSE);
}
