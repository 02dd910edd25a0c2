#include "sim/look/measure.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sim/law/contact_law.h"

/* Compiled for each model: `dim` and `springs` are constants where these functions are called. */
#define FOR_MODEL static inline __attribute__((always_inline))

/* Geometry of a candidate: overlap (<= 0: open), unit normal from j or the wall to i, and distance along it. */
struct geometry {
    double overlap, n[3], distance;
};

FOR_MODEL struct geometry pair_geometry(const struct particles *p, int dim, int i, int j)
{
    struct geometry g = {0};
    double d2 = 0;
    for (int c = 0; c < dim; c++) {
        g.n[c] = p->x[c][i] - p->x[c][j];
        d2 += g.n[c] * g.n[c];
    }
    g.distance = sqrt(d2);
    const double inverse = 1 / g.distance;
    for (int c = 0; c < dim; c++)
        g.n[c] *= inverse;
    g.overlap = p->radius[i] + p->radius[j] - g.distance;
    return g;
}

FOR_MODEL struct geometry wall_geometry(const struct particles *p, int i, const struct wall *wall)
{
    struct geometry g = {0};
    g.n[wall->axis] = wall->inward;
    g.distance = wall->inward * (p->x[wall->axis][i] - wall->x);
    g.overlap = p->radius[i] - g.distance;
    return g;
}

/* List l of the sample: 0 the pairs, 1 + w those of wall w. */
static const struct contact_list *list_of(const struct sample *sample, int l)
{
    return l == 0 ? &sample->pairs : &sample->walls[l - 1].contacts;
}

FOR_MODEL struct geometry geometry_of(const struct sample *sample, int dim, int l, int k)
{
    const struct contact_list *list = list_of(sample, l);
    if (l == 0)
        return pair_geometry(&sample->particles, dim, list->i[k], list->j[k]);
    return wall_geometry(&sample->particles, list->i[k], &sample->walls[l - 1]);
}

double measure_kinetic_energy_j(const struct sample *sample)
{
    sample_complete(sample);
    const struct particles *p = &sample->particles;
    double sum = 0;
    for (int c = 0; c < p->dimension; c++)
        for (int i = 0; i < p->count; i++)
            sum += p->mass[i] * p->v[c][i] * p->v[c][i];
    for (int c = 0; c < p->n_rotations; c++)
        for (int i = 0; i < p->count; i++)
            sum += p->omega[c][i] * p->omega[c][i] / p->inv_inertia[i];
    return 0.5 * sum;
}

double measure_potential_energy_j(const struct sample *sample)
{
    const struct particles *p = &sample->particles;
    double sum = 0;
    for (int c = 0; c < p->dimension; c++)
        for (int i = 0; sample->gravity[c] != 0 && i < p->count; i++)
            sum -= p->mass[i] * sample->gravity[c] * p->x[c][i];
    return sum;
}

/* What one contact does at the current step, from the state alone, so that the kernels need not keep it. Force on i and
 * its tangential part [N], elastic part of the normal force, energy in the tangential spring. */
struct contact_forces {
    double total[3], tangential[3];
    double normal, elastic, spring_energy;
};

/* Velocity of i against j or the wall at the contact: normal part u, tangential part vt (2D: vt[0] along (-n1, n0)). */
FOR_MODEL double relative_velocity(const struct sample *sample, int dim, int springs, int l, int k, const double *n,
                                   double *vt)
{
    const struct particles *p = &sample->particles;
    const struct contact_list *list = list_of(sample, l);
    const struct wall *wall = l > 0 ? &sample->walls[l - 1] : NULL;
    int i = list->i[k], j = list->j[k];
    double v[3] = {0}, w[3] = {0}, u = 0;
    for (int c = 0; c < dim; c++) {
        v[c] = p->v[c][i] - (!wall ? p->v[c][j] : wall->axis == c ? wall->v : 0);
        u += v[c] * n[c];
    }
    for (int c = 0; c < springs; c++)
        w[c] = p->radius[i] * p->omega[c][i] + (wall ? 0 : p->radius[j] * p->omega[c][j]);
    if (dim == 2) {
        vt[0] = v[1] * n[0] - v[0] * n[1] - w[0];
    } else {
        vt[0] = v[0] + (n[1] * w[2] - n[2] * w[1]) - u * n[0];
        vt[1] = v[1] + (n[2] * w[0] - n[0] * w[2]) - u * n[1];
        vt[2] = v[2] + (n[0] * w[1] - n[1] * w[0]) - u * n[2];
    }
    return u;
}

