/* The kernels' order of the contacts (contacts.h): who gets which slot, and the history's way there and back. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sim/base/aligned_array.h"
#include "sim/contacts/contact_column.h"
#include "sim/contacts/contact_list.h"
#include "sim/contacts/slot_assignment.h"

static enum status slots_reserve(struct contact_list *list, int dimension)
{
    struct contact_slots *slots = &list->slots;
    const size_t real = list->model.mixed ? sizeof(float) : sizeof(double);
    if (list->n_sets <= slots->capacity)
        return STATUS_OK;
    size_t sets = (size_t)list->n_sets + (size_t)list->n_sets / 8;
    size_t size = sets * SET_WIDTH;
    TRY(array_resize(&slots->first, sizeof *slots->first, 2 * sets, 0));
    TRY(array_resize(&slots->partner, sizeof *slots->partner, size, 0));
    for (int c = 0; list->model.mixed && c < dimension; c++)
        TRY(array_resize(&slots->built[c], sizeof(float), size, 0));
    if (list->model.mixed)
        TRY(array_resize(&slots->gap, sizeof(float), size, 0));
    TRY(array_resize(&slots->reach, real, size, 0));
    for (int c = 0; list->model.traits & NORMAL_PER_PAIR && c < PAIR_CONSTANTS; c++)
        TRY(array_resize(&slots->pair[c], real, size, 0));
    for (int c = 0; c < HISTORY_COLUMNS; c++)
        if (history_has(&list->model, c))
            TRY(array_resize(&slots->history[c], real, size, 0));
    slots->capacity = (int)sets;
    return STATUS_OK;
}

static void put(const struct contact_list *list, void *array, size_t slot, double value)
{
    if (list->model.mixed)
        ((float *)array)[slot] = (float)value;
    else
        ((double *)array)[slot] = value;
}

/* What column c of member k is multiplied by on its way into the slots: its sign if the slot is j's, and the unit. */
static double into_slot(const struct contact_list *list, int c, int k)
{
    const double sign = history_is_odd(&list->model, c) && list->slot[k] % 2 ? -1 : 1;
    return sign / contact_column_unit(list, c);
}

/* What the ranges of slots or members are filled with. */
struct filling {
    struct contact_list *list;
    const struct particles *particles;
    const struct wall *wall;
    uint32_t stride, padding_row;
    double nothing; /* reach of the padding particle */
    int column;     /* of the history */
};

enum { FILL_GRAIN = 16384 };

/* The padding particle is nowhere near: mixed by `built` and `gap`, which are more units than anything moves and still
 * have a square, double by its place, but walls know no distance to it: `nothing` is its reach. */
static void empty_slots(void *context, int first, int end)
{
    const struct filling *f = context;
    const struct contact_list *list = f->list;
    const size_t from = (size_t)first, to = (size_t)end;
    const struct contact_slots *slots = &list->slots;
    for (size_t s = from; s < to; s++) {
        slots->partner[s] = f->padding_row;
        if (list->model.mixed) {
            slots->gap[s] = -0x1p80F;
            slots->built[0][s] = 0x1p40F;
        }
    }
    for (int c = 1; list->model.mixed && c < f->particles->dimension; c++)
        memset(slots->built[c] + from, 0, sizeof(float) * (to - from));
    for (size_t s = from; s < to; s++)
        put(list, slots->reach, s, f->nothing);
}

/* Single: where the partner of slot s was when the lists were built, from particle i; of walls only how far. per_unit:
 * 1/unit, a power of 2. */
static void fill_built(struct contact_list *list, size_t s, double reach, const struct particles *p, int i, int j,
                       const struct wall *wall, double per_unit)
{
    struct contact_slots *slots = &list->slots;
    if (wall) {
        slots->gap[s] = (float)((reach - wall->inward * (p->x_list[wall->axis][i] - wall->x_list)) * per_unit);
        return;
    }
    double gap = reach * reach;
    for (int c = 0; c < p->dimension; c++) {
        double d = p->x_list[c][i] - p->x_list[c][j];
        slots->built[c][s] = (float)(d * per_unit);
        gap -= d * d;
    }
    slots->gap[s] = (float)(gap * (per_unit * per_unit));
}

/* Empty slots have those of two particles of mass and radius 1, so that lanes of theirs stay finite. */
static void empty_pair_constants(void *context, int first, int end)
{
    const struct contact_list *list = ((const struct filling *)context)->list;
    for (size_t s = (size_t)first; s < (size_t)end; s++)
        for (int c = 0; c < PAIR_CONSTANTS; c++)
            put(list, list->slots.pair[c], s, 1);
}

