#include "sim/measure/measure.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sim/sample/contact_state.h"
#include "sim/sample/energy.h"

static const double PI = 3.14159265358979323846;

/* Of all particles, in 2D too [m^3]. */
static double sphere_volume(const struct particles *p)
{
    double sum = 0;
    for (int i = 0; i < p->count; i++)
        sum += p->radius[i] * p->radius[i] * p->radius[i];
    return 4 * PI / 3 * sum;
}

static void measure_box(const struct sample *sample, struct measurement *m)
{
    const int dim = sample->particles.dimension;
    double volume = 1;
    for (int c = 0; c < dim; c++) {
        double start = sample->stage_position_m[2 * c + 1] - sample->stage_position_m[2 * c];
        m->box_length_m[c] = sample_box_length_m(sample, c);
        m->strain[c] = sample->stage >= 0 ? 1 - m->box_length_m[c] / start : 0;
        volume *= m->box_length_m[c];
    }
    for (int c = 0; c < dim; c++) {
        double area = volume / m->box_length_m[c];
        m->stress_wall_pa[c] = 0.5 * (sample->walls[2 * c].force + sample->walls[2 * c + 1].force) / area;
    }
    for (int k = 0; k < dim * dim; k++)
        m->stress_contact_pa[k] /= volume;
    m->solid_fraction = particles_solid_volume(&sample->particles) / volume;
}

double measure_inertial_number(const struct sample *sample)
{
    const int dim = sample->particles.dimension;
    const struct particles *p = &sample->particles;
    double rate = 0, pressure = 0, radius = 0, mass = 0, volume = 1;
    for (int c = 0; c < dim; c++)
        volume *= sample_box_length_m(sample, c);
    for (int c = 0; c < dim; c++) {
        const double length = sample_box_length_m(sample, c);
        rate = fmax(rate, fabs(sample->walls[2 * c + 1].v - sample->walls[2 * c].v) / length);
        pressure += 0.5 * (sample->walls[2 * c].force + sample->walls[2 * c + 1].force) * length / volume / dim;
    }
    for (int i = 0; i < p->count; i++) {
        radius += p->radius[i] / p->count;
        mass += p->mass[i] / p->count;
    }
    if (!(pressure > 0))
        return 0;
    /* the density is that of the particles: a sample from a checkpoint may have another than the scene */
    const double density = mass * p->count / sphere_volume(p);
    return rate * (dim == 2 ? sqrt(mass / pressure) : 2 * radius * sqrt(density / pressure));
}

double measure_turnover_j(const struct sample *sample, const struct measurement *m)
{
    const struct ledger *ledger = &sample->ledger;
    const struct contact_losses *lost = &ledger->contacts;
    const double work = fabs(ledger->work_walls) + fabs(m->work_gravity_j) + fabs(ledger->work_material);
    const double losses = fabs(lost->hysteresis) + fabs(lost->viscous_normal) + fabs(lost->viscous_tangential) +
                          fabs(lost->friction) + fabs(lost->stiffness) + fabs(lost->rolling) +
                          fabs(lost->viscous_rolling) + fabs(ledger->background);
    const double elastic = m->elastic_normal_j + m->elastic_tangential_j;
    const double stored = fabs(m->kinetic_j - ledger->kinetic_start) + fabs(elastic - ledger->elastic_start);
    return fmax(fmax(work, losses), fmax(stored, ledger->kinetic_start));
}

/* A residual of 1 % of it is 1e-5 of the energy held, which goes with the square of the stress. */
const double MEASURE_HELD_PART = 1e-3;

double measure_ledger_scale_j(const struct sample *sample, const struct measurement *m)
{
    const struct ledger *ledger = &sample->ledger;
    const double now = m->kinetic_j + m->elastic_normal_j + m->elastic_tangential_j;
    const double held = fmax(now, ledger->kinetic_start + ledger->elastic_start);
    return fmax(measure_turnover_j(sample, m), MEASURE_HELD_PART * held);
}

