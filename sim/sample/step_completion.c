#include "sim/sample/step_completion.h"

#include <string.h>

void step_pair_forces(struct sample *sample, double dt)
{
    struct contact_losses lost = {0};
    threads_pair(&sample->threads, &sample->kernels, &sample->particles, &sample->pairs, &sample->law, dt, &lost);
    contact_losses_add(&sample->ledger.contacts, &lost);
}

struct kick_constants step_kick_constants(const struct sample *sample, double dt)
{
    struct kick_constants constants = {
        .dt = dt, .gamma_b = sample->material->gamma_b_kg_per_s, .gamma_br = sample->material->gamma_br_kg_per_s};
    memcpy(constants.gravity, sample->gravity, sizeof constants.gravity);
    return constants;
}

void step_kick(struct sample *sample, double dt)
{
    struct kick_constants constants = step_kick_constants(sample, dt);
    sample->ledger.background += dt * threads_kick(&sample->threads, &sample->kernels, &sample->particles, &constants);
}

struct complete_sample sample_complete(struct sample *sample)
{
    if (sample->open) {
        sample->open = false;
        step_pair_forces(sample, sample->dt);
        step_kick(sample, sample->dt);
        particles_export_positions(&sample->particles);
    }
    return (struct complete_sample){sample};
}
