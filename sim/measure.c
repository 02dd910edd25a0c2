#include "sim/measure.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sim/contact_law.h"

/* Geometry of a candidate: overlap (<= 0: open), unit normal from j or the wall to i, and distance along it. */
struct geometry {
    double overlap, n[3], distance;
};

static struct geometry pair_geometry(const struct particles *p, int i, int j)
{
    struct geometry g = {0};
    double d2 = 0;
    for (int c = 0; c < p->dimension; c++) {
        g.n[c] = p->x[c][i] - p->x[c][j];
        d2 += g.n[c] * g.n[c];
    }
    g.distance = sqrt(d2);
    for (int c = 0; c < p->dimension; c++)
        g.n[c] *= 1 / g.distance;
    g.overlap = p->radius[i] + p->radius[j] - g.distance;
    return g;
}

static struct geometry wall_geometry(const struct particles *p, int i, const struct wall *wall)
{
    struct geometry g = {0};
    g.n[wall->axis] = wall->inward;
    g.distance = wall->inward * (p->x[wall->axis][i] - wall->x);
    g.overlap = p->radius[i] - g.distance;
    return g;
}

/* List l of the world: 0 the pairs, 1 + w those of wall w. */
static const struct contact_list *list_of(const struct world *world, int l)
{
    return l == 0 ? &world->pairs : &world->walls[l - 1].contacts;
}

static struct geometry geometry_of(const struct world *world, int l, int k)
{
    const struct contact_list *list = list_of(world, l);
    if (l == 0)
        return pair_geometry(&world->particles, list->i[k], list->j[k]);
    return wall_geometry(&world->particles, list->i[k], &world->walls[l - 1]);
}

double measure_kinetic_energy_j(const struct world *world)
{
    world_settle(world);
    const struct particles *p = &world->particles;
    double sum = 0;
    for (int c = 0; c < p->dimension; c++)
        for (int i = 0; i < p->count; i++)
            sum += p->mass[i] * p->v[c][i] * p->v[c][i];
    for (int c = 0; c < p->n_rotations; c++)
        for (int i = 0; i < p->count; i++)
            sum += p->omega[c][i] * p->omega[c][i] / p->inv_inertia[i];
    return 0.5 * sum;
}

double measure_potential_energy_j(const struct world *world)
{
    const struct particles *p = &world->particles;
    double sum = 0;
    for (int c = 0; c < p->dimension; c++)
        for (int i = 0; world->gravity[c] != 0 && i < p->count; i++)
            sum -= p->mass[i] * world->gravity[c] * p->x[c][i];
    return sum;
}

/* What one contact does at the current step, from the state alone, so that the kernels need not keep it. Force on i and
 * its tangential part [N], elastic part of the normal force, energy in the tangential spring. */
struct contact_forces {
    double total[3], tangential[3];
    double normal, elastic, spring_energy;
};

/* Velocity of i against j or the wall at the contact: normal part u, tangential part vt (2D: vt[0] along (-n1, n0)). */
static double relative_velocity(const struct world *world, int l, int k, const double *n, double *vt)
{
    const struct particles *p = &world->particles;
    const struct contact_list *list = list_of(world, l);
    const struct wall *wall = l > 0 ? &world->walls[l - 1] : NULL;
    int i = list->i[k], j = list->j[k];
    double v[3] = {0}, w[3] = {0}, u = 0;
    for (int c = 0; c < p->dimension; c++) {
        v[c] = p->v[c][i] - (!wall ? p->v[c][j] : wall->axis == c ? wall->v : 0);
        u += v[c] * n[c];
    }
    for (int c = 0; c < p->n_rotations; c++)
        w[c] = p->radius[i] * p->omega[c][i] + (wall ? 0 : p->radius[j] * p->omega[c][j]);
    if (p->dimension == 2) {
        vt[0] = v[1] * n[0] - v[0] * n[1] - w[0];
    } else {
        vt[0] = v[0] + (n[1] * w[2] - n[2] * w[1]) - u * n[0];
        vt[1] = v[1] + (n[2] * w[0] - n[0] * w[2]) - u * n[1];
        vt[2] = v[2] + (n[0] * w[1] - n[1] * w[0]) - u * n[2];
    }
    return u;
}

