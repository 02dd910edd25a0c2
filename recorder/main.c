/* recorder: writes what a run says to run.h5, live from the bus or from an LCM event log. */
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "common/command_line.h"
#include "common/signals.h"
#include "recorder/bus_recording.h"
#include "recorder/log_conversion.h"
#include "recorder/verify.h"

static const char USAGE[] =
    "usage: recorder --run-id N --out DIR [--lcm URL] [--timeout SECONDS]   records a run from the bus\n"
    "       recorder --from run.lcm --out DIR [--replace]                   makes run.h5 from a log\n"
    "       recorder --verify DIR    looks through the log and run.h5 of a run: 0 complete, 9 incomplete, 6 damaged\n"
    "       recorder --repair DIR    makes DIR/run.h5 from DIR/run.lcm again\n"
    "  --resume   goes on with DIR/run.lcm of a run that goes on from a checkpoint\n"
    "  --replace  DIR/run.h5 may be there already\n"
    "Writes DIR/run.lcm (the log), DIR/run.h5 (H5MD 1.1) and DIR/run.xdmf. The log of a run that went well is "
    "removed,\n"
    "unless its scene says record.event_log.\n"
    "Ends when the run is complete, on SIGINT or SIGTERM (10 s of patience for END, none after a second signal), "
    "after\n"
    "SECONDS (default: no limit) without a message of the run, or when who started it has ended and nothing of the "
    "run\n"
    "was heard for 60 s. Exit code 0: complete; 9: messages are missing.\n";

struct arguments {
    struct command_line line;
    const char *out, *from, *timeout, *verify, *repair;
    bool resume, replace;
    double timeout_s;
};

static enum status timeout_read(struct arguments *arguments)
{
    char *end = NULL;
    arguments->timeout_s = INFINITY;
    if (!arguments->timeout)
        return STATUS_OK;
    arguments->timeout_s = strtod(arguments->timeout, &end);
    if (end == arguments->timeout || *end != '\0' || !(arguments->timeout_s > 0.0))
        return status_fail(STATUS_USAGE, "--timeout wants a positive number of seconds, not \"%s\"",
                           arguments->timeout);
    return STATUS_OK;
}

static enum status arguments_read(struct arguments *arguments, int argc, char **argv)
{
    const struct command_line_option own[] = {
        {"out", &arguments->out, NULL},         {"from", &arguments->from, NULL},
        {"timeout", &arguments->timeout, NULL}, {"verify", &arguments->verify, NULL},
        {"repair", &arguments->repair, NULL},   {"resume", NULL, &arguments->resume},
        {"replace", NULL, &arguments->replace}, {NULL, NULL, NULL}};
    struct command_line *line = &arguments->line;
    TRY(command_line_parse(line, argc, argv, own));
    if (line->help || line->version)
        return STATUS_OK;
    if (line->n_positional > 0 || line->n_overrides > 0)
        return status_fail(STATUS_USAGE, "the recorder takes no scene: RUN_INFO carries it (see --help)");
    if (arguments->verify || arguments->repair)
        return STATUS_OK;
    if (!arguments->out)
        return status_fail(STATUS_USAGE, "--out DIR is missing (see --help)");
    if (!arguments->from && !line->run_id_given)
        return status_fail(STATUS_USAGE, "--run-id N or --from LOG is missing (see --help)");
    if (arguments->resume && arguments->from)
        return status_fail(STATUS_USAGE,
                           "--resume is for the bus: a log that was gone on with is converted as a whole");
    return timeout_read(arguments);
}

static void report_drops(const struct record_receiver_drops *drops)
{
    if (drops->foreign + drops->malformed + drops->oversized > 0)
        fprintf(stderr, "recorder: warning: dropped %lld messages of other runs, %lld malformed, %lld oversized\n",
                (long long)drops->foreign, (long long)drops->malformed, (long long)drops->oversized);
}

static enum status run(const struct arguments *arguments, struct record_receiver *recording)
{
    const struct bus_recording_options options = {.lcm_url = arguments->line.lcm_url,
                                                  .timeout_s = arguments->timeout_s};
    return arguments->from ? convert_log(recording, arguments->from) : bus_recording_record(recording, &options);
}

static enum status record(const struct arguments *arguments)
{
    const struct record_receiver_options options = {.directory = arguments->out,
                                                    .any_run = !arguments->line.run_id_given,
                                                    .run_id = arguments->line.run_id,
                                                    .from_log = arguments->from != NULL,
                                                    .replace = arguments->replace && arguments->from,
                                                    .resume = arguments->resume,
                                                    .remake = convert_into};
    struct record_receiver *recording;
    enum status status = record_receiver_create(&recording, &options);
    if (status == STATUS_OK)
        status = run(arguments, recording);
    if (status == STATUS_OK) {
        char summary[1024];
        record_receiver_summary(recording, summary, sizeof summary);
        printf("recorder: %s\n", summary);
    }
    if (recording)
        report_drops(record_receiver_drops(recording));
    record_receiver_free(recording);
    return status;
}

static enum status repair(const char *directory)
{
    char log[PATH_MAX];
    struct run_counts counts = {0};
    if (snprintf(log, sizeof log, "%s/run.lcm", directory) >= (int)sizeof log)
        return status_fail(STATUS_USAGE, "the path %s is too long", directory);
    if (access(log, F_OK) != 0 && errno == ENOENT)
        return status_fail(STATUS_IO,
                           "no run.lcm in %s: run.h5 is made from that log, which a run that ended well "
                           "does not keep (./shakedown verify says whether run.h5 is whole)",
                           directory);
    enum status status = convert_into(log, directory, &counts);
    if (status != STATUS_OK && status != STATUS_INCOMPLETE)
        return status;
    printf("recorder: %s/run.h5 made from the log: %lld samples, %lld frames\n", directory, (long long)counts.samples,
           (long long)counts.frames);
    if (status == STATUS_INCOMPLETE)
        printf("recorder: the log stops before its run did; go on with: ./shakedown run --resume %s\n", directory);
    return status;
}

static enum status work(const struct arguments *arguments)
{
    if (arguments->verify)
        return verify_run(arguments->verify, stdout);
    return arguments->repair ? repair(arguments->repair) : record(arguments);
}

int main(int argc, char **argv)
{
    struct arguments arguments = {0};
    /* A file-size limit shall be an error like a full disk, not the end of the process. */
    (void)signal(SIGXFSZ, SIG_IGN);
    enum status status = signals_install();
    if (status == STATUS_OK)
        status = arguments_read(&arguments, argc, argv);
    if (status == STATUS_OK && arguments.line.help) {
        fputs(USAGE, stdout);
        return 0;
    }
    if (status == STATUS_OK && arguments.line.version) {
        puts("recorder " SHAKEDOWN_VERSION);
        return 0;
    }
    if (status == STATUS_OK)
        status = work(&arguments);
    return status_report("recorder", status);
}
