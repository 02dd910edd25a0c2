/* Force kernels, written once and compiled for each model and instruction set. The including file defines
 *   ISA         part of the names
 *   DIM         2 | 3
 *   HYSTERETIC  0 | 1
 *   FRICTIONAL  0 | 1
 *
 * Tangential law [D eq. 2-4], second order in time: the spring is kept at the middle of the step, xi(k+1/2) =
 * xi(k-1/2) + v_t(k) dt, and brought to the step's end by xi(k) = xi(k-1/2) + v_t(k) dt/2, with v_t from velocities
 * predicted for the same time as the positions (no half-step lag). */
#include <stdint.h>

#include "sim/contact_law.h"

#define NAME_(stem, isa, dim, h, f) stem##_##isa##_##dim##_##h##_##f
#define NAME__(stem, isa, dim, h, f) NAME_(stem, isa, dim, h, f)
#define NAME(stem) NAME__(stem, ISA, DIM, HYSTERETIC, FRICTIONAL)

/* One contact: geometry and velocities in, force and moment out; history, spring and state change in place.
 * n: normal, g: relative velocity v_i - v_j of the centres, w: a_i omega_i + a_j omega_j, spin: (omega_i + omega_j)/2.
 * `active` is 0 for open candidates: everything is then reset to zero. */
CONTACT_INLINE void NAME(contact)(const struct contact_law_constants *law, double delta, const double *n,
                                  const double *g, const double *w, const double *spin, double *history,
                                  double *spring, int32_t *sliding, double *f, double *moment,
                                  struct contact_losses *lost)
{
    int active = delta > 0;
    double u = g[0] * n[0] + g[1] * n[1];
#if DIM == 3
    u += g[2] * n[2];
#endif
#if HYSTERETIC
    double elastic = hysteretic_force(law, delta, *history);
    double after = active ? hysteretic_history(law, delta, *history) : 0.0;
    lost->hysteresis = hysteretic_loss(law, *history, after);
    *history = after;
#else
    (void)history;
    lost->hysteresis = 0;
    double elastic = law->k1 * delta;
#endif
    double normal_force = elastic - law->gamma_n * u;
    lost->viscous_normal = active ? law->gamma_n * u * u * law->dt : 0.0;
    for (int c = 0; c < DIM; c++)
        f[c] = active ? normal_force * n[c] : 0.0;
    lost->viscous_tangential = 0;
    lost->friction = 0;
#if !FRICTIONAL
    (void)w;
    (void)spin;
    (void)spring;
    (void)sliding;
    (void)moment;
#else
    double limit = friction_normal_force(law, normal_force, delta);
    double half = 0.5 * law->dt;
#if DIM == 2
    /* tangent (-n1, n0); the spring is a number along it, so a rotating pair carries it along by itself */
    double vt[1] = {g[1] * n[0] - g[0] * n[1] - w[0]};
    double before[1] = {spring[0]};
    double xi[1] = {spring[0] + half * vt[0]};
    enum { T = 1 };
    (void)spin;
#else
    /* v_t = g + n x w - u n */
    double vt[3] = {g[0] + (n[1] * w[2] - n[2] * w[1]) - u * n[0], g[1] + (n[2] * w[0] - n[0] * w[2]) - u * n[1],
                    g[2] + (n[0] * w[1] - n[1] * w[0]) - u * n[2]};
    /* into the tangent plane of today, turned with the pair's mean spin about n, length kept */
    double along = spring[0] * n[0] + spring[1] * n[1] + spring[2] * n[2];
    double length2 = spring[0] * spring[0] + spring[1] * spring[1] + spring[2] * spring[2];
    double p[3] = {spring[0] - along * n[0], spring[1] - along * n[1], spring[2] - along * n[2]};
    double twist = law->dt * (spin[0] * n[0] + spin[1] * n[1] + spin[2] * n[2]);
    double before[3] = {p[0] + twist * (n[1] * p[2] - n[2] * p[1]), p[1] + twist * (n[2] * p[0] - n[0] * p[2]),
                        p[2] + twist * (n[0] * p[1] - n[1] * p[0])};
    double projected2 = before[0] * before[0] + before[1] * before[1] + before[2] * before[2];
    double scale = projected2 > 0 ? sqrt(length2 / projected2) : 0.0;
    for (int c = 0; c < 3; c++)
        before[c] *= scale;
    double xi[3] = {before[0] + half * vt[0], before[1] + half * vt[1], before[2] + half * vt[2]};
    enum { T = 3 };
#endif
    double test[T], test2 = 0;
    for (int c = 0; c < T; c++) {
        test[c] = -law->kt * xi[c] - law->gamma_t * vt[c];
        test2 += test[c] * test[c];
    }
    double size = sqrt(test2);
    double bound = (*sliding ? law->mu_d : law->mu_s) * limit;
    int slides = active & (size > bound);
    double factor = slides ? law->mu_d * limit / size : 1.0;
    double ft[T], viscous = 0, friction = 0, stored2 = 0;
    for (int c = 0; c < T; c++) {
        ft[c] = test[c] * factor;
        double slid = -(ft[c] + law->gamma_t * vt[c]) * law->inv_kt;
        double now = slides ? slid : xi[c];
        double slip = xi[c] - now;
        viscous += law->gamma_t * vt[c] * (vt[c] * law->dt - slip);
        friction -= ft[c] * slip;
        stored2 += before[c] * before[c];
        spring[c] = active ? now + half * vt[c] : 0.0;
    }
    *sliding = slides;
    lost->viscous_tangential = active ? viscous : 0.0;
    lost->friction = active ? friction : 0.5 * law->kt * stored2; /* an opening contact loses what its spring held */
    for (int c = 0; c < T; c++)
        ft[c] = active ? ft[c] : 0.0;
#if DIM == 2
    f[0] -= ft[0] * n[1];
    f[1] += ft[0] * n[0];
    moment[0] = ft[0];
#else
    for (int c = 0; c < 3; c++)
        f[c] += ft[c];
    moment[0] = n[1] * ft[2] - n[2] * ft[1];
    moment[1] = n[2] * ft[0] - n[0] * ft[2];
    moment[2] = n[0] * ft[1] - n[1] * ft[0];
#endif
#endif
}

