#include "sim/grains/particle_order.h"

enum status particles_set_slots(struct particles *p)
{
    for (int k = 0; k < p->count; k++)
        p->slot[k] = -1;
    for (int k = 0; k < p->count; k++) {
        if (p->id[k] < 0 || p->id[k] >= p->count || p->slot[p->id[k]] >= 0)
            return status_fail(STATUS_FORMAT, "the ids of the particles are not each there once");
        p->slot[p->id[k]] = k;
    }
    return STATUS_OK;
}

void particles_gather_by_id(const struct particles *p, const double *values, int first, int count, double *out)
{
    for (int k = 0; k < count; k++)
        out[k] = values[p->slot[first + k]];
}