/* Contacts of each particle, those with rattlers left out; returns the number of contact ends counted. */
static int count_degrees(const struct contact_survey *contacts, const bool *rattler, int *degree)
{
    int ends = 0;
    for (int k = 0; k < contacts->pairs + contacts->walls; k++) {
        int i = contacts->i[k], j = contacts->j[k];
        if (rattler[i] || (j >= 0 && rattler[j]))
            continue;
        degree[i]++;
        ends++;
        if (j >= 0) {
            degree[j]++;
            ends++;
        }
    }
    return ends;
}

/* Rattlers: a particle needs dimension contacts to be held with friction, one more without; taken out until nothing
 * changes. Scratch: rattler and degree [count], zeroed. */
static void remove_rattlers(const struct sample *sample, const struct contact_survey *contacts, bool *rattler,
                            int *degree, struct measurement *m)
{
    const int count = sample->particles.count;
    const int needed = sample->particles.dimension + (sample->particles.n_rotations ? 0 : 1);
    int held = count, ends = 0, removed = 1;
    while (removed) {
        memset(degree, 0, (size_t)count * sizeof *degree);
        ends = count_degrees(contacts, rattler, degree);
        removed = 0;
        for (int i = 0; i < count; i++)
            if (!rattler[i] && degree[i] < needed) {
                rattler[i] = true;
                removed++;
            }
        held -= removed;
    }
    m->coordination_no_rattlers = held ? (double)ends / held : 0;
    m->rattler_fraction = (double)(count - held) / count;
}

static void measure_energies(struct complete_sample whole, const struct contact_survey *contacts, struct measurement *m)
{
    const struct ledger *ledger = &whole.sample->ledger;
    m->kinetic_j = energy_kinetic_j(whole);
    m->elastic_normal_j = contacts->elastic_normal_j;
    m->elastic_tangential_j = contacts->elastic_tangential_j;
    m->work_gravity_j = ledger->potential_start - energy_potential_j(whole);
    double stored =
        m->kinetic_j - ledger->kinetic_start + m->elastic_normal_j + m->elastic_tangential_j - ledger->elastic_start;
    double lost = ledger->contacts.hysteresis + ledger->contacts.viscous_normal + ledger->contacts.viscous_tangential +
                  ledger->contacts.friction + ledger->contacts.stiffness + ledger->contacts.rolling +
                  ledger->contacts.viscous_rolling + ledger->background;
    m->residual_j = ledger->work_walls + m->work_gravity_j + ledger->work_material - stored - lost;
}

static void measure_contact_state(const struct sample *sample, const struct contact_survey *contacts,
                                  struct measurement *m)
{
    m->n_contacts = contacts->pairs;
    m->n_wall_contacts = contacts->walls;
    m->max_overlap_ratio = contacts->max_overlap_ratio;
    m->sliding_fraction = contacts->pairs ? (double)contacts->sliding / contacts->pairs : 0;
    m->coordination = (2.0 * contacts->pairs + contacts->walls) / sample->particles.count;
    memcpy(m->stress_contact_pa, contacts->stress, sizeof m->stress_contact_pa);
    for (int k = 0; contacts->pairs && k < 9; k++)
        m->fabric[k] = contacts->fabric[k] / contacts->pairs;
}

static size_t candidates(const struct sample *sample)
{
    size_t n = 0;
    for (int l = 0; l <= sample->n_walls; l++)
        n += (size_t)sample_list(sample, l)->count;
    return n;
}