static void fill_pair_constants(void *context, int first, int end)
{
    const struct filling *f = context;
    const struct contact_list *list = f->list;
    const struct contact_slots *slots = &list->slots;
    const struct particles *p = f->particles;
    const struct wall *wall = f->wall;
    for (int k = first; k < end; k++) {
        const size_t s = list->slot[k] / 2;
        const int i = list->i[k], j = list->j[k];
        const double mass = wall ? p->mass[i] : p->mass[i] * p->mass[j] / (p->mass[i] + p->mass[j]);
        const double radius = wall ? p->radius[i] : p->radius[i] * p->radius[j] / list->reach[k];
        put(list, slots->pair[PAIR_ROOT_MASS], s, sqrt(mass));
        put(list, slots->pair[PAIR_RADIUS], s, radius / slots->unit);
    }
}

static void fill_slots(void *context, int first, int end)
{
    const struct filling *f = context;
    struct contact_list *list = f->list;
    const struct particles *p = f->particles;
    const struct wall *wall = f->wall;
    const uint32_t stride = f->stride;
    struct contact_slots *slots = &list->slots;
    const double per_unit = 1 / slots->unit, reach_per = wall ? 1 : per_unit;
    for (int k = first; k < end; k++) {
        const size_t s = list->slot[k] / 2;
        const int32_t turned = wall || list->slot[k] % 2; /* no branch: it could not be predicted */
        const int32_t both = list->i[k] ^ list->j[k], j = list->j[k] ^ (both & -turned);
        const int32_t i = wall ? list->i[k] : both ^ j;
        slots->partner[s] = stride * (uint32_t)j;
        if (list->model.mixed)
            fill_built(list, s, list->reach[k], p, i, j, wall, per_unit);
        put(list, slots->reach, s, list->reach[k] * reach_per);
    }
}

static void empty_column(void *context, int first, int end)
{
    const struct filling *f = context;
    const size_t real = f->list->model.mixed ? sizeof(float) : sizeof(double);
    memset((char *)f->list->slots.history[f->column] + real * (size_t)first, 0, real * (size_t)(end - first));
}

static void fill_column(void *context, int first, int end)
{
    const struct filling *f = context;
    const struct contact_list *list = f->list;
    for (int k = first; k < end; k++)
        put(list, list->slots.history[f->column], list->slot[k] / 2,
            into_slot(list, f->column, k) * list->history[f->column][k]);
}

static enum status spans_reserve(struct contact_slots *slots, int n)
{
    if (n <= slots->span_capacity)
        return STATUS_OK;
    TRY(array_resize(&slots->span, sizeof *slots->span, (size_t)n, 0));
    slots->span_capacity = n;
    return STATUS_OK;
}

/* Particles and sets of span s. */
static struct contact_span span_of(const struct slot_assignment *assignment, int s, int n_particles)
{
    const int first = s * assignment->span_width, rest = (n_particles - first + SET_WIDTH - 1) / SET_WIDTH * SET_WIDTH;
    return (struct contact_span){.first = first,
                                 .last = first + (rest < assignment->span_width ? rest : assignment->span_width),
                                 .next = assignment->span[s],
                                 .whole = slot_assignment_whole_set(assignment, s),
                                 .halves = slot_assignment_halves_set(assignment, s),
                                 .end = assignment->span[s + 1]};
}

static void fill_row(struct contact_slots *slots, const struct slot_assignment *assignment, int b, int row)
{
    const int halves = assignment->width / HALF_WIDTH;
    for (int h = 0; h < halves; h++)
        slots->first[row * halves + h] = (uint32_t)(assignment->width * b + HALF_WIDTH * h);
}

static void fill_first(struct contact_slots *slots, const struct slot_assignment *assignment)
{
    for (int s = 0; s < assignment->n_spans; s++) /* also of what is nobody's */
        for (int half = 2 * assignment->span[s]; half < 2 * assignment->span[s + 1]; half++)
            slots->first[half] = (uint32_t)(s * assignment->span_width);
    for (int b = 0; b < assignment->n_blocks; b++) {
        if (assignment->chained)
            fill_row(slots, assignment, b, slot_assignment_chain_row(assignment, b));
        for (int k = 0, n = slot_assignment_rows(assignment, b); k < n; k++)
            fill_row(slots, assignment, b, slot_assignment_row(assignment, b, k));
    }
}

/* Blocks of half a set are filled better; in 3D that does not pay for what two halves cost the kernels (2D, AVX2: 4 %
 * of a step gained; 3D, AVX-512: 3 % lost). So do wide spans, in small samples (2D 2 % of the pairs gained, 3D 2 %
 * lost). */
