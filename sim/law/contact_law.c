#include "sim/law/contact_law.h"

struct contact_law_constants contact_law_constants_of(const struct scene_material *m)
{
    bool linear = m->law == LAW_LINEAR;
    struct contact_law_constants law = {
        .k1 = linear ? m->kn_n_per_m : m->k1_n_per_m,
        .k2 = linear ? m->kn_n_per_m : m->k2_n_per_m,
        .kc = linear ? 0 : m->kc_n_per_m,
        .gamma_n = m->gamma_n_kg_per_s,
        .mu_s = m->mu_s,
        .mu_d = m->mu_d,
        .kt = m->kt_n_per_m,
        .inv_kt = m->kt_n_per_m > 0 ? 1 / m->kt_n_per_m : 0,
        .gamma_t = m->gamma_t_kg_per_s,
    };
    law.k2_minus_k1 = law.k2 - law.k1;
    law.branch_ratio = law.k2_minus_k1 > 0 ? (law.k2 + law.kc) / law.k2_minus_k1 : 0;
    double delta_min_ratio = law.k2_minus_k1 / (law.k2 + law.kc); /* delta_min = ratio delta_max [LH] */
    law.loading_loss = 0.5 * law.k1 * (1 - law.k1 / law.k2);
    law.adhesion_loss = 0.5 * law.kc * (1 + law.kc / law.k2) * delta_min_ratio * delta_min_ratio;
    return law;
}

void contact_losses_add(struct contact_losses *sum, const struct contact_losses *lost)
{
    sum->hysteresis += lost->hysteresis;
    sum->viscous_normal += lost->viscous_normal;
    sum->viscous_tangential += lost->viscous_tangential;
    sum->friction += lost->friction;
}
