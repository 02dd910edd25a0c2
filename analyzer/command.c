#include "analyzer/command.h"

#include <getopt.h>
#include <stddef.h>
#include <string.h>

const char command_usage[] =
    "usage: analyzer [--stage NAME|all] [--set analysis.KEY=VALUE]... [--out DIR] [--no-plots] [--series KEY] DIR...\n"
    "  Reads DIR/run.h5 and writes into DIR: analysis.json, curves.csv, plots (.gp, .svg, .png); where the test has "
    "them,\n"
    "  cycles.csv or stiffness.csv. Prints a table. Several DIR: an ensemble as well, and the tangent of their Mohr "
    "circles.\n"
    "  --stage NAME evaluates this stage instead of analysis.stage of the scene; \"all\": every stage, with a table "
    "and\n"
    "               analysis-NAME.json each; curves.csv then holds all of them, and there are plots of the whole path\n"
    "  --set analysis.KEY=VALUE  windows and choices of the evaluation other than the scene's "
    "(docs/scene-reference.md)\n"
    "  --out DIR    where ensemble.json goes (made if missing); without it the ensemble is only printed\n"
    "  --series KEY the runs differ in this key of the scene, e.g. material.mu_s: a table over it instead of the\n"
    "               ensemble, and in --out also series.csv and a plot; runs of one name are one curve\n"
    "  --no-plots   do not run gnuplot for the single runs\n";

static enum status setting_add(struct command *command, const char *text)
{
    if (strncmp(text, "analysis.", 9) != 0 || !strchr(text, '='))
        return status_fail(STATUS_USAGE, "--set %s: only analysis.KEY=VALUE; all else was simulated as it is", text);
    if (command->n_settings == COMMAND_SETTINGS_MAX)
        return status_fail(STATUS_USAGE, "more than %d settings", (int)COMMAND_SETTINGS_MAX);
    command->setting[command->n_settings++] = text;
    return STATUS_OK;
}

enum status command_read(struct command *command, int argc, char **argv)
{
    static const struct option known[] = {{"out", required_argument, NULL, 'o'},
                                          {"series", required_argument, NULL, 's'},
                                          {"no-plots", no_argument, NULL, 'n'},
                                          {"stage", required_argument, NULL, 'g'},
                                          {"set", required_argument, NULL, 'e'},
                                          {"help", no_argument, NULL, 'h'},
                                          {0}};
    int c;
    *command = (struct command){.plots = true};
    while ((c = getopt_long(argc, argv, "o:h", known, NULL)) != -1) {
        if (c == 'o')
            command->out = optarg;
        else if (c == 's')
            command->series = optarg;
        else if (c == 'g')
            command->stage = optarg;
        else if (c == 'n')
            command->plots = false;
        else if (c == 'h')
            command->help = true;
        else if (c == 'e')
            TRY(setting_add(command, optarg));
        else
            return status_fail(STATUS_USAGE, "see analyzer --help");
    }
    command->first = optind;
    if (!command->help && optind == argc)
        return status_fail(STATUS_USAGE, "no directory given; see analyzer --help");
    return STATUS_OK;
}