static struct contact_forces contact_forces(const struct world *world, int l, int k, const struct geometry *g)
{
    const struct contact_list *list = list_of(world, l);
    const struct contact_law_constants *law = &world->law;
    const double *n = g->n;
    struct contact_forces f = {0};
    double vt[3], ft[3], u = relative_velocity(world, l, k, n, vt);
    f.elastic =
        list->hysteretic ? contact_elastic_force(law, g->overlap, contact_list_history(list, k)) : law->k1 * g->overlap;
    f.normal = f.elastic - law->gamma_n * u;
    for (int c = 0; c < list->n_springs; c++) {
        double xi = contact_list_spring(list, c, k) -
                    0.5 * world->dt * vt[c]; /* it is kept for the middle of the step to come */
        ft[c] = -law->kt * xi - law->gamma_t * vt[c];
        f.spring_energy += 0.5 * law->kt * xi * xi;
    }
    if (list->n_springs == 1) {
        f.tangential[0] = -ft[0] * n[1];
        f.tangential[1] = ft[0] * n[0];
    } else if (list->n_springs == 3) {
        memcpy(f.tangential, ft, sizeof ft);
    }
    for (int c = 0; c < world->particles.dimension; c++)
        f.total[c] = f.normal * n[c] + f.tangential[c];
    return f;
}

static void add_elastic(const struct world *world, int l, struct elastic_energy *sum)
{
    const struct contact_list *list = list_of(world, l);
    for (int k = 0; k < list->count; k++) {
        struct geometry g = geometry_of(world, l, k);
        if (!(g.overlap > 0))
            continue;
        struct contact_forces f = contact_forces(world, l, k, &g);
        sum->normal_j += f.elastic * f.elastic / (2 * world->law.k2);
        sum->tangential_j += f.spring_energy;
    }
}

struct elastic_energy measure_elastic_energy(const struct world *world)
{
    world_settle(world);
    struct elastic_energy sum = {0, 0};
    for (int l = 0; l <= world->n_walls; l++)
        add_elastic(world, l, &sum);
    return sum;
}

void measure_wall_stiffness(const struct world *world, double *stiffness_n_per_m, double *damping_kg_per_s)
{
    for (int w = 0; w < world->n_walls; w++) {
        const struct wall *wall = &world->walls[w];
        const double *x = world->particles.x[wall->axis], *radius = world->particles.radius;
        int touching = 0;
        for (int k = 0; k < wall->contacts.count; k++) {
            int i = wall->contacts.i[k];
            touching += radius[i] > wall->inward * (x[i] - wall->x);
        }
        stiffness_n_per_m[w] = touching * world->law.k2;
        damping_kg_per_s[w] = touching * world->law.gamma_n;
    }
}

/* Contact stress, fabric, overlaps and the state of friction, over one list. */
static void add_contacts(const struct world *world, int l, struct measurement *m, int *sliding)
{
    const struct particles *p = &world->particles;
    const struct contact_list *list = list_of(world, l);
    const int dim = p->dimension;
    const bool pair = l == 0;
    for (int k = 0; k < list->count; k++) {
        struct geometry g = geometry_of(world, l, k);
        if (!(g.overlap > 0))
            continue;
        struct contact_forces f = contact_forces(world, l, k, &g);
        double smaller_radius = pair ? fmin(p->radius[list->i[k]], p->radius[list->j[k]]) : p->radius[list->i[k]];
        m->max_overlap_ratio = fmax(m->max_overlap_ratio, g.overlap / smaller_radius);
        *sliding += pair && list->n_springs && contact_list_slides(list, k);
        m->n_contacts += pair;
        m->n_wall_contacts += !pair;
        for (int a = 0; a < dim; a++)
            for (int b = 0; b < dim; b++) {
                m->stress_contact_pa[a * dim + b] += f.total[a] * g.n[b] * g.distance;
                m->fabric[a * dim + b] += pair ? g.n[a] * g.n[b] : 0;
            }
    }
}

static void measure_box(const struct world *world, struct measurement *m)
{
    const int dim = world->particles.dimension;
    double volume = 1;
    for (int c = 0; c < dim; c++) {
        double start = world->stage_position_m[2 * c + 1] - world->stage_position_m[2 * c];
        m->box_length_m[c] = world_box_length_m(world, c);
        m->strain[c] = world->stage >= 0 ? 1 - m->box_length_m[c] / start : 0;
        volume *= m->box_length_m[c];
    }
    for (int c = 0; c < dim; c++) {
        double area = volume / m->box_length_m[c];
        m->stress_wall_pa[c] = 0.5 * (world->walls[2 * c].force + world->walls[2 * c + 1].force) / area;
    }
    for (int k = 0; k < dim * dim; k++)
        m->stress_contact_pa[k] /= volume;
    m->solid_fraction = particles_solid_volume(&world->particles) / volume;
}

/* Inertial number of the fastest strain rate, p the mean wall stress: 3D |rate| 2 <a> sqrt(rho/p), 2D |rate|
 * sqrt(<m>/p) as the spheres are not as deep as the box. */
