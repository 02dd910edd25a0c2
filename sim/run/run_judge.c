#include "sim/run/run_judge.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "sim/measure/at_rest.h"
#include "sim/measure/measure.h"
#include "sim/measure/step_limit.h"
#include "sim/measure/strain_limit.h"
#include "sim/sample/energy.h"
#include "sim/sample/step_completion.h"

/* Contacts shorter than this many steps are coarse; a sample is at rest below these figures; overlaps beyond this part
 * of the smaller radius bend the law of spheres; the ledger is to close to this part of the energy that passed. */
static const double COARSE_STEPS = 6, REST_ENERGY = 1e-3, REST_FORCE = 1e-2, WIDE_OVERLAP = 0.05, OPEN_LEDGER = 0.01;
/* An overlap of both radii is a particle that comes out on the other side; contacts of slower ones are looked at. */
static const double PASSING = 2;
/* Particles that could overlap by so much come and go between looks: contacts are looked at about once in each, which
 * has 12 to 20 steps; and where they could overlap by twice as much every few steps: a particle that passes through at
 * the speed of PASSING is inside for 8 or more. */
static const double HURRYING = 0.25;
enum { HURRY_STEPS = 4 };
/* A box that has moved by this part of its length carries the sample along. */
static const double DRIFTING = 0.5;
/* A sample whose contacts hold less than this part of their energy bears a thousandth of its stress. */
static const double LOOSE = 1e-6;

enum { TEXT_MAX = 400 };

static const char *stage_name(const struct run *run)
{
    return run->sample->stage < 0 ? "" : run_stage(run)->name;
}

static enum status add_note(struct run *run, enum note_severity severity, const char *format, ...) PRINTF_LIKE(3, 4);

static enum status add_note(struct run *run, enum note_severity severity, const char *format, ...)
{
    char text[TEXT_MAX];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (run->options->replay)
        return STATUS_OK;
    if (severity == NOTE_DOUBTFUL && run->judge.doubts++ == 0)
        snprintf(run->judge.first_doubt, sizeof run->judge.first_doubt, "%s%s%s", stage_name(run),
                 run->sample->stage < 0 ? "" : ": ", text);
    if (run->options->progress)
        fprintf(stderr, "sim: note: %s%s%s\n", stage_name(run), run->sample->stage < 0 ? "" : ": ", text);
    return run->stream ? records_send_note(&run->records, run->sample, severity, text) : STATUS_OK;
}

static enum status note_step(struct run *run, const struct scene_stage *stage)
{
    const struct step_limit limit = step_limit_of(run->sample, stage);
    if (stage->dt_s > limit.wall_stable_s)
        TRY(add_note(run, NOTE_PLAIN,
                     "%s: dt_s = %.3g s is too long for the wall in %c once a whole layer of particles touches it: up "
                     "to %.2g s would hold, or a heavier or more damped wall",
                     stage->name, stage->dt_s, limit.wall_axis, limit.wall_stable_s));
    if (stage->dt_s * COARSE_STEPS <= limit.contact_s)
        return STATUS_OK;
    return add_note(
        run, NOTE_PLAIN,
        "%s: dt_s = %.3g s is %.2g of the shortest contact (t_c = %.3g s, radius %.3g m): coarse; the ledger "
        "residual says what it costs",
        stage->name, stage->dt_s, stage->dt_s / limit.contact_s, limit.contact_s, limit.radius_m);
}

enum status run_judge_before(struct run *run)
{
    if (run->options->replay)
        return STATUS_OK;
    TRY(step_limit_check(run->sample));
    if (!run->resumed)
        TRY(strain_limit_check(run->sample, 0));
    for (int s = 0; s < run->scene->n_stages && !run->resumed; s++)
        TRY(note_step(run, &run->scene->stage[s]));
    return STATUS_OK;
}

static enum status note_places(struct run *run)
{
    struct stability_watch *watch = &run->judge.watch;
    for (int c = 0; c < run->sample->particles.dimension; c++) {
        const char name = "xyz"[sample_axis(run->sample, c)];
        if (watch->left[c] > STABILITY_WATCH_ALONE_MAX && !(watch->left_noted[c] > 0)) {
            watch->left_noted[c] = 1;
            TRY(add_note(run, NOTE_PLAIN,
                         "the walls in %c touch nothing any more (step %lld): their strain leads them away", name,
                         (long long)run->sample->step));
        }
        if (fabs(watch->drift[c]) > DRIFTING && !(watch->drift_noted > 0)) {
            watch->drift_noted = 1;
            TRY(add_note(run, NOTE_PLAIN,
                         "the sample drifts: its box has moved by %.2g of its length in %c (step %lld); opposite = "
                         "\"mirror\" or \"fixed\" would hold it",
                         watch->drift[c], name, (long long)run->sample->step));
        }
    }
    return STATUS_OK;
}