enum status measure(struct complete_sample whole, struct measurement *m)
{
    const struct sample *sample = whole.sample;
    const size_t count = (size_t)sample->particles.count, n = candidates(sample) + 1;
    int32_t *touching = malloc(2 * n * sizeof *touching);
    int *degree = malloc(count * sizeof *degree);
    bool *rattler = calloc(count, sizeof *rattler);
    struct contact_survey contacts = {.i = touching, .j = touching ? touching + n : NULL};
    const bool memory = touching && degree && rattler;
    memset(m, 0, sizeof *m);
    if (memory) {
        contact_survey_make(whole, &contacts);
        measure_contact_state(sample, &contacts, m);
        measure_box(sample, m);
        m->inertial_number = measure_inertial_number(sample);
        measure_energies(whole, &contacts, m);
        remove_rattlers(sample, &contacts, rattler, degree, m);
    }
    free(touching);
    free(degree);
    free(rattler);
    if (!memory)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    if (!isfinite(m->kinetic_j) || !isfinite(m->elastic_normal_j) || !isfinite(m->residual_j))
        return status_fail(STATUS_UNSTABLE, "step %lld (t = %g s): the energy is not finite; a smaller dt_s would help",
                           (long long)sample->step, sample->time_s);
    return STATUS_OK;
}

static void fill_contact(const struct sample *sample, int l, int k, const struct contact_geometry *g,
                         const struct contact_forces *f, struct contact_measurement *out)
{
    const struct contact_list *list = sample_list(sample, l);
    const int dim = sample->particles.dimension;
    const int32_t *id = sample->particles.id;
    const int i = id[list->i[k]], j = l == 0 ? id[list->j[k]] : -l;
    const double sign = l == 0 && i > j ? -1 : 1; /* after renumbering they may stand the other way round */
    *out = (struct contact_measurement){.i = sign > 0 ? i : j,
                                        .j = sign > 0 ? j : i,
                                        .overlap_m = g->overlap,
                                        .normal_force_n = f->normal,
                                        .sliding = list->model.frictional && contact_list_slides(list, k),
                                        .list = l,
                                        .member = k};
    for (int c = 0; c < dim; c++) {
        out->normal[c] = sign * g->n[c];
        out->tangential_force_n[c] = sign * f->tangential[c];
    }
}

static int by_ids(const void *a, const void *b)
{
    const struct contact_measurement *x = a, *y = b;
    return x->i != y->i ? (x->i > y->i) - (x->i < y->i) : (x->j > y->j) - (x->j < y->j);
}

/* Contacts of one list by their ids; they are so already unless particles were renumbered. */
static void sort_contacts(struct contact_measurement *contacts, int n)
{
    for (int k = 1; k < n; k++)
        if (by_ids(&contacts[k - 1], &contacts[k]) > 0) {
            qsort(contacts, (size_t)n, sizeof *contacts, by_ids);
            return;
        }
}

int measure_contacts(struct complete_sample whole, struct contact_measurement *out)
{
    const struct sample *sample = whole.sample;
    struct contact_geometry g;
    struct contact_forces f;
    int n = 0;
    for (int l = 0; l <= sample->n_walls; l++) {
        const int first = n;
        for (int k = 0; k < sample_list(sample, l)->count; k++) {
            if (!contact_state_at(whole, l, k, &g, &f))
                continue;
            if (out)
                fill_contact(sample, l, k, &g, &f, &out[n]);
            n++;
        }
        if (out)
            sort_contacts(out + first, n - first);
    }
    return n;
}

/* In 2D the particles turn about x cross z = -y. */
int measure_contact_history(const struct sample *sample, const struct contact_measurement *contact, int column,
                            double *value)
{
    const struct contact_list *list = sample_list(sample, contact->list);
    const enum history_kind kind = history_field(column)->kind;
    const int k = contact->member, values = history_kind_values(kind, sample->particles.dimension);
    const double sign = sample->particles.id[list->i[k]] == contact->i ? 1 : -1;
    if (kind == HISTORY_TANGENT && values == 2) { /* a number along (-n_z, n_x), which turns with i and j */
        const double along = contact_list_whole(list, column, k);
        value[0] = -along * contact->normal[1];
        value[1] = along * contact->normal[0];
        return values;
    }
    for (int c = 0; c < values; c++) {
        const double own = contact_list_whole(list, column + c, k);
        value[c] = kind == HISTORY_NUMBER ? own : kind == HISTORY_ROTATION && values == 1 ? -sign * own : sign * own;
    }
    return values;
}
