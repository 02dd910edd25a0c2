#include <math.h>

#include "bench/impacts.h"

double impact_mass_kg(const struct impact *impact)
{
    return impact->pair ? 1 / (1 / impact->mass_kg[0] + 1 / impact->mass_kg[1]) : impact->mass_kg[0];
}

static double reduced_radius_m(const struct impact *impact)
{
    return impact->pair ? 1 / (1 / impact->radius_m[0] + 1 / impact->radius_m[1]) : impact->radius_m[0];
}

/* y'' = -y^(3/2) - c y^(1/4) y', lengths over L = (m v^2/((4/3) E* sqrt(R)))^(2/5), times over L/v. */
static double force_of(double y, double u, double c)
{
    const double held = y > 0 ? y : 0;
    return pow(held, 1.5) + c * pow(held, 0.25) * u;
}

struct motion {
    double y, u;
};

static struct motion motion_step(struct motion s, double c, double h)
{
    const double u1 = s.u, a1 = -force_of(s.y, s.u, c);
    const double u2 = s.u + 0.5 * h * a1, a2 = -force_of(s.y + 0.5 * h * u1, u2, c);
    const double u3 = s.u + 0.5 * h * a2, a3 = -force_of(s.y + 0.5 * h * u2, u3, c);
    const double u4 = s.u + h * a3, a4 = -force_of(s.y + h * u3, u4, c);
    return (struct motion){s.y + h / 6 * (u1 + 2 * u2 + 2 * u3 + u4), s.u + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)};
}

/* Results in units of L, L/v, m v^2/L. */
static struct impact_theory integrate(double c)
{
    struct impact_theory theory = {0};
    struct motion s = {0, 1};
    const double h = 3.0 / 20000;
    for (double t = 0; t < 100; t += h) {
        const struct motion next = motion_step(s, c, h);
        const double before = force_of(s.y, s.u, c), after = force_of(next.y, next.u, c);
        theory.push_per_mv += 0.5 * h * (fmax(before, 0) + fmax(after, 0));
        theory.peak_force_n = fmax(theory.peak_force_n, after);
        theory.peak_overlap_m = fmax(theory.peak_overlap_m, next.y);
        if (next.y <= 0) {
            theory.contact_s = t + h * s.y / (s.y - next.y);
            break;
        }
        s = next;
    }
    return theory;
}

struct impact_theory impact_theory_of(const struct impact *impact, const struct scene_material *material)
{
    const double e = material->restitution, nu = material->poisson_ratio, pi = acos(-1.0);
    const double modulus = material->youngs_modulus_pa / (2 * (1 - nu * nu)); /* both of one material */
    const double m = impact_mass_kg(impact), v = impact->normal_m_per_s;
    const double root = sqrt(reduced_radius_m(impact)), beta = -log(e) / sqrt(pi * pi + log(e) * log(e));
    const double length = pow(m * v * v / (4.0 / 3 * modulus * root), 0.4);
    /* gamma_n = 2 sqrt(5/6) beta sqrt(2 E* sqrt(R) m) x^(1/4), in these units */
    struct impact_theory theory = integrate(2 * sqrt(5.0 / 6) * beta * sqrt(1.5));
    theory.peak_overlap_m *= length;
    theory.contact_s *= length / v;
    theory.peak_force_n *= m * v * v / length;
    if (e < 1)
        return theory;
    theory.peak_overlap_m = pow(1.25, 0.4) * length;
    theory.peak_force_n = pow(1.25, 0.6) * m * v * v / length;
    theory.contact_s = 2 * theory.peak_overlap_m / v * 0.4 * tgamma(0.4) * tgamma(0.5) / tgamma(0.9);
    theory.push_per_mv = 2;
    return theory;
}

bool impact_sliding(const struct impact *impact, const struct impact_theory *theory, double mu, double *slip_m_per_s,
                    double *spin_rad_per_s)
{
    const double m = impact_mass_kg(impact), sign = impact->slip_m_per_s < 0 ? -1 : 1;
    const double impulse = sign * mu * theory->push_per_mv * m * impact->normal_m_per_s;
    *slip_m_per_s = impact->slip_m_per_s - 3.5 * impulse / m; /* 1 + m a^2/(2/5 m a^2) */
    *spin_rad_per_s = impact->spin_rad_per_s + 2.5 * impulse / (impact->mass_kg[0] * impact->radius_m[0]);
    return *slip_m_per_s * sign > 0;
}
