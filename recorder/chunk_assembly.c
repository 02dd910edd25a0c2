#include "recorder/chunk_assembly.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static enum status refuse(const char *channel, int frame, int chunk, const char *reason)
{
    return status_fail(STATUS_FORMAT, "%s: frame %d, chunk %d: %s", channel, frame, chunk, reason);
}

struct run_facts run_facts_of(const shakedown_run_info_t *info)
{
    struct run_facts facts = {.dimension = info->dimension,
                              .n_particles = info->n_particles,
                              .n_walls = 2 * info->dimension,
                              .frictional = info->frictional != 0,
                              .n_history = info->n_history};
    for (int k = 0; k < facts.n_history; k++) {
        struct contact_field *column = &facts.history[k];
        snprintf(column->name, sizeof column->name, "%s", info->history_name[k]);
        snprintf(column->unit, sizeof column->unit, "%s", info->history_unit[k]);
        column->kind = (enum history_kind)info->history_kind[k];
    }
    return facts;
}

int history_width(const struct contact_field *column)
{
    return column->kind == HISTORY_NUMBER ? 1 : 3;
}

enum status particle_set_init(struct particle_set *set, const struct run_facts *facts)
{
    size_t n = (size_t)facts->n_particles;
    *set = (struct particle_set){.radius_m = malloc(n * sizeof(double)), .mass_kg = malloc(n * sizeof(double))};
    if (!set->radius_m || !set->mass_kg)
        return status_fail(STATUS_NO_MEMORY, "no memory for %d particles", facts->n_particles);
    return STATUS_OK;
}

void particle_set_free(struct particle_set *set)
{
    free(set->radius_m);
    free(set->mass_kg);
    *set = (struct particle_set){0};
}

void particle_set_restart(struct particle_set *set)
{
    set->n_chunks = set->next_chunk = set->filled = 0;
}

bool particle_set_is_complete(const struct particle_set *set)
{
    return set->n_chunks > 0 && set->next_chunk == set->n_chunks;
}

enum status particle_set_add(struct particle_set *set, const struct run_facts *facts,
                             const shakedown_particles_t *chunk)
{
    bool first = set->n_chunks == 0;
    bool last = chunk->chunk == chunk->n_chunks - 1;
    int end = chunk->first + chunk->count;
    if (chunk->chunk != set->next_chunk || (!first && chunk->n_chunks != set->n_chunks))
        return refuse("PARTICLES", 0, chunk->chunk, "not the next chunk");
    if (chunk->first != set->filled || end > facts->n_particles || last != (end == facts->n_particles))
        return refuse("PARTICLES", 0, chunk->chunk, "its ids do not fit the run's number of particles");
    for (int k = 0; k < chunk->count; k++) {
        set->radius_m[set->filled + k] = chunk->radius_m[k];
        set->mass_kg[set->filled + k] = chunk->mass_kg[k];
        if (chunk->radius_m[k] > set->radius_max_m)
            set->radius_max_m = chunk->radius_m[k];
    }
    set->filled = end;
    set->n_chunks = chunk->n_chunks;
    set->next_chunk++;
    return STATUS_OK;
}

/* Whether a chunk goes on where the frame stands. */
static bool place_fits(const struct frame_place *place, int frame, int chunk, int n_chunks, int64_t step, double time_s)
{
    if (frame != place->frame || chunk != place->next_chunk)
        return false;
    bool same =
        n_chunks == place->n_chunks && step == place->step && memcmp(&time_s, &place->time_s, sizeof time_s) == 0;
    return chunk == 0 || same;
}

/* Enters a chunk that fits; returns whether it was the last. */
static bool place_advance(struct frame_place *place, int n_chunks, int64_t step, double time_s)
{
    place->n_chunks = n_chunks;
    place->step = step;
    place->time_s = time_s;
    return ++place->next_chunk == n_chunks;
}

void frame_place_next(struct frame_place *place)
{
    place->frame++;
    place->next_chunk = 0;
}

enum status particle_frame_init(struct particle_frame *frame, const struct run_facts *facts)
{
    size_t values = 3 * (size_t)facts->n_particles;
    *frame = (struct particle_frame){.position_m = calloc(values, sizeof(double)),
                                     .velocity_m_per_s = calloc(values, sizeof(double))};
    if (facts->frictional)
        frame->angular_velocity_rad_per_s = calloc(values, sizeof(double));
    if (!frame->position_m || !frame->velocity_m_per_s || (facts->frictional && !frame->angular_velocity_rad_per_s))
        return status_fail(STATUS_NO_MEMORY, "no memory for a frame of %d particles", facts->n_particles);
    return STATUS_OK;
}