/* What the pair kernel reads and writes, each array under its own restricted pointer. */
struct NAME(view) {
    const int32_t *restrict i, *restrict j;
    const double *restrict radius;
    const double *restrict x[DIM], *restrict v[DIM];
    double *restrict force[DIM];
    double *restrict history;
#if FRICTIONAL
    const double *restrict omega[2 * DIM - 3];
    double *restrict spring[2 * DIM - 3], *restrict moment[2 * DIM - 3];
    int32_t *restrict sliding;
#endif
};

/* Candidate k: gathers both particles, applies the law, stores. */
CONTACT_INLINE struct contact_losses NAME(pair_one)(const struct NAME(view) * view,
                                                    const struct contact_law_constants *law, int k)
{
    int32_t i = view->i[k], j = view->j[k];
    double d[DIM], n[DIM], g[DIM], f[DIM], d2 = 0;
    for (int c = 0; c < DIM; c++) {
        d[c] = view->x[c][i] - view->x[c][j];
        g[c] = view->v[c][i] - view->v[c][j];
        d2 += d[c] * d[c];
    }
    double distance = sqrt(d2);
    double delta = view->radius[i] + view->radius[j] - distance;
    double inverse = 1 / distance;
    for (int c = 0; c < DIM; c++)
        n[c] = d[c] * inverse;
    double history = 0, w[3] = {0}, spin[3] = {0}, s[3] = {0}, m[3] = {0};
    int32_t slides = 0;
    struct contact_losses lost;
#if HYSTERETIC
    history = view->history[k];
#endif
#if FRICTIONAL
    slides = view->sliding[k];
    for (int c = 0; c < 2 * DIM - 3; c++) {
        s[c] = view->spring[c][k];
        w[c] = view->radius[i] * view->omega[c][i] + view->radius[j] * view->omega[c][j];
        spin[c] = 0.5 * (view->omega[c][i] + view->omega[c][j]);
    }
#endif
    NAME(contact)(law, delta, n, g, w, spin, &history, s, &slides, f, m, &lost);
    for (int c = 0; c < DIM; c++)
        view->force[c][k] = f[c];
#if HYSTERETIC
    view->history[k] = history;
#endif
#if FRICTIONAL
    for (int c = 0; c < 2 * DIM - 3; c++) {
        view->spring[c][k] = s[c];
        view->moment[c][k] = m[c];
    }
    view->sliding[k] = slides;
#endif
    return lost;
}