FOR_MODEL struct contact_forces contact_forces(const struct sample *sample, int dim, int springs, int l, int k,
                                               const struct geometry *g)
{
    const struct contact_list *list = list_of(sample, l);
    const struct contact_law_constants *law = &sample->law;
    const double *n = g->n;
    struct contact_forces f = {0};
    double vt[3], ft[3], u = relative_velocity(sample, dim, springs, l, k, n, vt);
    f.elastic =
        list->hysteretic ? contact_elastic_force(law, g->overlap, contact_list_history(list, k)) : law->k1 * g->overlap;
    f.normal = f.elastic - law->gamma_n * u;
    for (int c = 0; c < springs; c++) {
        double xi = contact_list_spring(list, c, k) -
                    0.5 * sample->dt * vt[c]; /* it is kept for the middle of the step to come */
        ft[c] = -law->kt * xi - law->gamma_t * vt[c];
        f.spring_energy += 0.5 * law->kt * xi * xi;
    }
    if (springs == 1) {
        f.tangential[0] = -ft[0] * n[1];
        f.tangential[1] = ft[0] * n[0];
    } else if (springs == 3) {
        memcpy(f.tangential, ft, sizeof ft);
    }
    for (int c = 0; c < dim; c++)
        f.total[c] = f.normal * n[c] + f.tangential[c];
    return f;
}

/* Sums over the contacts of all lists. */
struct survey {
    double elastic_normal_j, elastic_tangential_j;
    double max_overlap_ratio;
    double stress[9], fabric[9]; /* sums over contacts; fabric over those between particles */
    int pairs, walls, sliding;
    int32_t *i, *j; /* touching particles, j < 0: a wall; NULL: not wanted, nor all but the energies */
};

FOR_MODEL void add_state(const struct sample *sample, int dim, int springs, int l, int k, const struct geometry *g,
                         const struct contact_forces *f, struct survey *sum)
{
    const struct particles *p = &sample->particles;
    const struct contact_list *list = list_of(sample, l);
    const bool pair = l == 0;
    const int i = list->i[k], n = sum->pairs + sum->walls;
    double smaller_radius = p->radius[i];
    if (pair && p->radius[list->j[k]] < smaller_radius)
        smaller_radius = p->radius[list->j[k]];
    if (g->overlap > sum->max_overlap_ratio * smaller_radius)
        sum->max_overlap_ratio = g->overlap / smaller_radius;
    sum->sliding += pair && springs && contact_list_slides(list, k);
    sum->i[n] = i;
    sum->j[n] = pair ? list->j[k] : -1;
    sum->pairs += pair;
    sum->walls += !pair;
    for (int a = 0; a < dim; a++)
        for (int b = 0; b < dim; b++) {
            sum->stress[a * dim + b] += f->total[a] * g->n[b] * g->distance;
            if (pair)
                sum->fabric[a * dim + b] += g->n[a] * g->n[b];
        }
}

FOR_MODEL void survey_list(const struct sample *sample, int dim, int springs, int l, bool state, struct survey *result)
{
    const int count = list_of(sample, l)->count;
    struct survey sum = *result;
    for (int k = 0; k < count; k++) {
        const struct geometry g = geometry_of(sample, dim, l, k);
        if (!(g.overlap > 0))
            continue;
        const struct contact_forces f = contact_forces(sample, dim, springs, l, k, &g);
        sum.elastic_normal_j += f.elastic * f.elastic;
        sum.elastic_tangential_j += f.spring_energy;
        if (state)
            add_state(sample, dim, springs, l, k, &g, &f, &sum);
    }
    *result = sum;
}

FOR_MODEL void survey_lists(const struct sample *sample, int dim, int springs, bool state, struct survey *sum)
{
    for (int l = 0; l <= sample->n_walls; l++)
        survey_list(sample, dim, springs, l, state, sum);
    if (sum->elastic_normal_j > 0) /* before the first stage there is no law */
        sum->elastic_normal_j /= 2 * sample->law.k2;
}

/* `state`: with all but the energies, too. */
static void survey(const struct sample *sample, bool state, struct survey *sum)
{
    switch (10 * sample->particles.dimension + sample->pairs.n_springs) {
    case 20:
        state ? survey_lists(sample, 2, 0, true, sum) : survey_lists(sample, 2, 0, false, sum);
        break;
    case 21:
        state ? survey_lists(sample, 2, 1, true, sum) : survey_lists(sample, 2, 1, false, sum);
        break;
    case 30:
        state ? survey_lists(sample, 3, 0, true, sum) : survey_lists(sample, 3, 0, false, sum);
        break;
    default:
        state ? survey_lists(sample, 3, 3, true, sum) : survey_lists(sample, 3, 3, false, sum);
        break;
    }
}

struct held_energy measure_held_energy(const struct sample *sample)
{
    struct survey sum = {0};
    sample_complete(sample);
    survey(sample, false, &sum);
    return (struct held_energy){measure_kinetic_energy_j(sample), sum.elastic_normal_j + sum.elastic_tangential_j};
}

