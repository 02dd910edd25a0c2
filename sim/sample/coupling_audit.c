#include "sim/sample/coupling_audit.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "sim/sample/energy.h"
#include "sim/sample/step_completion.h"
#include "sim/sample/wall_motion.h"
#include "wallctl/control_law.h"

/* The watch looks at windows of intervals. One with a mismatch beyond all energy of the sample is bad, one that loses a
 * few percent of it leaks; this many in a row are too many. Where the mismatch is a small part of the work it is not
 * looked at. */
enum { WINDOW = 16, BAD_WINDOWS = 3, LEAKING_WINDOWS = 32 };
/* Contacts on a wall over its area in mean diameters: the most that was seen, with a margin. */
static const double DENSE = 1.5;
static const double WATCHED_ERROR = 0.01, LEAK = 0.02;
/* The shortest period of anything that follows the contacts is six steps: no turn in so many of them. */
enum { TURNS_MIN = 4 };

void coupling_audit_set_law(struct sample *sample)
{
    const struct particles *p = &sample->particles;
    double mass = 0, radius = 0;
    for (int i = 0; i < p->count; i++) {
        mass += p->mass[i];
        radius += p->radius[i];
    }
    /* a chain of mean particles on springs k2: the stiffest way through the sample */
    sample->audit.diameter_m = 2 * radius / p->count;
    sample->audit.sound_m_per_s = sample->audit.diameter_m * sqrt(sample->law.stiffness * p->count / mass);
}

void coupling_audit_stage_start(struct sample *sample)
{
    struct coupling_audit *audit = &sample->audit;
    audit->residual_j = audit->controller_residual_j = 0;
    audit->error = audit->error_before = 0;
    audit->window_residual_j = audit->window_error = 0;
    audit->window_intervals = audit->bad_windows = audit->leaking_windows = 0;
    audit->swing = (struct swing_watch){0};
}

/* Energy between the work of the interval that ended and the controller's idea of it, with the command that follows. */
static double controller_mismatch_j(const struct sample *sample, const struct wall_command *command, int w)
{
    const struct wall_trajectory *path = &sample->trajectory;
    const struct coupling_audit *audit = &sample->audit;
    const double dx = sample->walls[w].inward * (audit->x_start[w] - sample->walls[w].x); /* outward */
    if (path->drive[w] == DRIVE_LOOP && command->drive[w] == DRIVE_LOOP)
        return fabs(audit->work[w] - 0.5 * (audit->controller_force[w] + command->force_n[w]) * dx);
    if (path->drive[w] >= DRIVE_IMPEDANCE && command->drive[w] == path->drive[w]) { /* the driving force jumps */
        double end_n = walls_driving_force_n(path, w, path->n_steps * path->dt);
        return 0.5 * fabs((command->force_n[w] - end_n) * dx);
    }
    return 0;
}

void coupling_audit_close(struct sample *sample, const struct wall_command *command)
{
    struct coupling_audit *audit = &sample->audit;
    const bool ended = sample->stage_step > 0 && command->stage == sample->stage;
    for (int w = 0; w < sample->n_walls; w++) {
        if (ended) {
            double mismatch_j = controller_mismatch_j(sample, command, w);
            audit->controller_residual_j += mismatch_j;
            if (sample->trajectory.drive[w] >= DRIVE_IMPEDANCE) /* both sides have the same two forces */
                audit->residual_j += mismatch_j;
        }
        audit->controller_force[w] = command->force_n[w];
        audit->force_told[w] = sample->walls[w].force;
    }
}

void coupling_audit_open(struct sample *sample)
{
    struct coupling_audit *audit = &sample->audit;
    for (int w = 0; w < sample->n_walls; w++) {
        audit->force_start[w] = sample->walls[w].force;
        audit->x_start[w] = sample->walls[w].x;
        audit->work[w] = 0;
    }
}

static char wall_axis_name(const struct sample *sample, int w)
{
    return "xyz"[sample_axis(sample, w / 2)];
}

static const char *wall_end_name(int w)
{
    return w % 2 ? "upper" : "lower";
}

static bool in_loop(const struct sample *sample, int w)
{
    return sample->trajectory.drive[w] != DRIVE_PATH;
}

/* Whether the loop of wall w is closed in every step: by the controller, or by sim itself. */
static bool closed_in_steps(const struct sample *sample, int w)
{
    const struct wall_trajectory *path = &sample->trajectory;
    return path->drive[w] >= DRIVE_IMPEDANCE || (path->drive[w] == DRIVE_LOOP && path->n_steps == 1);
}