static double inertial_number(const struct world *world, const struct measurement *m)
{
    const int dim = world->particles.dimension;
    const struct particles *p = &world->particles;
    double rate = 0, pressure = 0, radius = 0, mass = 0;
    for (int c = 0; c < dim; c++) {
        rate = fmax(rate, fabs(world->walls[2 * c + 1].v - world->walls[2 * c].v) / m->box_length_m[c]);
        pressure += m->stress_wall_pa[c] / dim;
    }
    for (int i = 0; i < p->count; i++) {
        radius += p->radius[i] / p->count;
        mass += p->mass[i] / p->count;
    }
    if (!(pressure > 0))
        return 0;
    return rate *
           (dim == 2 ? sqrt(mass / pressure) : 2 * radius * sqrt(world->scene->sample.density_kg_per_m3 / pressure));
}

/* Contacts of each particle, those with rattlers left out; returns the number of contact ends counted. */
static int count_degrees(const struct contact_measurement *contacts, int n, const bool *rattler, int *degree)
{
    int ends = 0;
    for (int k = 0; k < n; k++) {
        int i = contacts[k].i, j = contacts[k].j;
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
static void remove_rattlers(const struct world *world, const struct contact_measurement *contacts, int n, bool *rattler,
                            int *degree, struct measurement *m)
{
    const int count = world->particles.count;
    const int needed = world->particles.dimension + (world->particles.n_rotations ? 0 : 1);
    int held = count, ends = 0, removed = 1;
    while (removed) {
        memset(degree, 0, (size_t)count * sizeof *degree);
        ends = count_degrees(contacts, n, rattler, degree);
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

static enum status measure_coordination(const struct world *world, struct measurement *m)
{
    const int count = world->particles.count, n = m->n_contacts + m->n_wall_contacts;
    struct contact_measurement *contacts = malloc((size_t)(n + 1) * sizeof *contacts);
    int *degree = calloc((size_t)count, sizeof *degree);
    bool *rattler = calloc((size_t)count, sizeof *rattler);
    enum status status = STATUS_OK;
    m->coordination = (2.0 * m->n_contacts + m->n_wall_contacts) / count;
    if (contacts && degree && rattler) {
        measure_contacts(world, contacts);
        remove_rattlers(world, contacts, n, rattler, degree, m);
    } else {
        status = status_fail(STATUS_NO_MEMORY, "out of memory");
    }
    free(contacts);
    free(degree);
    free(rattler);
    return status;
}

static void measure_energies(const struct world *world, struct measurement *m)
{
    const struct ledger *ledger = &world->ledger;
    struct elastic_energy elastic = measure_elastic_energy(world);
    m->kinetic_j = measure_kinetic_energy_j(world);
    m->elastic_normal_j = elastic.normal_j;
    m->elastic_tangential_j = elastic.tangential_j;
    m->work_gravity_j = ledger->potential_start - measure_potential_energy_j(world);
    double stored =
        m->kinetic_j - ledger->kinetic_start + elastic.normal_j + elastic.tangential_j - ledger->elastic_start;
    double lost = ledger->contacts.hysteresis + ledger->contacts.viscous_normal + ledger->contacts.viscous_tangential +
                  ledger->contacts.friction + ledger->background;
    m->residual_j = ledger->work_walls + m->work_gravity_j - stored - lost;
}

enum status measure(const struct world *world, struct measurement *m)
{
    world_settle(world);
    int sliding = 0;
    memset(m, 0, sizeof *m);
    add_contacts(world, 0, m, &sliding);
    for (int k = 0; m->n_contacts && k < 9; k++)
        m->fabric[k] /= m->n_contacts;
    for (int w = 0; w < world->n_walls; w++)
        add_contacts(world, 1 + w, m, &sliding);
    m->sliding_fraction = m->n_contacts ? (double)sliding / m->n_contacts : 0;
    measure_box(world, m);
    m->inertial_number = inertial_number(world, m);
    measure_energies(world, m);
    if (!isfinite(m->kinetic_j) || !isfinite(m->elastic_normal_j) || !isfinite(m->residual_j))
        return status_fail(STATUS_UNSTABLE, "step %lld (t = %g s): the energy is not finite; a smaller dt_s would help",
                           (long long)world->step, world->time_s);
    return measure_coordination(world, m);
}

static void fill_contact(const struct world *world, int l, int k, const struct geometry *g,
                         struct contact_measurement *out)
{
    const struct contact_list *list = list_of(world, l);
    const int dim = world->particles.dimension;
    struct contact_forces f = contact_forces(world, l, k, g);
    const int32_t *id = world->particles.id;
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

int measure_contacts(const struct world *world, struct contact_measurement *out)
{
    world_settle(world);
    int n = 0;
    for (int l = 0; l <= world->n_walls; l++) {
        const int first = n;
        for (int k = 0; k < list_of(world, l)->count; k++) {
            struct geometry g = geometry_of(world, l, k);
            if (!(g.overlap > 0))
                continue;
            if (out)
                fill_contact(world, l, k, &g, &out[n]);
            n++;
        }
        if (out)
            sort_contacts(out + first, n - first);
    }
    return n;
}
