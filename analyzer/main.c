/* analyzer [OPTIONS] DIR... : parameters, curves and plots from DIR/run.h5, and an
 * ensemble over several. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "analyzer/analysis_files.h"
#include "analyzer/command.h"
#include "analyzer/ensemble.h"
#include "analyzer/mohr.h"
#include "analyzer/plots.h"
#include "analyzer/report_table.h"
#include "analyzer/series.h"

/* Analyses one run, writes its files, prints its table, adds it to the ensemble. The numbers come before the plots, so
 * that they are there even if gnuplot is not. */
static enum status report(const struct analysis *analysis, const struct command *options, struct ensemble *ensemble)
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

/* The other stages of a run: a table and analysis-NAME.json each; curves.csv of all, plots of the whole path. */
static enum status report_stages(const struct analysis *main_stage, const struct command *options)
{
    const struct scene *scene = main_stage->run.scene;
    struct analysis *analysis = malloc(sizeof *analysis);
    enum status status = analysis ? STATUS_OK : status_fail(STATUS_NO_MEMORY, "out of memory");
    for (int k = 0; status == STATUS_OK && k < scene->n_stages; k++) {
        const struct analysis_choice choice = {scene->stage[k].name, options->setting, options->n_settings};
        status = analysis_make(analysis, main_stage->directory, &choice);
        if (status != STATUS_OK)
            break;
        if (k != main_stage->curves.stage)
            report_table_print(stdout, analysis);
        status = analysis_write_stage(analysis);
        analysis_free(analysis);
    }
    free(analysis);
    TRY(status);
    TRY(analysis_write_all_curves(main_stage));
    return options->plots ? plots_write_path(main_stage) : STATUS_OK;
}

static enum status analyse(const char *directory, const struct command *options, struct ensemble *ensemble)
{
    const bool all = options->stage && strcmp(options->stage, "all") == 0;
    const struct analysis_choice choice = {all ? NULL : options->stage, options->setting, options->n_settings};
    struct analysis *analysis = malloc(sizeof *analysis);
    if (!analysis)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    enum status status = analysis_make(analysis, directory, &choice);
    if (status == STATUS_OK) {
        status = report(analysis, options, ensemble);
        enum status others = all ? report_stages(analysis, options) : STATUS_OK; /* after its own plots */
        status = others == STATUS_OK ? status : others;
        analysis_free(analysis);
    }
    free(analysis);
    return status;
}

static enum status series_report(struct ensemble *ensemble, const struct command *options)
{
    int curves;
    bool liquefied;
    TRY(series_check(ensemble, options->series));
    series_sort(ensemble);
    series_print(stdout, ensemble, options->series);
    if (!options->out)
        return STATUS_OK;
    TRY(series_write(ensemble, options->series, options->out, &curves));
    if (curves > 0)
        TRY(plots_run(options->out, "series"));
    TRY(series_liquefaction_write(ensemble, options->out, &liquefied));
    if (liquefied)
        TRY(plots_run(options->out, "liquefaction"));
    printf("results: %s/series.csv%s%s\n", options->out, curves > 0 ? ", series.svg" : "",
           liquefied ? ", liquefaction.svg" : "");
    return STATUS_OK;
}

static enum status ensemble_report(struct ensemble *ensemble, const struct command *options)
{
    char path[2048];
    if (options->out && mkdir(options->out, 0777) != 0 && errno != EEXIST)
        return status_fail(STATUS_IO, "%s: %s", options->out, strerror(errno));
    if (options->series)
        return series_report(ensemble, options);
    bool tangent;
    TRY(ensemble_print(stdout, ensemble));
    TRY(mohr_report(stdout, ensemble, options->out, &tangent));
    if (tangent && options->out)
        TRY(plots_run(options->out, "mohr"));
    if (!options->out)
        return STATUS_OK;
    if (snprintf(path, sizeof path, "%s/ensemble.json", options->out) >= (int)sizeof path)
        return status_fail(STATUS_USAGE, "%.60s...: the path is too long", options->out);
    TRY(ensemble_write(ensemble, path));
    printf("results: %s%s\n", path, tangent ? ", mohr.json, mohr.svg" : "");
    return STATUS_OK;
}

int main(int argc, char **argv)
{
    struct command options;
    struct ensemble ensemble = {0};
    enum status status = command_read(&options, argc, argv);
    int code = status_report("analyzer", status);
    if (status != STATUS_OK || options.help) {
        fputs(options.help ? command_usage : "", stdout);
        return code;
    }
    /* one bad run does not cost the others; the exit code is that of the first failure */
    for (int k = options.first; k < argc; k++) {
        int failed = status_report("analyzer", analyse(argv[k], &options, &ensemble));
        code = code ? code : failed;
    }
    if ((argc - options.first > 1 || options.out) && ensemble.n > 0) {
        int failed = status_report("analyzer", ensemble_report(&ensemble, &options));
        code = code ? code : failed;
    }
    ensemble_free(&ensemble);
    return code;
}
