#include "bench/odd_scene.h"

#include <math.h>
#include <stdbool.h>

static const double PI = 3.14159265358979323846;

/* SplitMix64. */
static uint64_t next(uint64_t *state)
{
    uint64_t z = (*state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

static double uniform(uint64_t *state, double lo, double hi)
{
    return lo + (hi - lo) * (double)(next(state) >> 11) * 0x1p-53;
}

static double between(uint64_t *state, double lo, double hi) /* evenly in the logarithm */
{
    return lo * pow(hi / lo, uniform(state, 0, 1));
}

static bool one_in(uint64_t *state, int n)
{
    return next(state) % (uint64_t)n == 0;
}

/* The scales of a scene, of its smallest particle unless they say otherwise. */
struct scales {
    uint64_t random;
    int dimension, count;
    double radius_m, largest_m, mass_kg, mean_kg, density;
    double contact_s, stiffness; /* duration of a contact [s], k [N/m] */
    double pressure_pa;
    bool frictional;
};

static const char *pick(struct scales *s, const char *const *names, int n)
{
    return names[next(&s->random) % (uint64_t)n];
}

static void scales_draw(struct scales *s)
{
    s->dimension = one_in(&s->random, 2) ? 2 : 3;
    s->count = (int)between(&s->random, 1, one_in(&s->random, 4) ? 2000 : 200);
    s->radius_m = between(&s->random, 1e-9, 1e2);
    s->largest_m =
        fmin(1e3, s->radius_m * (one_in(&s->random, 8) ? between(&s->random, 1, 50) : uniform(&s->random, 1, 3)));
    s->density = between(&s->random, 1, 1e4);
    s->mass_kg = 4 * PI / 3 * s->density * pow(s->radius_m, 3);
    s->mean_kg = s->mass_kg * pow(0.5 * (1 + s->largest_m / s->radius_m), 3);
    s->contact_s = between(&s->random, 1e-9, 10);
    s->stiffness = 0.5 * s->mass_kg * pow(PI / s->contact_s, 2);
    /* the overlap under this pressure, over the radius, is from nothing to all of it */
    const double overlap = between(&s->random, 1e-6, 1);
    s->pressure_pa =
        overlap * s->stiffness * s->radius_m / (s->dimension == 2 ? 2 * s->largest_m : 4 * s->largest_m * s->largest_m);
}

static void sample_write(FILE *out, struct scales *s)
{
    static const char *const starts[] = {"lattice", "random"};
    const double speed =
        one_in(&s->random, 3) ? 0 : fmin(1e3, between(&s->random, 1e-5, 0.3) * s->radius_m / s->contact_s);
    fprintf(out, "sample = { count = %d; radius_min_m = %.17g; radius_max_m = %.17g; density_kg_per_m3 = %.17g; ",
            s->count, s->radius_m, s->largest_m, s->density);
    if (one_in(&s->random, 4))
        fprintf(out, "radius_distribution = \"gaussian\"; radius_mean_m = %.17g; radius_sd_m = %.17g; ",
                0.5 * (s->radius_m + s->largest_m), fmax(1e-3 * s->radius_m, 0.3 * (s->largest_m - s->radius_m)));
    fprintf(
        out,
        "initial = \"%s\"; solid_fraction = %.3g; aspect_ratio = %.3g; gap_ratio = %.3g; speed_m_per_s = %.17g; };\n",
        pick(s, starts, 2), one_in(&s->random, 5) ? between(&s->random, 1e-6, 0.1) : uniform(&s->random, 0.05, 0.35),
        between(&s->random, 0.2, 5), between(&s->random, 1e-3, one_in(&s->random, 6) ? 100 : 1), speed);
}

static void material_write(FILE *out, struct scales *s)
{
    const double k = s->stiffness, critical = 2 * sqrt(k * s->mass_kg);
    fprintf(out, "material = { ");
    if (one_in(&s->random, 2))
        fprintf(out, "law = \"hysteretic\"; k1_n_per_m = %.17g; k2_n_per_m = %.17g; kc_n_per_m = %.17g; ",
                uniform(&s->random, 0.1, 1) * k, k, one_in(&s->random, 2) ? 0 : uniform(&s->random, 0, 4) * k);
    else
        fprintf(out, "kn_n_per_m = %.17g; ", k);
    fprintf(out, "gamma_n_kg_per_s = %.17g; ", one_in(&s->random, 3) ? 0 : between(&s->random, 1e-3, 2) * critical);
    s->frictional = one_in(&s->random, 2);
    if (s->frictional)
        fprintf(out, "mu_s = %.3g; kt_n_per_m = %.17g; gamma_t_kg_per_s = %.17g; gamma_br_kg_per_s = %.17g; ",
                between(&s->random, 0.01, 3), uniform(&s->random, 0.05, 1) * k,
                one_in(&s->random, 2) ? 0 : between(&s->random, 1e-3, 0.2) * critical,
                one_in(&s->random, 2) ? 0 : between(&s->random, 1e-3, 0.1) * critical);
    fprintf(out, "gamma_b_kg_per_s = %.17g; };\n",
            one_in(&s->random, 3) ? 0 : between(&s->random, 1e-4, 0.3) * critical);
}

static void axis_write(FILE *out, struct scales *s, char name, double duration_s)
{
    static const char *const opposites[] = {"fixed", "mirror", "constant"};
    const int kind = (int)(next(&s->random) % 8);
    if (kind == 0)
        return;
    if (kind <= 2) {
        fprintf(out, "%c = { mode = \"strain\"; strain = %.4g; frequency_hz = %.17g; opposite = \"%s\"; }; ", name,
                one_in(&s->random, 8) ? uniform(&s->random, -1, 0.95) : uniform(&s->random, -0.1, 0.2),
                uniform(&s->random, 0.45, 1.5) / duration_s, pick(s, opposites, 2));
        return;
    }
    const double p = one_in(&s->random, 12) ? -s->pressure_pa : one_in(&s->random, 20) ? 0 : s->pressure_pa;
    const double wall_kg = s->mean_kg * fmax(1, sqrt(s->count)) * between(&s->random, 0.1, 100);
    fprintf(
        out,
        "%c = { mode = \"stress\"; pressure_pa = %.17g; mass_kg = %.17g; damping_kg_per_s = %.17g; opposite = \"%s\"; ",
        name, p, one_in(&s->random, 12) ? 0 : wall_kg, between(&s->random, 1e-3, 1) * wall_kg / s->contact_s,
        pick(s, opposites, 3));
    if (kind == 3)
        fprintf(out, "target = \"ramp\"; pressure_end_pa = %.17g; ramp_s = %.17g; ", uniform(&s->random, 0, 3) * p,
                uniform(&s->random, 0.1, 1) * duration_s);
    if (kind == 4)
        fprintf(out, "target = \"cosine\"; amplitude_pa = %.17g; period_s = %.17g; ", uniform(&s->random, 0, 1) * p,
                duration_s / (double)(1 + next(&s->random) % 4));
    fprintf(out, "}; ");
}

static void stage_write(FILE *out, struct scales *s, int index, double dt_s, bool more)
{
    const double duration_s = dt_s * between(&s->random, 100, 6000);
    fprintf(out, "  { name = \"s%d\"; dt_s = %.17g; duration_s = %.17g; ", index, dt_s, duration_s);
    if (one_in(&s->random, 3))
        fprintf(out, "until_energy_ratio = %.3g; ", between(&s->random, 1e-6, 1e-1));
    fprintf(out, "walls = { ");
    axis_write(out, s, 'x', duration_s);
    if (s->dimension == 3)
        axis_write(out, s, 'y', duration_s);
    axis_write(out, s, 'z', duration_s);
    fprintf(out, "}; ");
    if (index > 0 && one_in(&s->random, 4))
        fprintf(out, "material = { gamma_b_kg_per_s = 0.0; }; ");
    fprintf(out, "}%s\n", more ? "," : "");
}

void odd_scene_write(FILE *out, uint64_t seed, int index)
{
    static const char *const schemes[] = {"hold", "jacobian", "pipelined", "adaptive", "impedance"};
    struct scales s = {.random = seed * 0x2545f4914f6cdd1du + (uint64_t)index};
    scales_draw(&s);
    fprintf(out, "name = \"odd %d\"; dimension = %d; seed = %d;\n", index, s.dimension, (int)(next(&s.random) % 1000));
    if (one_in(&s.random, 3))
        fprintf(out, "precision = \"mixed\";\n");
    if (one_in(&s.random, 3)) {
        const double g = between(&s.random, 1e-6, 1e-1) * s.radius_m / (s.contact_s * s.contact_s);
        fprintf(out, "gravity_m_per_s2 = [0.0, 0.0, %.17g];\n", -fmin(g, 1e6));
    }
    if (one_in(&s.random, 2))
        fprintf(out, "coupling = { scheme = \"%s\"; interval_steps = %d; };\n", pick(&s, schemes, 5),
                (int)between(&s.random, 1, 100));
    if (one_in(&s.random, 6))
        fprintf(out, "neighbor = { skin_ratio = %.3g; };\n", between(&s.random, 1e-9, 2));
    sample_write(out, &s);
    material_write(out, &s);
    const double dt_s =
        fmin(1, s.contact_s / (one_in(&s.random, 6) ? between(&s.random, 0.1, 8) : uniform(&s.random, 12, 50)));
    const int stages = 1 + (int)(next(&s.random) % 3);
    fprintf(out, "stages = (\n");
    for (int k = 0; k < stages; k++)
        stage_write(out, &s, k, fmax(1e-12, dt_s), k + 1 < stages);
    fprintf(out, ");\n");
}
