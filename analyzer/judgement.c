#include "analyzer/judgement.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "analyzer/control_quality.h"
#include "common/pressure_target.h"

const double judgement_residual_doubtful = 0.01;
const double judgement_overlap_note = 0.05, judgement_overlap_failed = 0.3;
const double judgement_inertial_note = 1e-3, judgement_rest_note = 1e-3, judgement_stress_note = 0.02;

const char *judgement_worth_name(enum worth worth)
{
    static const char *const names[] = {"sound", "doubtful", "failed"};
    return names[worth];
}

const char *judgement_severity_name(enum worth worth)
{
    return worth == WORTH_SOUND ? "note" : judgement_worth_name(worth);
}

static void add(struct judgement *judgement, const char *stage, enum worth severity, const char *format, ...)
    PRINTF_LIKE(4, 5);

static void add(struct judgement *judgement, const char *stage, enum worth severity, const char *format, ...)
{
    va_list arguments;
    if (severity > judgement->verdict)
        judgement->verdict = severity;
    if (judgement->n == JUDGEMENT_NOTES_MAX)
        return;
    struct judgement_note *note = &judgement->note[judgement->n++];
    note->severity = severity;
    snprintf(note->stage, sizeof note->stage, "%s", stage);
    va_start(arguments, format);
    vsnprintf(note->text, sizeof note->text, format, arguments);
    va_end(arguments);
}

/* The severest note of the simulator's own on a stage; -1 if there is none. */
static int already(const struct run *run, const char *stage)
{
    int severest = -1;
    for (size_t k = 0; k < run->n_notes; k++)
        if (strcmp(run->note[k].stage, stage) == 0 && (int)run->note[k].severity > severest)
            severest = (int)run->note[k].severity;
    return severest;
}

static const char *stage_name(const struct run *run, int stage)
{
    return run->scene->stage[stage].name;
}

double judgement_residual(const struct run *run, enum observable residual, size_t begin, size_t end, bool *net)
{
    double total = 0, before = 0, work = 0;
    for (size_t k = begin; k < end; k++) {
        work = *run_record(run, OBSERVABLE_WORK_WALLS, k) + *run_record(run, OBSERVABLE_WORK_GRAVITY, k);
        total += k > begin ? fabs(work - before) : 0;
        before = work;
    }
    *net = fabs(work) >= total / 10;
    return total > 0 ? fabs(*run_record(run, residual, end - 1)) / (*net ? fabs(work) : total) : NAN;
}

/* Over the work, or over the energy in the sample where that is more: a sample that comes to rest does hardly any work.
 */
static void residual_check(struct judgement *judgement, const struct run *run, int stage, size_t begin, size_t end)
{
    bool net;
    double residual = judgement_residual(run, OBSERVABLE_ENERGY_RESIDUAL, begin, end, &net), energy = 0;
    for (size_t k = begin; k < end; k++)
        energy = fmax(energy, *run_record(run, OBSERVABLE_ELASTIC_NORMAL, k) +
                                  *run_record(run, OBSERVABLE_ELASTIC_TANGENTIAL, k) +
                                  *run_record(run, OBSERVABLE_KINETIC_ENERGY, k));
    if (energy > 0)
        residual = fmin(residual, fabs(*run_record(run, OBSERVABLE_ENERGY_RESIDUAL, end - 1)) / energy);
    if (residual > judgement_residual_doubtful && already(run, stage_name(run, stage)) < WORTH_DOUBTFUL)
        add(judgement, stage_name(run, stage), WORTH_DOUBTFUL,
            "the energy ledger does not close: its residual is %.3g %% of the work (of the energy, where that is more; "
            "bound %g %%); a shorter time step "
            "would tell",
            100 * residual, 100 * judgement_residual_doubtful);
}