/* What would hold for wall w, as far as the bounds tell, for the end of a message. */
static void advice(const struct sample *sample, int w, char *text, size_t size)
{
    const struct scene_axis *axis = &sample->scene->stage[sample->stage].axis[sample_axis(sample, w / 2)];
    double stiffness[SCENE_WALLS_MAX], damping[SCENE_WALLS_MAX];
    walls_stiffness(sample, stiffness, damping);
    /* a wall that has just been thrown off touches nothing: a dense layer of particles is the least to count with */
    double layer = DENSE;
    for (int c = 0; c < sample->particles.dimension; c++)
        layer *= c == w / 2 ? 1 : sample_box_length_m(sample, c) / sample->audit.diameter_m;
    stiffness[w] = fmax(stiffness[w], layer * sample->wall_law[w / 2].stiffness);
    damping[w] = fmax(damping[w], layer * sample->wall_law[w / 2].gamma_n);
    const int stable = wallctl_stable_steps(&sample->scene->coupling, axis, stiffness[w], damping[w], sample->dt);
    if (stable < 1 || closed_in_steps(sample, w))
        snprintf(text, size,
                 "dt_s = %g s is too long for this wall: shorter steps, more mass or more damping (walls.%c.mass_kg, "
                 "damping_kg_per_s) would help",
                 sample->dt, wall_axis_name(sample, w));
    else
        snprintf(text, size,
                 "coupling.interval_steps = %d would hold with %g N/m of contacts on the wall; so would the "
                 "scheme \"impedance\"",
                 stable, stiffness[w]);
}

static enum status unstable(const struct sample *sample, int w, const char *what)
{
    char help[256];
    advice(sample, w, help, sizeof help);
    return status_fail(
        STATUS_UNSTABLE,
        "step %lld (t = %g s): the loop of the %s wall in %c is not stable at an exchange interval of %d "
        "steps: %s; %s",
        (long long)sample->step, sample->time_s, wall_end_name(w), wall_axis_name(sample, w),
        sample->trajectory.n_steps, what, help);
}

/* What the pressure alone may bring the walls of component c to: all of its work over the length of the box at the
 * start of the stage as kinetic energy, or the speed at which damping takes all of the force. A soft sample is slower.
 */
static double driven_m_per_s(const struct sample *sample, int c)
{
    const struct scene_axis *axis = &sample->scene->stage[sample->stage].axis[sample_axis(sample, c)];
    const double length = sample->stage_position_m[2 * c + 1] - sample->stage_position_m[2 * c];
    double largest_pa = fmax(fabs(axis->pressure_pa), fabs(axis->pressure_end_pa));
    largest_pa = fmax(largest_pa, fabs(axis->pressure_pa) + fabs(axis->amplitude_pa));
    for (int k = 0; k < axis->pressures_pa.count; k++)
        largest_pa = fmax(largest_pa, fabs(axis->pressures_pa.value[k]));
    double force_n = largest_pa;
    for (int b = 0; b < sample->particles.dimension; b++)
        force_n *= b == c ? 1 : sample_box_length_m(sample, b);
    const double fall = axis->mass_kg > 0 ? sqrt(2 * force_n * length / axis->mass_kg) : INFINITY;
    const double drag = axis->damping_kg_per_s > 0 ? force_n / axis->damping_kg_per_s : INFINITY;
    return fmin(fall, drag);
}

static enum status check_walls(const struct sample *sample)
{
    char what[192];
    for (int w = 0; w < sample->n_walls; w++) {
        const struct wall *wall = &sample->walls[w];
        if (!in_loop(sample, w))
            continue;
        const double driven = driven_m_per_s(sample, w / 2);
        if (!(fabs(wall->v) <= sample->audit.sound_m_per_s + driven)) {
            snprintf(what, sizeof what,
                     "it moves at %g m/s; sound in the sample at %g m/s, the pressure brings it to %g "
                     "m/s%s",
                     fabs(wall->v), sample->audit.sound_m_per_s, driven,
                     wall->contacts.count ? "" : ", and touches nothing");
            return unstable(sample, w, what);
        }
        if (!(sample->walls[w | 1].x > sample->walls[w & ~1].x))
            return unstable(sample, w, "it has passed the one opposite");
    }
    return STATUS_OK;
}

/* The wall with the largest mismatch in the last interval. */
static int worst_wall(const struct sample *sample, const double *mismatch_j)
{
    int worst = 0;
    for (int w = 1; w < sample->n_walls; w++)
        if (mismatch_j[w] > mismatch_j[worst])
            worst = w;
    return worst;
}

static double held_energy_j(struct sample *sample)
{
    const struct held_energy held = energy_held(sample_complete(sample));
    return held.kinetic_j + held.elastic_j;
}

/* A loop that swings beyond what friction and contacts take loses or gains energy at the walls, faster and faster, or
 * on and on. */