void measure_wall_stiffness(const struct sample *sample, double *stiffness_n_per_m, double *damping_kg_per_s)
{
    for (int w = 0; w < sample->n_walls; w++) {
        stiffness_n_per_m[w] = sample->walls[w].touching * sample->law.k2;
        damping_kg_per_s[w] = sample->walls[w].touching * sample->law.gamma_n;
    }
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

/* Inertial number of the fastest strain rate, p the mean wall stress: 3D |rate| 2 <a> sqrt(rho/p), 2D |rate|
 * sqrt(<m>/p) as the spheres are not as deep as the box. */
static double inertial_number(const struct sample *sample, const struct measurement *m)
{
    const int dim = sample->particles.dimension;
    const struct particles *p = &sample->particles;
    double rate = 0, pressure = 0, radius = 0, mass = 0;
    for (int c = 0; c < dim; c++) {
        rate = fmax(rate, fabs(sample->walls[2 * c + 1].v - sample->walls[2 * c].v) / m->box_length_m[c]);
        pressure += m->stress_wall_pa[c] / dim;
    }
    for (int i = 0; i < p->count; i++) {
        radius += p->radius[i] / p->count;
        mass += p->mass[i] / p->count;
    }
    if (!(pressure > 0))
        return 0;
    return rate *
           (dim == 2 ? sqrt(mass / pressure) : 2 * radius * sqrt(sample->scene->sample.density_kg_per_m3 / pressure));
}

/* Contacts of each particle, those with rattlers left out; returns the number of contact ends counted. */
static int count_degrees(const struct survey *contacts, const bool *rattler, int *degree)
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
static void remove_rattlers(const struct sample *sample, const struct survey *contacts, bool *rattler, int *degree,
                            struct measurement *m)
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

static void measure_energies(const struct sample *sample, const struct survey *contacts, struct measurement *m)
{
    const struct ledger *ledger = &sample->ledger;
    m->kinetic_j = measure_kinetic_energy_j(sample);
    m->elastic_normal_j = contacts->elastic_normal_j;
    m->elastic_tangential_j = contacts->elastic_tangential_j;
    m->work_gravity_j = ledger->potential_start - measure_potential_energy_j(sample);
    double stored =
        m->kinetic_j - ledger->kinetic_start + m->elastic_normal_j + m->elastic_tangential_j - ledger->elastic_start;
    double lost = ledger->contacts.hysteresis + ledger->contacts.viscous_normal + ledger->contacts.viscous_tangential +
                  ledger->contacts.friction + ledger->background;
    m->residual_j = ledger->work_walls + m->work_gravity_j - stored - lost;
}

static void measure_contact_state(const struct sample *sample, const struct survey *contacts, struct measurement *m)
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
        n += (size_t)list_of(sample, l)->count;
    return n;
}

enum status measure(const struct sample *sample, struct measurement *m)
{
    const size_t count = (size_t)sample->particles.count, n = candidates(sample) + 1;
    int32_t *touching = malloc(2 * n * sizeof *touching);
    int *degree = malloc(count * sizeof *degree);
    bool *rattler = calloc(count, sizeof *rattler);
    struct survey contacts = {.i = touching, .j = touching ? touching + n : NULL};
    const bool memory = touching && degree && rattler;
    memset(m, 0, sizeof *m);
    if (memory) {
        sample_complete(sample);
        survey(sample, true, &contacts);
        measure_contact_state(sample, &contacts, m);
        measure_box(sample, m);
        m->inertial_number = inertial_number(sample, m);
        measure_energies(sample, &contacts, m);
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

static void fill_contact(const struct sample *sample, int l, int k, const struct geometry *g,
                         struct contact_measurement *out)
{
    const struct contact_list *list = list_of(sample, l);
    const int dim = sample->particles.dimension;
    struct contact_forces f = contact_forces(sample, dim, list->n_springs, l, k, g);
    const int32_t *id = sample->particles.id;
    const int i = id[list->i[k]], j = l == 0 ? id[list->j[k]] : -l;
    const double sign = l == 0 && i > j ? -1 : 1; /* after renumbering they may stand the other way round */
    *out = (struct contact_measurement){.i = sign > 0 ? i : j,
                                        .j = sign > 0 ? j : i,
                                        .overlap_m = g->overlap,
                                        .normal_force_n = f.normal,
                                        .sliding = list->n_springs && contact_list_slides(list, k)};
    for (int c = 0; c < dim; c++) {
        out->normal[c] = sign * g->n[c];
        out->tangential_force_n[c] = sign * f.tangential[c];
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

int measure_contacts(const struct sample *sample, struct contact_measurement *out)
{
    sample_complete(sample);
    int n = 0;
    for (int l = 0; l <= sample->n_walls; l++) {
        const int first = n;
        for (int k = 0; k < list_of(sample, l)->count; k++) {
            struct geometry g = geometry_of(sample, sample->particles.dimension, l, k);
            if (!(g.overlap > 0))
                continue;
            if (out)
                fill_contact(sample, l, k, &g, &out[n]);
            n++;
        }
        if (out)
            sort_contacts(out + first, n - first);
    }
    return n;
}