void particle_frame_free(struct particle_frame *frame)
{
    free(frame->position_m);
    free(frame->velocity_m_per_s);
    free(frame->angular_velocity_rad_per_s);
    *frame = (struct particle_frame){0};
}

/* Copies rows of `dimension` components into rows of three: (x, z) becomes (x, 0, z). */
static void widen(double (*rows)[3], const double *values, int count, int dimension)
{
    for (int k = 0; k < count; k++) {
        const double *row = values + (size_t)k * (size_t)dimension;
        rows[k][0] = row[0];
        rows[k][1] = dimension == 3 ? row[1] : 0.0;
        rows[k][2] = row[dimension - 1];
    }
}

/* In 2D the one angular velocity is about y. */
static void widen_spin(double (*rows)[3], const double *values, int count, int dimension)
{
    if (dimension == 3) {
        widen(rows, values, count, 3);
        return;
    }
    for (int k = 0; k < count; k++) {
        rows[k][0] = rows[k][2] = 0.0;
        rows[k][1] = values[k];
    }
}

static enum status particle_frame_check(const struct particle_frame *frame, const struct run_facts *facts,
                                        const shakedown_frame_particles_t *chunk)
{
    const char *channel = "FRAME_PARTICLES";
    bool last = chunk->chunk == chunk->n_chunks - 1;
    int end = chunk->first + chunk->count;
    int filled = chunk->chunk == 0 ? 0 : frame->filled;
    if (!place_fits(&frame->place, chunk->frame, chunk->chunk, chunk->n_chunks, chunk->step, chunk->time_s))
        return refuse(channel, chunk->frame, chunk->chunk, "not the next chunk");
    if (chunk->dimension != facts->dimension || (chunk->n_angular > 0) != (facts->frictional && chunk->count > 0))
        return refuse(channel, chunk->frame, chunk->chunk, "its dimension or rotations do not fit the run");
    if (chunk->first != filled || end > facts->n_particles || last != (end == facts->n_particles))
        return refuse(channel, chunk->frame, chunk->chunk, "its ids do not fit the run's number of particles");
    return STATUS_OK;
}

enum status particle_frame_add(struct particle_frame *frame, const struct run_facts *facts,
                               const shakedown_frame_particles_t *chunk, bool *full)
{
    TRY(particle_frame_check(frame, facts, chunk));
    size_t start = 3 * (size_t)chunk->first;
    widen((double(*)[3])(frame->position_m + start), chunk->position_m, chunk->count, chunk->dimension);
    widen((double(*)[3])(frame->velocity_m_per_s + start), chunk->velocity_m_per_s, chunk->count, chunk->dimension);
    if (facts->frictional)
        widen_spin((double(*)[3])(frame->angular_velocity_rad_per_s + start), chunk->angular_velocity_rad_per_s,
                   chunk->count, chunk->dimension);
    widen(&frame->box_lo_m, chunk->box_lo_m, 1, chunk->dimension);
    widen(&frame->box_hi_m, chunk->box_hi_m, 1, chunk->dimension);
    frame->stage = chunk->stage;
    frame->filled = chunk->first + chunk->count;
    *full = place_advance(&frame->place, chunk->n_chunks, chunk->step, chunk->time_s);
    return STATUS_OK;
}

void contact_frame_free(struct contact_frame *frame)
{
    free(frame->pair);
    free(frame->overlap_m);
    free(frame->normal_force_n);
    free(frame->normal);
    free(frame->tangential_force_n);
    free(frame->sliding);
    for (int k = 0; k < HISTORY_FIELDS_MAX; k++)
        free(frame->history[k]);
    *frame = (struct contact_frame){0};
}

static enum status grow(void *array, size_t count, size_t size)
{
    void *old, *grown;
    memcpy(&old, array, sizeof old);
    grown = realloc(old, count * size);
    if (!grown)
        return status_fail(STATUS_NO_MEMORY, "no memory for %zu contacts", count);
    memcpy(array, &grown, sizeof grown);
    return STATUS_OK;
}