static enum status watch(struct sample *sample, const double *mismatch_j, double sum_j)
{
    struct coupling_audit *audit = &sample->audit;
    char what[128];
    audit->window_residual_j += sum_j;
    audit->window_error += audit->error / WINDOW;
    if (++audit->window_intervals < WINDOW)
        return STATUS_OK;
    const double residual_j = audit->window_residual_j;
    const double held_j = audit->window_error > WATCHED_ERROR ? held_energy_j(sample) : INFINITY;
    audit->bad_windows = residual_j <= held_j ? 0 : audit->bad_windows + 1;
    audit->leaking_windows = residual_j <= LEAK * held_j ? 0 : audit->leaking_windows + 1;
    audit->window_residual_j = audit->window_error = 0;
    audit->window_intervals = 0;
    if (audit->bad_windows < BAD_WINDOWS && audit->leaking_windows < LEAKING_WINDOWS)
        return STATUS_OK;
    snprintf(what, sizeof what, "%g J were lost or gained there in the last %d intervals, the sample holds %g J",
             residual_j, WINDOW, held_j);
    return unstable(sample, worst_wall(sample, mismatch_j), what);
}

/* The books of the interval that ends now. */
static enum status interval_end(struct sample *sample)
{
    struct coupling_audit *audit = &sample->audit;
    double mismatch_j[SCENE_WALLS_MAX] = {0}, sum_j = 0, scale_j = 0;
    for (int w = 0; w < sample->n_walls; w++) {
        const struct wall *wall = &sample->walls[w];
        if (sample->trajectory.drive[w] != DRIVE_LOOP)
            continue;
        const double dx = wall->inward * (audit->x_start[w] - wall->x);
        mismatch_j[w] = fabs(audit->work[w] - 0.5 * (audit->force_start[w] + wall->force) * dx);
        sum_j += mismatch_j[w];
        scale_j += 0.5 * (fabs(audit->force_start[w]) + fabs(wall->force)) * fabs(dx);
    }
    audit->residual_j += sum_j;
    audit->error_before = audit->error;
    audit->error = scale_j > 0 ? sum_j / scale_j : 0;
    TRY(check_walls(sample));
    return watch(sample, mismatch_j, sum_j);
}

static void swing_add(struct swing_watch *swing, int w, bool closed, double way_m, double before_n, double now_n)
{
    swing->turns[w] = closed && way_m * swing->way_m[w] < 0 ? swing->turns[w] + 1 : 0;
    swing->way_m[w] = way_m;
    if (closed)
        swing->passed_j += 0.5 * (fabs(before_n) + fabs(now_n)) * fabs(way_m);
    if (swing->turns[w] >= TURNS_MIN)
        swing->swung_j[w] += 0.5 * fabs(now_n - before_n) * fabs(way_m);
}

/* A loop that is closed in every step shows no residual when it is not stable: its wall turns round in every step, and
 * what it swings with passes all that the sample holds, or a few percent of it on and on. */
static enum status swing_look(struct sample *sample)
{
    struct swing_watch *swing = &sample->audit.swing;
    double swung_j = 0;
    char what[160];
    if (++swing->steps < WINDOW)
        return STATUS_OK;
    for (int w = 0; w < sample->n_walls; w++)
        swung_j += swing->swung_j[w];
    const double held_j = swung_j > WATCHED_ERROR * swing->passed_j ? held_energy_j(sample) : INFINITY;
    const int worst = worst_wall(sample, swing->swung_j);
    swing->bad_windows = swung_j <= held_j ? 0 : swing->bad_windows + 1;
    swing->leaking_windows = swung_j <= LEAK * held_j ? 0 : swing->leaking_windows + 1;
    swing->steps = 0;
    swing->passed_j = 0;
    memset(swing->swung_j, 0, sizeof swing->swung_j);
    if (swing->bad_windows < BAD_WINDOWS && swing->leaking_windows < LEAKING_WINDOWS)
        return STATUS_OK;
    snprintf(what, sizeof what,
             "it turns round in every step, and %g J went there and back in %d steps, the sample holds %g J", swung_j,
             WINDOW, held_j);
    return unstable(sample, worst, what);
}

enum status coupling_audit_step(struct sample *sample, const double *x_before, const double *force_before)
{
    const struct wall_trajectory *path = &sample->trajectory;
    for (int w = 0; w < sample->n_walls; w++) {
        const struct wall *wall = &sample->walls[w];
        /* trapezoidal rule; `inward` points into the box, the force outward */
        const double inward_m = wall->inward * (wall->x - x_before[w]);
        double work = 0.5 * (force_before[w] + wall->force) * inward_m;
        sample->ledger.work_walls += work;
        sample->audit.work[w] -= work;
        swing_add(&sample->audit.swing, w, closed_in_steps(sample, w), -inward_m, force_before[w], wall->force);
    }
    TRY(swing_look(sample));
    return sample->step == path->from_step + path->n_steps ? interval_end(sample) : STATUS_OK;
}