static enum status note_extremes(struct run *run)
{
    struct run_judge *judge = &run->judge;
    if (judge->watch.overlap_ratio > WIDE_OVERLAP && !(judge->watch.overlap_noted > 0)) {
        judge->watch.overlap_noted = 1;
        TRY(add_note(run, NOTE_PLAIN, "overlaps beyond %.0f %% of the smaller radius: %.2g at step %.0f",
                     100 * WIDE_OVERLAP, judge->watch.overlap_ratio, judge->watch.overlap_step));
    }
    if (judge->watch.fastest_ratio > PASSING && !(judge->watch.fastest_noted > 0)) {
        judge->watch.fastest_noted = 1;
        TRY(add_note(run, NOTE_DOUBTFUL,
                     "particles so fast that a contact would overlap by %.2g of the radius: they may pass through each "
                     "other; slower ones or stiffer contacts would help",
                     judge->watch.fastest_ratio));
    }
    return note_places(run);
}

static void hurry_set(struct run *run, double fastest)
{
    run->judge.hurry_steps = fastest > 2 * HURRYING ? HURRY_STEPS : fastest > HURRYING ? 4 * HURRY_STEPS : 0;
    if (run->judge.hurry_steps == 0)
        passing_watch_forget(&run->judge.passing);
}

static enum status note_passing(struct run *run)
{
    struct run_judge *judge = &run->judge;
    judge->passing_noted = true;
    return add_note(
        run, NOTE_DOUBTFUL,
        "particles %d and %d passed through each other (step %lld): slower ones or stiffer contacts would help",
        judge->passing.last[0], judge->passing.last[1], (long long)judge->passing.last_step);
}

enum status run_judge_stage_start(struct run *run)
{
    struct stability_watch *watch = &run->judge.watch;
    stability_watch_start(watch);
    run->judge.passing_noted = false;
    if (run->options->replay)
        return STATUS_OK;
    TRY(strain_limit_check(run->sample, run->sample->stage)); /* the box was not known before */
    watch->fastest_ratio = overlaps_of_fastest(run->sample);
    hurry_set(run, watch->fastest_ratio);
    TRY(note_extremes(run));
    if (run->sample->stage == 0)
        return STATUS_OK; /* of a packing that was just made there is nothing to say */
    const struct rest_figures rest = rest_figures_of(sample_complete(run->sample));
    if (rest.contacts == 0)
        return add_note(run, NOTE_PLAIN, "starts with nothing touching");
    const bool at_rest = rest.energy_ratio < REST_ENERGY && rest.unbalanced_force < REST_FORCE;
    return add_note(run, NOTE_PLAIN, "starts %s: unbalanced force %.2g of the mean contact force, E_kin/E_el %.2g",
                    at_rest ? "at rest" : "NOT at rest", rest.unbalanced_force, rest.energy_ratio);
}

enum status run_judge_step(struct run *run)
{
    struct run_judge *judge = &run->judge;
    const int64_t step = run->sample->stage_step, passed = judge->passing.passed;
    const bool whole = step % STABILITY_WATCH_STEPS == 0,
               fast = judge->hurry_steps > 0 && step % judge->hurry_steps == 0;
    struct passing_watch *passing = fast ? &judge->passing : NULL;
    if (run->options->replay)
        return STATUS_OK;
    const double fastest = whole ? overlaps_of_fastest(run->sample) : 0;
    if (whole)
        TRY(stability_watch_look(&judge->watch, run->sample, fastest, passing));
    else if (fast)
        TRY(stability_watch_look_at_contacts(&judge->watch, run->sample, passing));
    if (judge->passing.passed > passed && !judge->passing_noted)
        TRY(note_passing(run));
    if (!whole)
        return STATUS_OK;
    hurry_set(run, fastest);
    return note_extremes(run);
}

/* "; stress x 500 N/m^2 within 0.1 % (mean), 0.4 % (largest)" of each axis. */
static void stress_text(const struct run *run, char *text, size_t size)
{
    const struct stability_watch *watch = &run->judge.watch;
    size_t used = 0;
    text[0] = '\0';
    for (int c = 0; c < run->sample->particles.dimension && watch->error_looks > 0; c++) {
        const enum axis name = sample_axis(run->sample, c);
        if (run_stage(run)->axis[name].mode != WALL_STRESS || watch->target_pa[c] == 0 || used >= size)
            continue;
        used += (size_t)snprintf(text + used, size - used,
                                 "; stress %c off its target by %.2g %% (mean), %.2g %% (largest)", "xyz"[name],
                                 100 * watch -> error_sum[c] / watch -> error_looks, 100 * watch -> error_max[c]);
    }
}

