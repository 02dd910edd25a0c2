#include "sim/sample/energy.h"

#include "sim/sample/contact_state.h"

double energy_kinetic_j(struct complete_sample whole)
{
    const struct particles *p = &whole.sample->particles;
    double sum = 0;
    for (int c = 0; c < p->dimension; c++)
        for (int i = 0; i < p->count; i++)
            sum += p->mass[i] * p->v[c][i] * p->v[c][i];
    for (int c = 0; c < p->n_rotations; c++)
        for (int i = 0; i < p->count; i++)
            sum += p->omega[c][i] * p->omega[c][i] / p->inv_inertia[i];
    return 0.5 * sum;
}

double energy_potential_j(struct complete_sample whole)
{
    const struct sample *sample = whole.sample;
    const struct particles *p = &sample->particles;
    double sum = 0;
    for (int c = 0; c < p->dimension; c++)
        for (int i = 0; sample->gravity[c] != 0 && i < p->count; i++)
            sum -= p->mass[i] * sample->gravity[c] * p->x[c][i];
    return sum;
}

struct held_energy energy_held(struct complete_sample whole)
{
    return (struct held_energy){energy_kinetic_j(whole), contact_state_elastic_j(whole)};
}

struct ledger energy_ledger_start(struct complete_sample whole)
{
    const struct held_energy held = energy_held(whole);
    return (struct ledger){
        .kinetic_start = held.kinetic_j, .elastic_start = held.elastic_j, .potential_start = energy_potential_j(whole)};
}
