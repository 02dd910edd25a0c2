/* analyzer [--out DIR] [--no-plots] [--series KEY] DIR... : parameters, curves and plots from DIR/run.h5, and an
 * ensemble over several. */
#include <errno.h>
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "analyzer/analysis_files.h"
#include "analyzer/ensemble.h"
#include "analyzer/plots.h"
#include "analyzer/report_table.h"
#include "analyzer/series.h"

static const char usage[] =
    "usage: analyzer [--out DIR] [--no-plots] [--series KEY] DIR...\n"
    "  Reads DIR/run.h5 and writes into DIR: analysis.json, curves.csv, plots (.gp, .svg, .png);\n"
    "  of cyclic tests also cycles.csv. Prints a table. Several DIR: an ensemble as well.\n"
    "  --out DIR    where ensemble.json goes (made if missing); without it the ensemble is only printed\n"
    "  --series KEY the runs differ in this key of the scene, e.g. material.mu_s: a table over it instead of the\n"
    "               ensemble, and in --out also series.csv and a plot; runs of one name are one curve\n"
    "  --no-plots   do not run gnuplot for the single runs\n";

struct options {
    const char *out;    /* NULL: no ensemble.json */
    const char *series; /* key of the scene; NULL: an ensemble */
    bool plots;
};

static enum status options_read(int argc, char **argv, struct options *options, bool *help)
{
    static const struct option known[] = {{"out", required_argument, NULL, 'o'},
                                          {"series", required_argument, NULL, 's'},
                                          {"no-plots", no_argument, NULL, 'n'},
                                          {"help", no_argument, NULL, 'h'},
                                          {0}};
    int c;
    *options = (struct options){NULL, NULL, true};
    *help = false;
    while ((c = getopt_long(argc, argv, "o:h", known, NULL)) != -1) {
        if (c == 'o')
            options->out = optarg;
        else if (c == 's')
            options->series = optarg;
        else if (c == 'n')
            options->plots = false;
        else if (c == 'h')
            *help = true;
        else
            return status_fail(STATUS_USAGE, "see analyzer --help");
    }
    if (!*help && optind == argc)
        return status_fail(STATUS_USAGE, "no directory given; see analyzer --help");
    return STATUS_OK;
}

/* Analyses one run, writes its files, prints its table, adds it to the ensemble. The numbers come before the plots, so
 * that they are there even if gnuplot is not. */
static enum status report(const struct analysis *analysis, const struct options *options, struct ensemble *ensemble)
{
    int n_plots = 0;
    double key_value = 0;
    if (options->series)
        TRY(series_key_value(analysis->run.scene, options->series, &key_value));
    TRY(analysis_write(analysis));
    report_table_print(stdout, analysis);
    TRY(ensemble_add(ensemble, analysis));
    ensemble->member[ensemble->n - 1].key_value = key_value;
    if (options->plots)
        TRY(plots_write(analysis, &n_plots));
    printf("results: %s/analysis.json, curves.csv%s, %d plots (.svg, .png)\n\n", analysis->directory,
           analysis->curves.controls.kind == TEST_CYCLIC ? ", cycles.csv" : "", n_plots);
    const struct judgement *judgement = &analysis->judgement;
    if (judgement->verdict == WORTH_SOUND)
        return STATUS_OK;
    return status_fail(judgement->status, "%s: the result %s (%s)", analysis->directory,
                       judgement->verdict == WORTH_FAILED ? "failed" : "is doubtful", judgement->headline);
}

static enum status analyse(const char *directory, const struct options *options, struct ensemble *ensemble)
{
    struct analysis *analysis = malloc(sizeof *analysis);
    if (!analysis)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    enum status status = analysis_make(analysis, directory);
    if (status == STATUS_OK) {
        status = report(analysis, options, ensemble);
        analysis_free(analysis);
    }
    free(analysis);
    return status;
}

static enum status series_report(struct ensemble *ensemble, const struct options *options)
{
    int curves;
    series_sort(ensemble);
    series_print(stdout, ensemble, options->series);
    if (!options->out)
        return STATUS_OK;
    TRY(series_write(ensemble, options->series, options->out, &curves));
    if (curves > 0)
        TRY(plots_run(options->out, "series"));
    printf("results: %s/series.csv%s\n", options->out, curves > 0 ? ", series.svg" : "");
    return STATUS_OK;
}

static enum status ensemble_report(struct ensemble *ensemble, const struct options *options)
{
    char path[2048];
    if (options->out && mkdir(options->out, 0777) != 0 && errno != EEXIST)
        return status_fail(STATUS_IO, "%s: %s", options->out, strerror(errno));
    if (options->series)
        return series_report(ensemble, options);
    TRY(ensemble_print(stdout, ensemble));
    if (!options->out)
        return STATUS_OK;
    if (snprintf(path, sizeof path, "%s/ensemble.json", options->out) >= (int)sizeof path)
        return status_fail(STATUS_USAGE, "%.60s...: the path is too long", options->out);
    TRY(ensemble_write(ensemble, path));
    printf("results: %s\n", path);
    return STATUS_OK;
}

int main(int argc, char **argv)
{
    struct options options;
    struct ensemble ensemble = {0};
    bool help;
    enum status status = options_read(argc, argv, &options, &help);
    int code = status_report("analyzer", status);
    if (status != STATUS_OK || help) {
        fputs(help ? usage : "", stdout);
        return code;
    }
    /* one bad run does not cost the others; the exit code is that of the first failure */
    for (int k = optind; k < argc; k++) {
        int failed = status_report("analyzer", analyse(argv[k], &options, &ensemble));
        code = code ? code : failed;
    }
    if ((argc - optind > 1 || options.out) && ensemble.n > 0) {
        int failed = status_report("analyzer", ensemble_report(&ensemble, &options));
        code = code ? code : failed;
    }
    ensemble_free(&ensemble);
    return code;
}