static enum status assign_pairs(struct contact_list *list, const struct particles *p)
{
    struct slot_assignment assignment;
    const int width = p->dimension == 2 ? HALF_WIDTH : SET_WIDTH,
              span_width = p->dimension == 2 && p->count < PARTICLES_LARGE_SAMPLE ? WIDE_SPAN : SPAN_WIDTH;
    TRY(slot_assignment_make(list, p->count, width, span_width, &assignment));
    TRY(slots_reserve(list, p->dimension));
    TRY(spans_reserve(&list->slots, assignment.n_spans));
    list->slots.n_spans = assignment.n_spans;
    for (int s = 0; s < assignment.n_spans; s++)
        list->slots.span[s] = span_of(&assignment, s, p->count);
    fill_first(&list->slots, &assignment);
    return STATUS_OK;
}

static enum status assign_wall(struct contact_list *list, int dimension)
{
    list->n_sets = (list->count + SET_WIDTH - 1) / SET_WIDTH;
    for (int k = 0; k < list->count; k++)
        list->slot[k] = 2 * (uint32_t)k;
    return slots_reserve(list, dimension);
}

/* First all slots, then those of the members. */
static void fill_all(struct filling *f, team_range_task *empty, team_range_task *fill)
{
    team_run_ranges(f->list->team, f->list->n_sets * SET_WIDTH, FILL_GRAIN, empty, f);
    team_run_ranges(f->list->team, f->list->count, FILL_GRAIN, fill, f);
}

/* Two walls of a large sample may be at work at the same time. */
static uint32_t padding_of(const struct particles *p, const struct wall *wall)
{
    const bool shared = !wall || p->count < PARTICLES_LARGE_SAMPLE;
    return (uint32_t)(shared ? particles_padding(p) : particles_spare_padding(p, 1 + (wall->inward < 0)));
}

enum status contact_list_place(struct contact_list *list, const struct particles *particles, const struct wall *wall)
{
    const uint32_t stride = RECORD_STRIDE(particles->dimension, particles->n_rotations > 0, particles->mixed);
    if (list->count > INT32_MAX / (4 * SET_WIDTH))
        return status_fail(STATUS_LIMIT, "%d candidates for contact are too many", list->count);
    list->closed = true;
    list->slots.unit = list->model.mixed ? particles->quantum : 1;
    list->slots.force_unit = particles->force_unit;
    TRY(wall ? assign_wall(list, particles->dimension) : assign_pairs(list, particles));
    if (list->count == 0)
        return STATUS_OK;
    /* nothing: no reach, and for walls less than none, for they know no distance to the padding particle */
    struct filling f = {list, particles, wall, stride, stride * padding_of(particles, wall), wall ? -1e30 : 0, 0};
    fill_all(&f, empty_slots, fill_slots);
    if (list->model.traits & NORMAL_PER_PAIR)
        fill_all(&f, empty_pair_constants, fill_pair_constants);
    return STATUS_OK;
}

enum status contact_list_close(struct contact_list *list, const struct particles *particles, const struct wall *wall)
{
    TRY(contact_list_place(list, particles, wall));
    struct filling f = {.list = list};
    for (f.column = 0; list->count && f.column < HISTORY_COLUMNS; f.column++)
        if (history_has(&list->model, f.column))
            fill_all(&f, empty_column, fill_column);
    for (int c = 0; c < HISTORY_COLUMNS; c++) /* the slots have it now */
        array_forget(list->history[c], sizeof(double), (size_t)list->count);
    return STATUS_OK;
}

double contact_list_value(const struct contact_list *list, int c, int k)
{
    const struct contact_column column = contact_column_of(list, c);
    return contact_column_value(&column, list, k);
}

double contact_list_whole(const struct contact_list *list, int c, int k)
{
    const int rest = history_field(c)->rest;
    const double value = contact_list_value(list, c, k);
    return list->model.mixed && rest ? value + contact_list_value(list, rest, k) : value;
}

double contact_list_spring(const struct contact_list *list, int component, int k)
{
    const bool force = list->model.traits & NORMAL_MINDLIN;
    return contact_list_whole(list, (force ? HISTORY_FORCE : HISTORY_SPRING) + component, k);
}

bool contact_list_slides(const struct contact_list *list, int k)
{
    return contact_list_value(list, HISTORY_SLIDING, k) > 0;
}

void contact_list_read_column(struct contact_list *list, int c)
{
    if (!list->closed || !history_has(&list->model, c))
        return;
    const struct contact_column column = contact_column_of(list, c);
    for (int k = 0; k < list->count; k++)
        list->history[c][k] = contact_column_value(&column, list, k);
}

void contact_list_read(struct contact_list *list)
{
    for (int c = 0; c < HISTORY_COLUMNS; c++)
        contact_list_read_column(list, c);
}

void contact_list_forget_column(struct contact_list *list, int c)
{
    if (list->closed)
        array_forget(list->history[c], sizeof(double), (size_t)list->count);
}