static void NAME(pair)(const struct particles *particles, struct contact_list *pairs,
                       const struct contact_law_constants *law_in, struct contact_losses *losses)
{
    const struct contact_law_constants law = *law_in;
    struct NAME(view) view = {.i = pairs->i, .j = pairs->j, .radius = particles->radius, .history = pairs->history};
    for (int c = 0; c < DIM; c++) {
        view.x[c] = particles->x[c];
        view.v[c] = particles->v[c];
        view.force[c] = pairs->force[c];
    }
#if FRICTIONAL
    for (int c = 0; c < 2 * DIM - 3; c++) {
        view.omega[c] = particles->omega[c];
        view.spring[c] = pairs->spring[c];
        view.moment[c] = pairs->moment[c];
    }
    view.sliding = pairs->sliding;
#endif
    struct contact_losses sum = {0};
    const int count = pairs->count;
    for (int k = 0; k < count; k++) {
        struct contact_losses lost = NAME(pair_one)(&view, &law, k);
        contact_losses_add(&sum, &lost);
    }
    contact_losses_add(losses, &sum);
}

/* The same law against flat walls: delta = a - distance, the wall does not rotate and moves along its normal. */
static void NAME(wall)(const struct particles *particles, struct contact_list *contacts, struct wall *walls, int n_walls,
                       const struct contact_law_constants *law, struct contact_losses *losses)
{
    for (int w = 0; w < n_walls; w++)
        walls[w].force = 0;
    for (int k = 0; k < contacts->count; k++) {
        int32_t i = contacts->i[k];
        struct wall *wall = &walls[contacts->j[k]];
        double n[DIM] = {0}, g[DIM], f[DIM];
        n[wall->axis] = wall->inward;
        for (int c = 0; c < DIM; c++)
            g[c] = particles->v[c][i];
        g[wall->axis] -= wall->v;
        double delta = particles->radius[i] - wall->inward * (particles->x[wall->axis][i] - wall->x);
        double hist = 0, w[3] = {0}, spin[3] = {0}, s[3] = {0}, m[3] = {0};
        int32_t slides = 0;
        struct contact_losses lost;
#if HYSTERETIC
        hist = contacts->history[k];
#endif
#if FRICTIONAL
        slides = contacts->sliding[k];
        for (int c = 0; c < (DIM == 2 ? 1 : 3); c++) {
            s[c] = contacts->spring[c][k];
            w[c] = particles->radius[i] * particles->omega[c][i];
            spin[c] = 0.5 * particles->omega[c][i];
        }
#endif
        NAME(contact)(law, delta, n, g, w, spin, &hist, s, &slides, f, m, &lost);
        for (int c = 0; c < DIM; c++)
            contacts->force[c][k] = f[c];
#if HYSTERETIC
        contacts->history[k] = hist;
#endif
#if FRICTIONAL
        for (int c = 0; c < (DIM == 2 ? 1 : 3); c++) {
            contacts->spring[c][k] = s[c];
            contacts->moment[c][k] = m[c];
        }
        contacts->sliding[k] = slides;
#endif
        wall->force += f[wall->axis] * wall->inward;
        contact_losses_add(losses, &lost);
    }
}
