/* wallctl: closes the strain and stress loops of the walls and owns the protocol. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "common/bus.h"
#include "common/command_line.h"
#include "common/floating_point.h"
#include "common/scene_file.h"
#include "common/signals.h"
#include "wallctl/controller.h"
#include "wallctl/replay.h"

static const char usage[] =
    "usage: wallctl SCENE --run-id N [--lcm URL] [--set path=value]... [--seed N]\n"
    "       wallctl --replay LOG SCENE [--run-id N] [--set path=value]... [--seed N]\n"
    "\n"
    "Answers the wall states of run N with wall commands until the run ends. With --replay: computes the commands to\n"
    "the wall states in an event log again and compares them, bit for bit, with those in the log.\n"
    "\n"
    "  --lcm URL          LCM provider; default $LCM_DEFAULT_URL, else udpm://239.255.76.67:7667?ttl=0\n"
    "  --set path=value   overrides a key of the scene, e.g. --set stages.0.duration_s=0.1\n"
    "  --seed N           the same as --set seed=N\n"
    "  --version, --help\n";

static enum status control(const struct command_line *line, const struct scene *scene)
{
    struct bus bus;
    struct controller_counts counts;
    if (!line->run_id_given)
        return status_fail(STATUS_USAGE, "--run-id is missing");
    TRY(signals_install());
    TRY(bus_open_direct(&bus, line->lcm_url));
    enum status status = controller_run(&bus, scene, line->run_id, &counts);
    bus_close(&bus);
    if (counts.foreign + counts.malformed + counts.rejected > 0)
        fprintf(stderr,
                "wallctl: %" PRId64 " states answered; %" PRId64 " messages of other runs, %" PRId64
                " malformed, %" PRId64 " states refused\n",
                counts.answered, counts.foreign, counts.malformed, counts.rejected);
    return status;
}

static enum status replay(const struct command_line *line, const struct scene *scene, const char *log_path)
{
    char url[4096];
    struct bus bus;
    struct replay_counts counts;
    if (snprintf(url, sizeof url, "file://%s", log_path) >= (int)sizeof url)
        return status_fail(STATUS_USAGE, "the path of the log is too long");
    TRY(bus_open(&bus, url));
    enum status status = replay_run(&bus, scene, line->run_id_given, line->run_id, &counts);
    bus_close(&bus);
    printf("%" PRId64 " wall states, %" PRId64 " commands equal, %" PRId64 " without their state, %" PRId64
           " messages of other runs, %" PRId64 " malformed\n",
           counts.states, counts.commands, counts.unpaired, counts.foreign, counts.malformed);
    return status;
}

static enum status run(int argc, char **argv, struct scene *scene)
{
    struct command_line line;
    const char *log_path = NULL;
    const struct command_line_option own[] = {{"replay", &log_path, NULL}, {NULL, NULL, NULL}};
    TRY(command_line_parse(&line, argc, argv, own));
    if (line.help || line.version) {
        fputs(line.help ? usage : "wallctl " SHAKEDOWN_VERSION "\n", stdout);
        return STATUS_OK;
    }
    if (line.n_positional != 1)
        return status_fail(STATUS_USAGE, "give one scene file\n%s", usage);
    TRY(scene_load(scene, line.positional[0], line.override, line.n_overrides));
    enum status status = log_path ? replay(&line, scene, log_path) : control(&line, scene);
    scene_free(scene);
    return status;
}

int main(int argc, char **argv)
{
    struct scene *scene = calloc(1, sizeof *scene); /* too large for the stack */
    floating_point_flush_subnormals();
    enum status status = scene ? run(argc, argv, scene) : status_fail(STATUS_NO_MEMORY, "no memory for the scene");
    free(scene);
    return status_report("wallctl", status);
}