/* A loss below zero is energy out of nothing. How a spring that slides shares its loss with its dashpot is a convention
 * (docs/theory.md): what counts is their sum. */
static enum status judge_losses(struct run *run, double scale_j)
{
    const struct contact_losses *lost = &run->sample->ledger.contacts;
    const struct {
        const char *name;
        double loss_j;
    } terms[] = {{"hysteresis", lost->hysteresis},
                 {"viscous normal forces", lost->viscous_normal},
                 {"tangential forces", lost->friction + lost->viscous_tangential + lost->stiffness},
                 {"rolling resistance", lost->rolling + lost->viscous_rolling},
                 {"background damping", run->sample->ledger.background}};
    for (size_t k = 0; k < sizeof terms / sizeof *terms; k++)
        if (terms[k].loss_j < -OPEN_LEDGER * scale_j)
            TRY(add_note(run, NOTE_DOUBTFUL, "%s gained %.2g J, %.2g %% of the energy that passed: dt_s is too long",
                         terms[k].name, -terms[k].loss_j, -100 * terms[k].loss_j / scale_j));
    return STATUS_OK;
}

static enum status judge_ledger(struct run *run, const struct measurement *m)
{
    const double scale_j = measure_ledger_scale_j(run->sample, m);
    if (!(scale_j > 0))
        return STATUS_OK;
    const double ratio = fabs(m->residual_j) / scale_j;
    if (!(ratio <= OPEN_LEDGER))
        TRY(add_note(run, NOTE_DOUBTFUL,
                     "the energy ledger does not close: residual %.3g J, %.2g %% of the energy that passed; a smaller "
                     "dt_s would help",
                     m->residual_j, 100 * ratio));
    return judge_losses(run, scale_j);
}

/* "0.44 of the energy that passed", and what it is held against where that is next to nothing. */
static void residual_text(const struct run *run, const struct measurement *m, char *text, size_t size)
{
    const double turnover_j = measure_turnover_j(run->sample, m), scale_j = measure_ledger_scale_j(run->sample, m);
    const int used =
        snprintf(text, size, "%.2g of the energy that passed", turnover_j > 0 ? m->residual_j / turnover_j : 0);
    if (scale_j > turnover_j && used > 0 && (size_t)used < size)
        snprintf(text + used, size - (size_t)used, ", %.2g of what is held",
                 MEASURE_HELD_PART * m->residual_j / scale_j);
}

enum status run_judge_stage_end(struct run *run, int ended)
{
    struct measurement m;
    char stress[TEXT_MAX / 2], residual[128];
    if (run->options->replay)
        return STATUS_OK;
    const struct complete_sample whole = sample_complete(run->sample);
    TRY(stability_watch_look(&run->judge.watch, run->sample, overlaps_of_fastest(run->sample), NULL));
    TRY(note_extremes(run));
    TRY(measure(whole, &m));
    stress_text(run, stress, sizeof stress);
    const struct stability_watch *watch = &run->judge.watch;
    const double held_start_j = run->sample->ledger.elastic_start, held_j = energy_held(whole).elastic_j;
    if (held_j < LOOSE * held_start_j)
        TRY(add_note(run, NOTE_PLAIN,
                     "the sample has come apart: its contacts hold %.2g of the elastic energy of the start",
                     held_j / held_start_j));
    residual_text(run, &m, residual, sizeof residual);
    TRY(add_note(
        run, NOTE_PLAIN,
        "ended by %s after %g s%s; inertial number %.2g (mean), %.2g (largest); largest overlap %.2g of the radius; "
        "ledger residual %s",
        stage_end_text(ended), (double)run->sample->stage_step * run->sample->dt, stress,
        watch->inertial_sum / watch->looks, watch->inertial_max, watch->overlap_ratio, residual));
    return judge_ledger(run, &m);
}

enum status run_judge_note_failure(struct run *run, enum status status)
{
    char message[TEXT_MAX];
    snprintf(message, sizeof message, "%s", status_message());
    if (status == STATUS_OK || run->options->replay)
        return STATUS_OK;
    return add_note(run, NOTE_FAILED, "%s", message);
}

enum status run_judge_verdict(const struct run *run, enum status status)
{
    const struct run_judge *judge = &run->judge;
    if (run->options->replay || status != STATUS_OK)
        return status;
    if (judge->doubts > 0)
        return status_fail(STATUS_DOUBTFUL, "verdict: doubtful (%lld %s): %s", (long long)judge->doubts,
                           judge->doubts == 1 ? "reason" : "reasons", judge->first_doubt);
    if (run->options->progress)
        fprintf(stderr, "sim: verdict: sound\n");
    return STATUS_OK;
}
