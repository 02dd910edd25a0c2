/* study FILE : a series of runs, their evaluation and their report (docs/studies.md). */
#include <getopt.h>
#include <hdf5.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/signals.h"
#include "studies/driver.h"
#include "studies/study.h"
#include "studies/task.h"

static const char usage[] =
    "usage: ./shakedown study NAME|FILE [--out DIR] [--jobs N] [--set KEY=VALUE]...\n"
    "  Runs a study: those in studies/ by name, others by their file. The same command again goes on where it was.\n"
    "  --out DIR        default: runs/study-NAME\n"
    "  --jobs N         runs at a time; default: all cores\n"
    "  --set KEY=VALUE  of the scene of every run; of the study itself: study.KEY, e.g. study.seeds=3\n"
    "  --executor local|slurm    processes here, or a job array of Slurm\n"
    "  --sbatch OPTIONS of sbatch, e.g. '--partition=long --time=60'\n"
    "  --report         only the report, of what is there\n"
    "  --pictures       also contact networks and particles of the first run of each cell, in the report and as files\n"
    "  --list           only say which runs there are, and whether they are done\n"
    "  --reference      print the keys of a study file\n";

struct options {
    struct driver driver;
    const char *file, *task;
    bool help, reference;
};

static enum status number_read(const char *text, int *number)
{
    char *end;
    long value = strtol(text, &end, 10);
    if (end == text || *end || value < 1 || value > 4096)
        return status_fail(STATUS_USAGE, "--jobs %s: a number from 1 to 4096 is needed", text);
    *number = (int)value;
    return STATUS_OK;
}

static enum status option_take(struct options *options, int c)
{
    struct driver *driver = &options->driver;
    switch (c) {
    case 'o':
        driver->out = optarg;
        return STATUS_OK;
    case 'j':
        return number_read(optarg, &driver->jobs);
    case 's':
        if (driver->n_set == DRIVER_SET_MAX)
            return status_fail(STATUS_USAGE, "more than %d --set", DRIVER_SET_MAX);
        driver->set[driver->n_set++] = optarg;
        return STATUS_OK;
    case 'e':
        driver->slurm = strcmp(optarg, "slurm") == 0;
        if (driver->slurm || strcmp(optarg, "local") == 0)
            return STATUS_OK;
        return status_fail(STATUS_USAGE, "--executor %s: local or slurm", optarg);
    case 'B':
        driver->sbatch = optarg;
        return STATUS_OK;
    case 'b':
        driver->bin = optarg;
        return STATUS_OK;
    case 't':
        options->task = optarg;
        return STATUS_OK;
    default:
        return status_fail(STATUS_USAGE, "see study --help");
    }
}

static enum status options_read(int argc, char **argv, struct options *options)
{
    int report = 0, pictures = 0, list = 0, help = 0, reference = 0, c;
    const struct option known[] = {{"out", required_argument, NULL, 'o'},
                                   {"executor", required_argument, NULL, 'e'},
                                   {"sbatch", required_argument, NULL, 'B'},
                                   {"jobs", required_argument, NULL, 'j'},
                                   {"set", required_argument, NULL, 's'},
                                   {"bin", required_argument, NULL, 'b'},
                                   {"task", required_argument, NULL, 't'},
                                   {"report", no_argument, &report, 1},
                                   {"pictures", no_argument, &pictures, 1},
                                   {"list", no_argument, &list, 1},
                                   {"reference", no_argument, &reference, 1},
                                   {"help", no_argument, &help, 1},
                                   {0}};
    *options = (struct options){.driver = {.sbatch = ""}};
    while ((c = getopt_long(argc, argv, "o:h", known, NULL)) != -1)
        if (c != 0)
            TRY(option_take(options, c));
    options->driver.report_only = report;
    options->driver.pictures = pictures;
    options->driver.list_only = list;
    options->help = help;
    options->reference = reference;
    options->file = optind < argc ? argv[optind] : NULL;
    if (help || reference)
        return STATUS_OK;
    if (argc - optind > 1 || (!options->file && !options->task))
        return status_fail(STATUS_USAGE, "which study? see study --help");
    if (!options->driver.bin)
        return status_fail(STATUS_USAGE, "--bin is missing: start it with ./shakedown study");
    return STATUS_OK;
}

static enum status task_do(const struct options *options)
{
    struct task task;
    if (!options->driver.out)
        return status_fail(STATUS_USAGE, "--task needs --out");
    TRY(task_open(&task, options->driver.out, options->task));
    return task_run(&task, options->driver.bin);
}

int main(int argc, char **argv)
{
    struct options options;
    enum status status = options_read(argc, argv, &options);
    if (status == STATUS_OK && options.help)
        fputs(usage, stdout);
    else if (status == STATUS_OK && options.reference)
        study_print_reference(stdout);
    if (status != STATUS_OK || options.help || options.reference)
        return status_report("study", status);
    (void)H5Eset_auto2(H5E_DEFAULT, NULL, NULL); /* failures are told by our own messages */
    status = signals_install();
    if (status == STATUS_OK)
        status = options.task ? task_do(&options) : driver_run(&options.driver, options.file);
    return status_report("study", status);
}
