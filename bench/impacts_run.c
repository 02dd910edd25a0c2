#include <limits.h>
#include <math.h>
#include <stdlib.h>

#include "bench/impacts.h"
#include "sim/sample/stage.h"
#include "sim/sample/step_completion.h"
#include "sim/sample/time_step.h"

enum { X, Y, Z };

static double overlap_m(const struct impacts *all, const struct impact *k, const struct impact_state *s)
{
    double d2 = 0;
    if (!k->pair)
        return k->radius_m[0] - (s->x[Z][k->i] - all->floor_m);
    for (int c = 0; c < 3; c++)
        d2 += (s->x[c][k->i] - s->x[c][k->j]) * (s->x[c][k->i] - s->x[c][k->j]);
    return k->radius_m[0] + k->radius_m[1] - sqrt(d2);
}

/* With omega about y a contact point at (r, 0, 0) moves by -omega r along z, one at (0, 0, r) by omega r along x. */
static double slip_m_per_s(const struct impact *k, const struct impact_state *s)
{
    if (!k->pair)
        return s->v[X][k->i] - s->omega_y[k->i] * k->radius_m[0];
    return s->v[Z][k->i] - s->omega_y[k->i] * k->radius_m[0] - s->v[Z][k->j] - s->omega_y[k->j] * k->radius_m[1];
}

static double separation_m_per_s(const struct impact *k, const struct impact_state *s)
{
    return k->pair ? s->v[X][k->j] - s->v[X][k->i] : s->v[Z][k->i];
}

static double tangential_m_per_s(const struct impact *k, const struct impact_state *s)
{
    return k->pair ? s->v[Z][k->i] : s->v[X][k->i];
}

static void look(struct impacts *all, struct impact *k, const struct impact_state *s)
{
    const double overlap = overlap_m(all, k, s);
    const double force = k->pair ? -s->force[X][k->i] : s->force[Z][k->i];
    k->peak_force_n = fmax(k->peak_force_n, force);
    k->peak_overlap_m = fmax(k->peak_overlap_m, overlap);
    if (k->contact_s == 0 && overlap <= 0 && k->overlap_before_m > 0) {
        const double part = k->overlap_before_m / (k->overlap_before_m - overlap);
        k->contact_s = k->time_before_s + part * (s->time_s - k->time_before_s);
    }
    k->overlap_before_m = overlap;
    k->time_before_s = s->time_s;
    k->rebound_m_per_s = separation_m_per_s(k, s);
    k->slip_after_m_per_s = slip_m_per_s(k, s);
    k->tangential_after_m_per_s = tangential_m_per_s(k, s);
    k->spin_after_rad_per_s = s->omega_y[k->i];
}

void impacts_look(struct impacts *impacts, const struct impact_state *state)
{
    for (int k = 0; k < impacts->count; k++)
        look(impacts, &impacts->impact[k], state);
}

/* The state in the order of ids, in columns of `values`: x, v, force of each axis, and omega_y. */
static void state_take(struct impact_state *state, double *values, struct complete_sample whole)
{
    const struct particles *p = &whole.sample->particles;
    double *x[3], *v[3], *force[3], *omega = values + 9 * (size_t)p->count;
    for (int c = 0; c < 3; c++) {
        state->x[c] = x[c] = values + (size_t)(3 * c) * (size_t)p->count;
        state->v[c] = v[c] = x[c] + p->count;
        state->force[c] = force[c] = v[c] + p->count;
    }
    for (int id = 0; id < p->count; id++) {
        const int i = p->slot[id];
        for (int c = 0; c < 3; c++) {
            x[c][id] = p->x[c][i];
            v[c][id] = p->v[c][i];
            force[c][id] = p->mass[i] * p->a[c][i];
        }
        omega[id] = p->n_rotations == 3 ? p->omega[1][i] : 0;
    }
    state->omega_y = omega;
    state->time_s = whole.sample->time_s;
}

enum status impacts_of(struct impacts *impacts, const struct sample *sample, bool pairs)
{
    const struct particles *p = &sample->particles;
    *impacts = (struct impacts){.count = pairs ? p->count / 2 : p->count, .floor_m = sample->walls[2 * Z].x};
    if (impacts->count > IMPACTS_MAX)
        return status_fail(STATUS_LIMIT, "%d impacts; allowed: %d", impacts->count, IMPACTS_MAX);
    for (int n = 0; n < impacts->count; n++) {
        struct impact *k = &impacts->impact[n];
        const int i = pairs ? p->slot[2 * n] : p->slot[n], j = pairs ? p->slot[2 * n + 1] : i;
        *k = (struct impact){.pair = pairs,
                             .i = p->id[i],
                             .j = p->id[j],
                             .radius_m = {p->radius[i], p->radius[j]},
                             .mass_kg = {p->mass[i], p->mass[j]}};
        const double spin[2] = {p->n_rotations ? p->omega[1][i] : 0, p->n_rotations ? p->omega[1][j] : 0};
        k->normal_m_per_s = pairs ? p->v[X][i] - p->v[X][j] : -p->v[Z][i];
        k->tangential_m_per_s = pairs ? p->v[Z][i] : p->v[X][i];
        k->slip_m_per_s = k->tangential_m_per_s - spin[0] * p->radius[i];
        if (pairs)
            k->slip_m_per_s -= p->v[Z][j] + spin[1] * p->radius[j];
        k->spin_rad_per_s = spin[0];
    }
    return STATUS_OK;
}

static enum status steps(struct impacts *impacts, struct sample *sample, double *values)
{
    const struct scene_stage *stage = &sample->scene->stage[0];
    struct impact_state state;
    struct wall_command command = {.n_steps = INT_MAX, .n_walls = sample->n_walls};
    for (int w = 0; w < sample->n_walls; w++)
        command.position_m[w] = sample->walls[w].x;
    TRY(sample_command(sample, &command));
    const int64_t n = llround(stage->duration_s / stage->dt_s);
    for (int64_t k = 0; k < n; k++) {
        TRY(sample_step(sample));
        state_take(&state, values, sample_complete(sample));
        impacts_look(impacts, &state);
    }
    return STATUS_OK;
}

enum status impacts_run(struct impacts *impacts, struct sample *sample)
{
    double *values = calloc(10 * (size_t)sample->particles.count, sizeof *values);
    if (!values)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    enum status status = steps(impacts, sample, values);
    free(values);
    return status;
}
