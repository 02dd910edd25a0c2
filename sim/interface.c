#include "sim/interface.h"

#include <limits.h>
#include <math.h>

#include "sim/drive.h"
#include "sim/measure.h"
#include "sim/world.h"
#include "wallctl/stress.h"

/* The watch looks at windows of intervals. One with a mismatch beyond all energy of the sample is bad, one that loses a
 * few percent of it leaks; this many in a row are too many. Where the mismatch is a small part of the work it is not
 * looked at. */
enum { WINDOW = 16, BAD_WINDOWS = 3, LEAKING_WINDOWS = 32 };
/* Contacts on a wall over its area in mean diameters: the most that was seen, with a margin. */
static const double DENSE = 1.5;
static const double WATCHED_ERROR = 0.01, LEAK = 0.02;

void interface_set_law(struct world *world)
{
    const struct particles *p = &world->particles;
    double mass = 0, radius = 0;
    for (int i = 0; i < p->count; i++) {
        mass += p->mass[i];
        radius += p->radius[i];
    }
    /* a chain of mean particles on springs k2: the stiffest way through the sample */
    world->interface.diameter_m = 2 * radius / p->count;
    world->interface.sound_m_per_s = world->interface.diameter_m * sqrt(world->law.k2 * p->count / mass);
}

void interface_stage_start(struct world *world)
{
    struct interface *face = &world->interface;
    face->residual_j = face->controller_residual_j = 0;
    face->error = face->error_before = 0;
    face->window_residual_j = face->window_error = 0;
    face->window_intervals = face->bad_windows = face->leaking_windows = 0;
}

/* Energy between the work of the interval that ended and the controller's idea of it, with the command that follows. */
static double controller_mismatch_j(const struct world *world, const struct wall_command *command, int w)
{
    const struct wall_path *path = &world->path;
    const struct interface *face = &world->interface;
    const double dx = world->walls[w].inward * (face->x_start[w] - world->walls[w].x); /* outward */
    if (path->drive[w] == DRIVE_LOOP && command->drive[w] == DRIVE_LOOP)
        return fabs(face->work[w] - 0.5 * (face->controller_force[w] + command->force_n[w]) * dx);
    if (path->drive[w] >= DRIVE_IMPEDANCE && command->drive[w] == path->drive[w]) { /* the driving force jumps */
        double end_n = drive_force_n(path, w, path->n_steps * path->dt);
        return 0.5 * fabs((command->force_n[w] - end_n) * dx);
    }
    return 0;
}

void interface_close(struct world *world, const struct wall_command *command)
{
    struct interface *face = &world->interface;
    const bool ended = world->stage_step > 0 && command->stage == world->stage;
    for (int w = 0; w < world->n_walls; w++) {
        if (ended) {
            double mismatch_j = controller_mismatch_j(world, command, w);
            face->controller_residual_j += mismatch_j;
            if (world->path.drive[w] >= DRIVE_IMPEDANCE) /* both sides have the same two forces */
                face->residual_j += mismatch_j;
        }
        face->controller_force[w] = command->force_n[w];
        face->force_told[w] = world->walls[w].force;
    }
}

void interface_open(struct world *world)
{
    struct interface *face = &world->interface;
    for (int w = 0; w < world->n_walls; w++) {
        face->force_start[w] = world->walls[w].force;
        face->x_start[w] = world->walls[w].x;
        face->work[w] = 0;
    }
}

static char wall_axis_name(const struct world *world, int w)
{
    return "xyz"[world_axis(world, w / 2)];
}

static const char *wall_end_name(int w)
{
    return w % 2 ? "upper" : "lower";
}

static bool in_loop(const struct world *world, int w)
{
    return world->path.drive[w] != DRIVE_PATH;
}

/* What would hold for wall w, as far as the bounds tell, for the end of a message. */
static void advice(const struct world *world, int w, char *text, size_t size)
{
    const struct scene_coupling *coupling = &world->scene->coupling;
    const struct scene_axis *axis = &world->scene->stage[world->stage].axis[world_axis(world, w / 2)];
    double stiffness[SCENE_WALLS_MAX], damping[SCENE_WALLS_MAX];
    measure_wall_stiffness(world, stiffness, damping);
    struct stress_loop loop = {.mass_kg = axis->mass_kg,
                               .damping_kg_per_s = axis->damping_kg_per_s,
                               .stiffness_n_per_m = stiffness[w],
                               .contact_damping_kg_per_s = damping[w]};
    /* a wall that has just been thrown off touches nothing: a dense layer of particles is the least to count with */
    double layer = DENSE;
    for (int c = 0; c < world->particles.dimension; c++)
        layer *= c == w / 2 ? 1 : world_box_length_m(world, c) / world->interface.diameter_m;
    loop.stiffness_n_per_m = fmax(loop.stiffness_n_per_m, layer * world->law.k2);
    loop.contact_damping_kg_per_s = fmax(loop.contact_damping_kg_per_s, layer * world->law.gamma_n);
    int n = coupling->interval_steps > INT_MAX ? INT_MAX : (int)coupling->interval_steps;
    int scheme = coupling->scheme == SCHEME_IMPEDANCE ? SCHEME_HOLD : coupling->scheme;
    int stable = stress_stable_steps(scheme, &loop, world->dt, scheme == SCHEME_HOLD ? n : (n + 1) / 2);
    if (stable < 1 || world->path.n_steps == 1)
        snprintf(text, size,
                 "dt_s = %g s is too long for this wall: shorter steps, more mass or more damping would help",
                 world->dt);
    else
        snprintf(text, size,
                 "coupling.interval_steps = %d would hold with %g N/m of contacts on the wall; so would the "
                 "scheme \"impedance\"",
                 stable, loop.stiffness_n_per_m);
}