/* Makes room for `count` contacts. */
static enum status contact_frame_reserve(struct contact_frame *frame, const struct run_facts *facts, int64_t count)
{
    if (count <= frame->capacity)
        return STATUS_OK;
    size_t n = (size_t)(count > 2 * frame->capacity ? count : 2 * frame->capacity);
    TRY(grow(&frame->pair, 2 * n, sizeof *frame->pair));
    TRY(grow(&frame->overlap_m, n, sizeof *frame->overlap_m));
    TRY(grow(&frame->normal_force_n, n, sizeof *frame->normal_force_n));
    TRY(grow(&frame->normal, 3 * n, sizeof *frame->normal));
    TRY(grow(&frame->tangential_force_n, 3 * n, sizeof *frame->tangential_force_n));
    TRY(grow(&frame->sliding, n, sizeof *frame->sliding));
    for (int k = 0; k < facts->n_history; k++)
        TRY(grow(&frame->history[k], (size_t)history_width(&facts->history[k]) * n, sizeof *frame->history[k]));
    frame->capacity = (int64_t)n;
    return STATUS_OK;
}

static bool pairs_ok(const struct run_facts *facts, const shakedown_frame_contacts_t *chunk)
{
    for (int k = 0; k < chunk->count; k++) {
        int i = chunk->i[k], j = chunk->j[k];
        if (i < 0 || i >= facts->n_particles || j < -facts->n_walls || j >= facts->n_particles || i == j)
            return false;
    }
    return true;
}

/* Values per contact of all fields of the history. */
static int history_values(const struct run_facts *facts)
{
    int values = 0;
    for (int k = 0; k < facts->n_history; k++)
        values += history_kind_values(facts->history[k].kind, facts->dimension);
    return values;
}

static enum status contact_frame_check(const struct contact_frame *frame, const struct run_facts *facts,
                                       const shakedown_frame_contacts_t *chunk)
{
    const char *channel = "FRAME_CONTACTS";
    bool forces = facts->frictional && chunk->count > 0;
    if (!place_fits(&frame->place, chunk->frame, chunk->chunk, chunk->n_chunks, chunk->step, chunk->time_s))
        return refuse(channel, chunk->frame, chunk->chunk, "not the next chunk");
    if (chunk->dimension != facts->dimension || (chunk->n_tangential > 0) != forces || (chunk->n_sliding > 0) != forces)
        return refuse(channel, chunk->frame, chunk->chunk, "its dimension or friction does not fit the run");
    if (chunk->n_history != (int64_t)chunk->count * history_values(facts))
        return refuse(channel, chunk->frame, chunk->chunk, "its contacts' history does not fit the run");
    if (!pairs_ok(facts, chunk))
        return refuse(channel, chunk->frame, chunk->chunk, "an id that no particle and no wall has");
    return STATUS_OK;
}

static void history_add(struct contact_frame *frame, const struct run_facts *facts, int64_t old,
                        const shakedown_frame_contacts_t *chunk)
{
    const double *values = chunk->history;
    for (int k = 0; k < facts->n_history; k++) {
        const struct contact_field *column = &facts->history[k];
        double *rows = frame->history[k] + history_width(column) * old;
        if (column->kind == HISTORY_NUMBER)
            memcpy(rows, values, (size_t)chunk->count * sizeof *rows);
        else if (column->kind == HISTORY_TANGENT)
            widen((double(*)[3])rows, values, chunk->count, chunk->dimension);
        else
            widen_spin((double(*)[3])rows, values, chunk->count, chunk->dimension);
        values += (int64_t)chunk->count * history_kind_values(column->kind, chunk->dimension);
    }
}

enum status contact_frame_add(struct contact_frame *frame, const struct run_facts *facts,
                              const shakedown_frame_contacts_t *chunk, bool *full)
{
    TRY(contact_frame_check(frame, facts, chunk));
    int64_t old = chunk->chunk == 0 ? 0 : frame->count;
    TRY(contact_frame_reserve(frame, facts, old + chunk->count));
    size_t bytes = (size_t)chunk->count * sizeof(double);
    for (int k = 0; k < chunk->count; k++) {
        frame->pair[2 * (old + k)] = chunk->i[k];
        frame->pair[2 * (old + k) + 1] = chunk->j[k];
        frame->sliding[old + k] = facts->frictional ? chunk->sliding[k] : 0;
    }
    if (chunk->count > 0) {
        memcpy(frame->overlap_m + old, chunk->overlap_m, bytes);
        memcpy(frame->normal_force_n + old, chunk->normal_force_n, bytes);
        widen((double(*)[3])(frame->normal + 3 * old), chunk->normal, chunk->count, chunk->dimension);
    }
    if (facts->frictional && chunk->count > 0)
        widen((double(*)[3])(frame->tangential_force_n + 3 * old), chunk->tangential_force_n, chunk->count,
              chunk->dimension);
    if (chunk->count > 0)
        history_add(frame, facts, old, chunk);
    frame->count = old + chunk->count;
    *full = place_advance(&frame->place, chunk->n_chunks, chunk->step, chunk->time_s);
    return STATUS_OK;
}