/* Of a stage before the one that is evaluated no result is taken: a note, whatever the size. */
static void overlap_check(struct judgement *judgement, const struct run *run, int stage, size_t begin, size_t end,
                          bool evaluated)
{
    double largest = 0;
    for (size_t k = begin; k < end; k++)
        largest = fmax(largest, *run_record(run, OBSERVABLE_MAX_OVERLAP_RATIO, k));
    /* a stage may allow itself more */
    const double bound = fmax(judgement_overlap_failed, run->scene->stage[stage].limits.overlap_ratio);
    const enum worth severity = evaluated && largest > bound ? WORTH_FAILED : WORTH_SOUND;
    if (largest > judgement_overlap_note && already(run, stage_name(run, stage)) < (int)severity)
        add(judgement, stage_name(run, stage), severity,
            "overlaps of up to %.3g %% of the smaller radius (note from %g %%, failed from %g %%): stiffer contacts or "
            "less "
            "pressure would be within what contact laws describe",
            100 * largest, 100 * judgement_overlap_note, 100 * bound);
}

/* E_kin/E_el at the first sample. */
static void rest_check(struct judgement *judgement, const struct run *run, int stage, size_t begin)
{
    const double elastic =
        *run_record(run, OBSERVABLE_ELASTIC_NORMAL, begin) + *run_record(run, OBSERVABLE_ELASTIC_TANGENTIAL, begin);
    const double ratio = *run_record(run, OBSERVABLE_KINETIC_ENERGY, begin) / elastic;
    if (elastic > 0 && ratio > judgement_rest_note && already(run, stage_name(run, stage)) < 0)
        add(judgement, stage_name(run, stage), WORTH_SOUND,
            "the sample is not at rest at the start: E_kin/E_el = %.3g (bound %g)", ratio, judgement_rest_note);
}

static void inertial_check(struct judgement *judgement, const struct run *run, int stage, size_t begin, size_t end)
{
    double largest = 0, mean = 0;
    for (size_t k = begin; k < end; k++) {
        const double inertial = fabs(*run_record(run, OBSERVABLE_INERTIAL_NUMBER, k));
        largest = fmax(largest, inertial);
        mean += inertial / (double)(end - begin);
    }
    if (largest >= judgement_inertial_note && already(run, stage_name(run, stage)) < 0)
        add(judgement, stage_name(run, stage), WORTH_SOUND,
            "not quasi-static: inertial number up to %.3g, mean %.3g (bound %g); a lower rate would tell what that "
            "adds",
            largest, mean, judgement_inertial_note);
}

void judgement_stress_error(const struct run *run, int stage, size_t begin, size_t end, double *mean, double *largest)
{
    double sum = 0, count = 0, top = 0;
    for (size_t k = begin; k < end && !run->controller[0]; k++) /* whose targets are not in the record */
        for (int slot = 0; slot < run->dimension; slot++) {
            const struct scene_axis *axis = &run->scene->stage[stage].axis[scene_pair_axis(run->scene, slot)];
            const double target =
                axis->mode == WALL_STRESS ? pressure_target_pa(axis, *run_record(run, OBSERVABLE_STAGE_TIME, k)) : NAN;
            const double size = fmax(fabs(axis->pressure_pa), fabs(target));
            if (!isfinite(target) || !(size > 0))
                continue;
            const double error = fabs(run_record(run, OBSERVABLE_STRESS_WALL, k)[slot] - target) / size;
            sum += error;
            count++;
            top = fmax(top, error);
        }
    *mean = count > 0 ? sum / count : NAN;
    *largest = count > 0 ? top : NAN;
}

static void stress_check(struct judgement *judgement, const struct run *run, int stage, size_t begin, size_t end)
{
    double mean, largest;
    judgement_stress_error(run, stage, begin, end, &mean, &largest);
    if (mean > judgement_stress_note && already(run, stage_name(run, stage)) < 0)
        add(judgement, stage_name(run, stage), WORTH_SOUND,
            "stresses differ from their targets by %.3g %% in the mean, %.3g %% at most (bound of the mean %g %%)",
            100 * mean, 100 * largest, 100 * judgement_stress_note);
}