static enum status unstable(const struct world *world, int w, const char *what)
{
    char help[256];
    advice(world, w, help, sizeof help);
    return status_fail(
        STATUS_UNSTABLE,
        "step %lld (t = %g s): the loop of the %s wall in %c is not stable at an exchange interval of %d "
        "steps: %s; %s",
        (long long)world->step, world->time_s, wall_end_name(w), wall_axis_name(world, w), world->path.n_steps, what,
        help);
}

static enum status check_walls(const struct world *world)
{
    char what[128];
    for (int w = 0; w < world->n_walls; w++) {
        const struct wall *wall = &world->walls[w];
        if (!in_loop(world, w))
            continue;
        if (!(fabs(wall->v) <= world->interface.sound_m_per_s)) {
            snprintf(what, sizeof what, "it moves at %g m/s, sound in the sample at %g m/s%s", fabs(wall->v),
                     world->interface.sound_m_per_s, wall->contacts.count ? "" : ", and touches nothing");
            return unstable(world, w, what);
        }
        if (!(world->walls[w | 1].x > world->walls[w & ~1].x))
            return unstable(world, w, "it has passed the one opposite");
    }
    return STATUS_OK;
}

/* The wall with the largest mismatch in the last interval. */
static int worst_wall(const struct world *world, const double *mismatch_j)
{
    int worst = 0;
    for (int w = 1; w < world->n_walls; w++)
        if (mismatch_j[w] > mismatch_j[worst])
            worst = w;
    return worst;
}

static double held_energy_j(const struct world *world)
{
    struct held_energy held = measure_held_energy(world);
    return held.kinetic_j + held.elastic_j;
}

/* A loop that swings beyond what friction and contacts take loses or gains energy at the walls, faster and faster, or
 * on and on. */
static enum status watch(struct world *world, const double *mismatch_j, double sum_j)
{
    struct interface *face = &world->interface;
    char what[128];
    face->window_residual_j += sum_j;
    face->window_error += face->error / WINDOW;
    if (++face->window_intervals < WINDOW)
        return STATUS_OK;
    const double residual_j = face->window_residual_j;
    const double held_j = face->window_error > WATCHED_ERROR ? held_energy_j(world) : INFINITY;
    face->bad_windows = residual_j <= held_j ? 0 : face->bad_windows + 1;
    face->leaking_windows = residual_j <= LEAK * held_j ? 0 : face->leaking_windows + 1;
    face->window_residual_j = face->window_error = 0;
    face->window_intervals = 0;
    if (face->bad_windows < BAD_WINDOWS && face->leaking_windows < LEAKING_WINDOWS)
        return STATUS_OK;
    snprintf(what, sizeof what, "%g J were lost or gained there in the last %d intervals, the sample holds %g J",
             residual_j, WINDOW, held_j);
    return unstable(world, worst_wall(world, mismatch_j), what);
}

/* The books of the interval that ends now. */
static enum status interval_end(struct world *world)
{
    struct interface *face = &world->interface;
    double mismatch_j[SCENE_WALLS_MAX] = {0}, sum_j = 0, scale_j = 0;
    for (int w = 0; w < world->n_walls; w++) {
        const struct wall *wall = &world->walls[w];
        if (world->path.drive[w] != DRIVE_LOOP)
            continue;
        const double dx = wall->inward * (face->x_start[w] - wall->x);
        mismatch_j[w] = fabs(face->work[w] - 0.5 * (face->force_start[w] + wall->force) * dx);
        sum_j += mismatch_j[w];
        scale_j += 0.5 * (fabs(face->force_start[w]) + fabs(wall->force)) * fabs(dx);
    }
    face->residual_j += sum_j;
    face->error_before = face->error;
    face->error = scale_j > 0 ? sum_j / scale_j : 0;
    TRY(check_walls(world));
    return watch(world, mismatch_j, sum_j);
}

enum status interface_step(struct world *world, const double *x_before, const double *force_before)
{
    const struct wall_path *path = &world->path;
    for (int w = 0; w < world->n_walls; w++) {
        const struct wall *wall = &world->walls[w];
        /* trapezoidal rule; `inward` points into the box, the force outward */
        double work = 0.5 * (force_before[w] + wall->force) * wall->inward * (wall->x - x_before[w]);
        world->ledger.work_walls += work;
        world->interface.work[w] -= work;
    }
    return world->step == path->from_step + path->n_steps ? interval_end(world) : STATUS_OK;
}