/* What the scene asks its walls to keep, where it says how well. */
static void tolerance_check(struct judgement *judgement, const struct run *run, int stage, size_t begin, size_t end)
{
    static const char *const names[KEPT_QUANTITIES] = {"a stress", "the volume", "p", "q", "the path", "b"};
    struct control_quality kept[KEPT_QUANTITIES];
    if (run->controller[0])
        return;
    control_quality_find(run, stage, begin, end, kept);
    for (int k = 0; k < KEPT_QUANTITIES; k++)
        if (kept[k].tolerance > 0 && kept[k].largest > kept[k].tolerance)
            add(judgement, stage_name(run, stage), WORTH_DOUBTFUL,
                "%s was kept to %.2g, %.2g in the mean; walls.?.tolerance = %g: lighter walls, a shorter exchange "
                "interval, a slower test or a larger sample would help",
                names[k], kept[k].largest, kept[k].mean, kept[k].tolerance);
}

/* Preparation may be violent: only the ledger and the overlaps of all stages count, the rest of the one that is
 * evaluated. */
static void stage_check(struct judgement *judgement, const struct run *run, int stage, bool evaluated)
{
    size_t begin, end;
    run_stage_range(run, stage, &begin, &end);
    if (begin == end)
        return;
    residual_check(judgement, run, stage, begin, end);
    overlap_check(judgement, run, stage, begin, end, evaluated);
    if (!evaluated)
        return;
    rest_check(judgement, run, stage, begin);
    inertial_check(judgement, run, stage, begin, end);
    stress_check(judgement, run, stage, begin, end);
    tolerance_check(judgement, run, stage, begin, end);
}

/* How far the run came, and why no further. */
static void end_check(struct judgement *judgement, const struct run *run, int stage)
{
    const double total = scene_total_time_s(run->scene), last = run->n_samples ? run->time_s[run->n_samples - 1] : 0;
    const bool whole = run->complete && run->status == 0;
    judgement->done = whole ? 1 : total > 0 ? fmin(1, fmax(0, last / total)) : 0;
    judgement->ended = whole || (run->n_samples && *run_record(run, OBSERVABLE_STAGE, run->n_samples - 1) > stage);
    if (whole) {
        snprintf(judgement->headline, sizeof judgement->headline, "complete");
        return;
    }
    const bool stopped = run->status == status_exit_code(STATUS_INTERRUPTED) || strstr(run->reason, "interrupt") ||
                         (run->status == 0 && !run->complete);
    snprintf(judgement->headline, sizeof judgement->headline, "%s at %.0f %%%s%.180s",
             stopped ? "INTERRUPTED" : "FAILED", floor(100 * judgement->done), run->reason[0] ? ": " : "", run->reason);
    add(judgement, "", WORTH_FAILED, "%s%s", judgement->headline,
        judgement->ended ? "; the evaluated stage came to its end before" : "; the evaluated stage did not end");
}

static enum status status_of(const struct judgement *judgement, const struct run *run)
{
    if (judgement->verdict == WORTH_SOUND)
        return STATUS_OK;
    if (judgement->verdict == WORTH_DOUBTFUL)
        return STATUS_DOUBTFUL;
    static const enum status known[] = {STATUS_INTERRUPTED, STATUS_UNSTABLE, STATUS_LIMIT,
                                        STATUS_TIMEOUT,     STATUS_BUS,      STATUS_NO_MEMORY};
    for (size_t k = 0; k < sizeof known / sizeof known[0]; k++)
        if (status_exit_code(known[k]) == run->status)
            return known[k];
    return run->complete && run->status == 0 ? STATUS_LIMIT : STATUS_INCOMPLETE;
}

void judgement_make(struct judgement *judgement, const struct run *run, int stage)
{
    memset(judgement, 0, sizeof *judgement);
    end_check(judgement, run, stage);
    if (run->controller[0])
        add(judgement, "", WORTH_SOUND,
            "a controller of the user's own set the targets, not the scene: %.300s; what the test is comes from the "
            "record, cycles are not looked for",
            run->controller);
    for (size_t k = 0; k < run->n_notes; k++)
        add(judgement, run->note[k].stage, (enum worth)run->note[k].severity, "%s", run->note[k].text);
    for (int k = 0; k < run->scene->n_stages; k++)
        stage_check(judgement, run, k, k == stage);
    judgement->status = status_of(judgement, run);
}
