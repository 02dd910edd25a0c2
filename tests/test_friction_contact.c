/* Single contacts with friction against closed forms and law-independent asymptotes: the benchmarks of Chung & Ooi
 * (2011), rolling and sliding, rotations of a pair, and a small sphere on large ones (Vyas et al. 2025). */
#include "sim_fixture.h"

#include <math.h>
#include <stdio.h>

#include "sim/measure/measure.h"
#include "sim/sample/energy.h"
#include "sim/sample/step_completion.h"
#include "sim/sample/time_step.h"

static const double PI = 3.14159265358979323846;
static const double G = 9.81; /* m/s^2 */
static const double A = 1e-3; /* radius of the fixture's particles, m */
static const double K = 1e5;  /* N/m */
static const double KT = 2e4; /* N/m */

static double mass_of(double radius)
{
    return 4.0 / 3.0 * PI * 2000 * radius * radius * radius;
}

static struct fixture open_with(int dimension, int count, double dt, const char *format, double p, double q)
{
    char material[256];
    snprintf(material, sizeof material, format, p, q);
    struct fixture_options options = {.dimension = dimension, .count = count, .dt_s = dt, .material = material};
    return fixture_open(&options);
}

/* Sign of the spin that a friction force along +x0 at the lower wall of the last axis gives: the torque is
 * -a n x f_t. 2D: the component about x cross z turns x into z; 3D: omega_y. */
static double rolling_spin(const struct particles *p, int i)
{
    return p->dimension == 2 ? -p->omega[0][i] : p->omega[1][i];
}

/* How far the centre of particle 0 is from the lower wall of the last axis: its lever arm. */
static double arm_of(const struct fixture *f)
{
    const int last = f->sample->particles.dimension - 1;
    return f->sample->particles.x[last][0] - f->sample->walls[2 * last].x;
}

/* Velocity along x0 of the surface of particle 0 at the lower wall. */
static double slip_velocity(const struct fixture *f)
{
    const struct particles *p = &f->sample->particles;
    return p->v[0][0] - arm_of(f) * rolling_spin(p, 0);
}

static void put_on_floor(struct fixture *f, double overlap, double vx, double vn)
{
    struct particles *p = &f->sample->particles;
    int last = p->dimension - 1;
    p->x[last][0] = f->sample->walls[2 * last].x + p->radius[0] - overlap;
    p->v[0][0] = vx;
    p->v[last][0] = -vn;
}

/* --- Impacts: Chung & Ooi ------------------------------------------------------------------------------------------
 */

/* Benchmarks 3 and 4, sliding throughout: e_t = 1 - mu (1 + e)/tan(theta), a omega' = (5/2) mu (1 + e) V_n, with the e
 * that is found. The law pulls at the end of a damped impact, where friction has no force to act with: the impulse that
 * it lacks is gamma^2 V_n/(2 k) = 2 zeta^2 m V_n. Beside it, one step's sticking at each end of the contact: dt/t_c =
 * 3e-4. */
static void oblique_impact_on_a_wall(int dimension, double degrees, double mu, double zeta)
{
    const double vn = 0.05, m = mass_of(A), tangent = tan(degrees * PI / 180);
    struct fixture f =
        open_with(dimension, 1, 1e-8, "kn_n_per_m = 1e5; mu_s = %.17e; kt_n_per_m = 1e5; gamma_n_kg_per_s = %.17e;", mu,
                  2 * zeta * sqrt(K * m));
    struct particles *p = &f.sample->particles;
    int last = dimension - 1;
    put_on_floor(&f, 0, vn * tangent, vn);
    fixture_start(&f);
    fixture_steps(&f, 4500);
    assert_true(f.sample->walls[2 * last].force == 0);
    double e = p->v[last][0] / vn, slack = mu * 2 * zeta * zeta + 1e-3;
    assert_close("e", e, exp(-zeta * PI / sqrt(1 - zeta * zeta)), 1e-3);
    assert_close("e_t", p->v[0][0] / (vn * tangent), 1 - mu * (1 + e) / tangent, slack / tangent);
    assert_close("spin", rolling_spin(p, 0) * A / vn, 2.5 * mu * (1 + e), 2.5 * slack);
    fixture_close(&f);
}

static void gross_sliding(void **state)
{
    static const double degrees[] = {45, 60, 80};
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++)
        for (int k = 0; k < 3; k++) {
            oblique_impact_on_a_wall(dimension, degrees[k], 0.1, 0);
            oblique_impact_on_a_wall(dimension, degrees[k], 0.1, 0.05);
            oblique_impact_on_a_wall(dimension, degrees[k], 0.05, 0.02);
        }
}

/* A sphere that slides from the first touch to the last, with a dashpot that alone pulls harder (gamma_t v = 2 mu N at
 * the deepest) than friction allows: all the loss is friction's, whatever the law, and it is the energy that is
 * missing. The ledger closes with the square of the step (2900 to a contact): measured 1.8e-7 (linear) and 7e-10
 * (Hertz) of the energy. */
static void sliding_loss(int dimension, const char *material, double stiffness)
{
    const double vn = 0.05, vx = 0.3, mu = 0.1, m = mass_of(A);
    struct fixture f = open_with(dimension, 1, 1e-8, material, mu, 2 * mu * vn * sqrt(stiffness * m) / vx);
    const struct contact_losses *lost = &f.sample->ledger.contacts;
    put_on_floor(&f, 0, vx, vn);
    fixture_start(&f);
    const double start = energy_kinetic_j(sample_complete(f.sample));
    fixture_steps(&f, 30000);
    assert_true(f.sample->walls[2 * dimension - 2].force == 0);
    const double missing = start - energy_kinetic_j(sample_complete(f.sample)) - lost->viscous_normal;
    assert_true(missing > 0.01 * start);
    assert_true(lost->viscous_tangential == 0 && lost->stiffness == 0);
    print_message("friction takes %.6f of the energy, %.1e more than is missing\n", lost->friction / start,
                  (lost->friction - missing) / start);
    assert_close("friction", lost->friction, missing, 1e-6 * start);
    fixture_close(&f);
}

static void friction_takes_all_while_sliding(void **state)
{
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++) {
        sliding_loss(
            dimension,
            "kn_n_per_m = 1e5; kt_n_per_m = 2e4; mu_s = %.17e; gamma_n_kg_per_s = 0.1; gamma_t_kg_per_s = %.17e;", K);
        sliding_loss(dimension,
                     "law = \"hertz\"; youngs_modulus_pa = 1e8; poisson_ratio = 0.3; restitution = 0.5; mu_s = %.17e; "
                     "gamma_b_kg_per_s = 0.0; // %.17e\n",
                     K);
    }
}

/* Benchmarks 6 and 7: two spheres meet head on at V_n each (radii A and ratio A), sphere 0 spinning fast. Impulse J =
 * m_12 (1 + e) 2 V_n, tangential mu J on each: velocities change by mu J/m, surface speeds by (5/2) mu J/m. */
static void spinning_pair(int dimension, double ratio)
{
    const double vn = 0.05, mu = 0.2, spin = 800;
    struct fixture f = open_with(dimension, 2, 1e-8, "kn_n_per_m = %.17e; mu_s = %.17e; kt_n_per_m = 1e5;", K, mu);
    struct sample *sample = f.sample;
    struct particles *p = &sample->particles;
    int last = dimension - 1;
    p->radius[1] = ratio * A;
    for (int i = 0; i < 2; i++) {
        for (int c = 0; c < dimension; c++)
            p->x[c][i] = 0.5 * (sample->walls[2 * c].x + sample->walls[2 * c + 1].x);
        p->v[0][i] = i == 0 ? vn : -vn;
    }
    p->x[0][1] += A + p->radius[1];
    p->omega[dimension == 2 ? 0 : 1][0] = spin;
    fixture_start(&f);
    double m0 = p->mass[0], m1 = p->mass[1], m12 = m0 * m1 / (m0 + m1);
    fixture_steps(&f, (int)(1.02 * PI * sqrt(m12 / K) / 1e-8));
    double impulse = m12 * 2 * 2 * vn, scale = impulse / m12, v0 = fabs(p->v[last][0]), v1 = fabs(p->v[last][1]);
    double w0 = fabs(p->omega[dimension == 2 ? 0 : 1][0]), w1 = fabs(p->omega[dimension == 2 ? 0 : 1][1]);
    assert_true(fixture_overlap(&f) < 0);
    /* as on a wall: a step's worth at either end, and 2 dt/t_c of spring before it slides */
    assert_close("v0", v0, mu * impulse / m0, 1e-3 * scale);
    assert_close("v1", v1, mu * impulse / m1, 1e-3 * scale);
    assert_close("spin 0", (spin - w0) * A, 2.5 * mu * impulse / m0, 2.5e-3 * scale);
    assert_close("spin 1", w1 * p->radius[1], 2.5 * mu * impulse / m1, 2.5e-3 * scale);
    fixture_close(&f);
}

static void spinning_spheres(void **state)
{
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++) {
        spinning_pair(dimension, 1);
        spinning_pair(dimension, 5);
    }
}

/* --- Sticking ------------------------------------------------------------------------------------------------------
 */

/* A sphere pressed on the floor by gravity, with slip v0 at first: the slip obeys m s'' = -b (kt xi + gamma_t s), b =
 * 1 + (5/2)(arm/a)^2, a damped oscillator of omega^2 = b kt/m - eta^2, eta = b gamma_t/(2 m), and the centre takes 1/b
 * of its change. */
static double sticking_error(int dimension, int steps)
{
    const double gamma_t = 0.01, v0 = 1e-4, m = mass_of(A), arm = 1 - m * G / K / A; /* over the radius */
    const double light = 1 + 2.5 * arm * arm, eta = 0.5 * light * gamma_t / m;
    const double omega = sqrt(light * KT / m - eta * eta), t = 7 / omega;
    struct fixture f =
        open_with(dimension, 1, t / steps,
                  "kn_n_per_m = 1e5; mu_s = 50.0; kt_n_per_m = %.17e; gamma_t_kg_per_s = %.17e;", KT, gamma_t);
    struct particles *p = &f.sample->particles;
    f.sample->gravity[dimension - 1] = -G;
    put_on_floor(&f, m * G / K, v0, 0);
    fixture_start(&f);
    const struct contact_list *floor = &f.sample->walls[2 * (dimension - 1)].contacts;
    fixture_steps(&f, steps);
    double expected = v0 * exp(-eta * t) * (cos(omega * t) - eta / omega * sin(omega * t));
    double error = fabs(slip_velocity(&f) - expected);
    assert_false(contact_list_slides(floor, 0));
    assert_close("centre", p->v[0][0], v0 - (v0 - slip_velocity(&f)) / light, 1e-12 * v0);
    fixture_close(&f);
    return error / v0;
}

/* Second order: phase error t omega^3 dt^2/24 = 7^3/(24 n^2), 2e-4 for n = 256 steps; halving the step divides by 4. */
static void sticking_oscillator(void **state)
{
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++) {
        double coarse = sticking_error(dimension, 256), fine = sticking_error(dimension, 512);
        assert_true(coarse < 4 * 343.0 / 24 / (256.0 * 256.0));
        assert_close("order", log2(coarse / fine), 2, 0.15);
    }
}

/* --- Rolling and sliding -------------------------------------------------------------------------------------------
 */

struct skid {
    double speed;   /* at the end, over the first */
    double rolling; /* the same as it must be: 5/7 but for the lever arm, which is short of the radius by the overlap */
    int changes;    /* between stick and slide */
    double slid_s;
};

/* A sphere put down with v0 and no spin slides for (2/7) v0/(mu g), then rolls. `press`: overlap at first over that of
 * equilibrium; other than 1 it bounces. */
static struct skid skid(int dimension, double dt, double mu_s, double mu_d, double press)
{
    const double v0 = 0.1, end = 0.04, m = mass_of(A);
    struct skid result = {0};
    struct fixture f = open_with(
        dimension, 1, dt, "kn_n_per_m = 1e4; mu_s = %.17e; mu_d = %.17e; kt_n_per_m = 2e3; gamma_t_kg_per_s = 0.02;",
        mu_s, mu_d);
    struct particles *p = &f.sample->particles;
    f.sample->gravity[dimension - 1] = -G;
    put_on_floor(&f, press * m * G / 1e4, v0, 0);
    fixture_start(&f);
    const struct contact_list *floor = &f.sample->walls[2 * (dimension - 1)].contacts;
    bool before = true;
    for (int k = 0; k < (int)(end / dt); k++) {
        fixture_steps(&f, 1);
        bool now = floor->count > 0 && contact_list_slides(floor, 0);
        result.changes += now != before;
        result.slid_s += now ? dt : 0;
        before = now;
    }
    result.speed = p->v[0][0] / v0;
    result.rolling = 1 / (1 + 0.4 * A * A / (arm_of(&f) * arm_of(&f)));
    /* a sphere that bounces rolls on an arm that swings */
    assert_close("rolls", slip_velocity(&f) / v0, 0, 1e-6 + 2 * fabs(press - 1) * m * G / 1e4 / A);
    fixture_close(&f);
    return result;
}

/* 5/7 of v0 whatever the friction, as the angular momentum about the floor stays; the slip left by the damped spring is
 * below 1e-6. The time differs by the spring's build-up and decay, a period 2 pi sqrt(2 m/(7 kt)) = 4e-4 s. */
static void sliding_becomes_rolling(void **state)
{
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++) {
        struct skid s = skid(dimension, 2e-6, 0.2, 0.2, 1);
        assert_close("5/7", s.speed, s.rolling, 1e-6);
        assert_close("time", s.slid_s, 2.0 / 7 * 0.1 / (0.2 * G), 4e-4);
        s = skid(dimension, 2e-6, 0.4, 0.1, 1); /* the dynamic one decides */
        assert_close("5/7", s.speed, s.rolling, 1e-6);
        assert_close("time", s.slid_s, 2.0 / 7 * 0.1 / (0.1 * G), 4e-4);
    }
}

/* The normal force swings by 80 % (undamped): it may slide again once in each of its periods, 2 pi sqrt(m/k) = 1.8e-4 s
 * or 220 in the run, and not once per step. A finer step must not multiply the changes. */
static void flicker_is_bounded(void **state)
{
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++) {
        struct skid coarse = skid(dimension, 4e-6, 0.2, 0.2, 1.8), fine = skid(dimension, 5e-7, 0.2, 0.2, 1.8);
        print_message("%dD: %d changes between stick and slide at 4 us, %d at 0.5 us\n", dimension, coarse.changes,
                      fine.changes);
        assert_true(coarse.changes <= 2 * 220 && fine.changes <= 2 * 220);
    }
}

/* A block (a sphere that cannot turn) on the floor, pulled along x by `pull` times g: its acceleration over g. */
static double block_acceleration(double pull, double v0)
{
    const double dt = 1e-6, m = mass_of(A), t = 0.01;
    struct fixture f = open_with(
        3, 1, dt, "kn_n_per_m = 1e4; mu_s = %.17e; mu_d = %.17e; kt_n_per_m = 2e3; gamma_t_kg_per_s = 0.05;", 0.8, 0.3);
    struct particles *p = &f.sample->particles;
    f.sample->gravity[2] = -G;
    f.sample->gravity[0] = pull * G;
    put_on_floor(&f, m * G / 1e4, v0, 0);
    fixture_start(&f);
    p->inv_inertia[0] = 0;
    fixture_steps(&f, (int)(t / dt));
    double before = p->v[0][0];
    fixture_steps(&f, (int)(t / dt));
    double acceleration = (p->v[0][0] - before) / t / G;
    fixture_close(&f);
    return acceleration;
}

/* mu_s = 0.8, mu_d = 0.3: at 0.35 it holds (the swing after a sudden pull stays below 0.7); pushed, it goes on at 0.35
 * - 0.3; at 1 it starts by itself, at 1 - 0.3; pushed at 0.2, it slows down at 0.3 - 0.2. Steady sliding is exact; what
 * holds keeps creeping by less than the damped swing, e^(-eta t) with eta t = gamma_t/(2m) 0.01 s = 30. */
static void static_and_dynamic_friction(void **state)
{
    (void)state;
    assert_close("holds", block_acceleration(0.35, 0), 0, 1e-9);
    assert_close("goes on", block_acceleration(0.35, 0.1), 0.05, 1e-9);
    assert_close("starts", block_acceleration(1, 0), 0.7, 1e-9);
    assert_close("slows down", block_acceleration(0.2, 0.1), -0.1, 1e-9);
}

/* --- Rotation of a pair --------------------------------------------------------------------------------------------
 */

static void cross(const double *a, const double *b, double *result)
{
    for (int c = 0; c < 3; c++)
        result[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
}

/* x turned by `angle` about the unit vector `axis` (Rodrigues). */
static void turn(const double *axis, double angle, const double *x, double *result)
{
    double side[3], along = axis[0] * x[0] + axis[1] * x[1] + axis[2] * x[2];
    cross(axis, x, side);
    for (int c = 0; c < 3; c++)
        result[c] = x[c] * cos(angle) + side[c] * sin(angle) + axis[c] * along * (1 - cos(angle));
}

/* Sets particle i so that the coming drift brings it exactly to `x` with velocity `v` (components of the fixture). */
static void aim(struct fixture *f, int i, const double *x, const double *v)
{
    struct particles *p = &f->sample->particles;
    const double dt = f->sample->dt;
    for (int c = 0; c < p->dimension; c++) {
        p->a[c][i] = 2 * (v[c] - (x[c] - p->x[c][i]) / dt) / dt;
        p->v[c][i] = v[c] - p->a[c][i] * dt;
    }
}

/* One step of a rigid rotation at `rate` about `axis` through the pair's middle, both spheres half of `branch` from it.
 */
static void rotate_once(struct fixture *f, const double *middle, const double *axis, double rate, const double *branch)
{
    struct particles *p = &f->sample->particles;
    for (int i = 0; i < 2; i++) {
        double side = i == 0 ? 0.5 : -0.5, x[3], v[3];
        cross(axis, branch, v);
        for (int c = 0; c < 3; c++) {
            x[c] = middle[c] + side * branch[c];
            v[c] *= side * rate;
        }
        aim(f, i, x, v);
        for (int c = 0; c < p->n_rotations; c++) {
            p->omega[c][i] = rate * axis[p->n_rotations == 1 ? 2 : c];
            p->alpha[c][i] = 0;
        }
    }
    fixture_steps(f, 1);
}

/* A full turn in N steps about an axis at `tilt` from the branch vector; the stored spring (of both tangential
 * directions in 3D) must come back. Its length is kept to the fourth order of phi = 2 pi/N in a step, its direction to
 * the third. As the spring follows the way of the centres, along a chord, and the spheres turn along the arc, a step
 * adds phi^3/12 of the distance of centres, 2 a, in all (2 pi)^3 a/(6 N^2). */
static void turn_pair(int dimension, double tilt)
{
    enum { N = 10000 };
    const double overlap = 1e-5, xi[3] = {0, 3e-6, dimension == 2 ? 0 : 4e-6}; /* [D]: |kt xi| below mu kn overlap */
    const double axis[3] = {cos(tilt), dimension == 2 ? 0 : sin(tilt), dimension == 2 ? 1 : 0};
    double middle[3] = {0}, length = dimension == 2 ? 3e-6 : 5e-6, moved = 0, length2 = 0;
    struct fixture_options options = {
        .dimension = dimension, .dt_s = 1e-6, .material = "kn_n_per_m = 1e5; mu_s = 10.0; kt_n_per_m = 2e4;"};
    struct fixture f = fixture_pair(&options, overlap, 0);
    struct particles *p = &f.sample->particles;
    double start[3] = {p->x[0][0] - p->x[0][1], 0, 0}, branch[3];
    const double plane[3] = {0, 0, 1};
    const double *about = dimension == 2 ? plane : axis;
    for (int i = 0; i < 2; i++)
        p->inv_mass[i] = p->inv_inertia[i] = 0;
    for (int c = 0; c < dimension; c++)
        middle[c] = 0.5 * (p->x[c][0] + p->x[c][1]);
    double *const *spring = &f.sample->pairs.history[HISTORY_SPRING];
    contact_list_read(&f.sample->pairs);
    if (dimension == 2)
        spring[0][0] = length;
    for (int c = 0; c < dimension && dimension == 3; c++)
        spring[c][0] = xi[c];
    must(contact_list_close(&f.sample->pairs, p, NULL));
    for (int k = 1; k <= N; k++) {
        turn(about, 2 * PI * k / N, start, branch);
        rotate_once(&f, middle, about, 2 * PI / N / f.sample->dt, branch);
    }
    contact_list_read(&f.sample->pairs);
    for (int c = 0; c < contact_model_springs(&f.sample->pairs.model); c++)
        length2 += spring[c][0] * spring[c][0];
    /* both positions, about 0.2 m, are rounded by 2.8e-17 m a step */
    const double chord = 8 * PI * PI * PI * A / 6 / N / N, rounded = N * 2 * 2.8e-17;
    assert_close("stored", sqrt(length2), length, chord + rounded);
    for (int c = 0; c < dimension && dimension == 3; c++)
        moved += (spring[c][0] - xi[c]) * (spring[c][0] - xi[c]);
    print_message("%dD, axis at %.2f: length off by %.2g, direction by %.2g\n", dimension, tilt,
                  sqrt(length2) / length - 1, sqrt(moved) / length);
    assert_close("direction", sqrt(moved) / length, 0, (chord + rounded) / length + 8 * PI * PI * PI / 3 / N / N);
    assert_false(contact_list_slides(&f.sample->pairs, 0));
    fixture_close(&f);
}

static void rotation_of_a_pair(void **state)
{
    (void)state;
    turn_pair(2, 0);
    turn_pair(3, 0); /* about the normal */
    turn_pair(3, PI / 2);
    turn_pair(3, 0.7);
}

/* --- Three particles -----------------------------------------------------------------------------------------------
 */

/* The first two particles at rest, `half` on either side of the middle. */
static void hold_large(struct particles *p, const double *middle, double half)
{
    for (int i = 0; i < 2; i++)
        for (int c = 0; c < 3; c++) {
            p->x[c][i] = middle[c] + (c > 0 ? 0 : i ? half : -half);
            p->v[c][i] = p->a[c][i] = p->omega[c][i] = p->alpha[c][i] = 0;
        }
}

/* A small sphere in the saddle between two large fixed ones of radius A, a hair apart: nothing but its inertia holds it
 * when it rolls off across their line. With D the distance of centres and L that of the small centre from the line,
 * rolling at both contacts spins it by D/a times the rate of its angle theta, so that
 *   theta'' = g L sin(theta)/(L^2 + (2/5) D^2).
 * From rest at theta_0 that is theta_0 cosh(lambda t). With velocities that lag by half a step it would stay. */
static double roll_off(double ratio, double *expected)
{
    const double a = A / ratio, half = 1.001 * A, m = mass_of(a), theta = 1e-3;
    const double cosine = sqrt((A + a) * (A + a) - half * half) / (A + a), normal = m * G / (2 * cosine);
    const double k = normal / (1e-4 * a), distance = A + a - 1e-4 * a, height = sqrt(distance * distance - half * half);
    const double lambda = sqrt(G * height / (height * height + 0.4 * distance * distance));
    const double dt = 0.1 * sqrt(m / k), end = 3 / lambda;
    char material[256];
    snprintf(material, sizeof material,
             "kn_n_per_m = %.17e; kt_n_per_m = %.17e; mu_s = 5.0; gamma_n_kg_per_s = %.17e; gamma_t_kg_per_s = %.17e;",
             k, 0.3 * k, 0.2 * sqrt(k * m), 0.05 * sqrt(k * m));
    struct fixture_options options = {.dimension = 3, .count = 3, .dt_s = dt, .material = material};
    struct fixture f = fixture_open(&options);
    struct sample *sample = f.sample;
    struct particles *p = &sample->particles;
    double middle[3];
    for (int c = 0; c < 3; c++)
        p->x[c][2] = middle[c] = 0.5 * (sample->walls[2 * c].x + sample->walls[2 * c + 1].x);
    hold_large(p, middle, half);
    p->x[1][2] += height * sin(theta);
    p->x[2][2] += height * cos(theta);
    p->radius[2] = a;
    sample->gravity[2] = -G;
    fixture_start(&f);
    int steps = (int)(end / dt);
    for (int k = 0; k < steps; k++) {
        hold_large(p, middle, half);
        must(sample_step(sample));
    }
    double reached = atan2(p->x[1][2] - middle[1], p->x[2][2] - middle[2]) / theta;
    *expected = cosh(lambda * steps * dt);
    print_message("size ratio %g: %d steps, angle %.5f of the first, closed form %.5f\n", ratio, steps, reached,
                  *expected);
    fixture_close(&f);
    return reached;
}

/* Contacts are 1e-4 a deep: the law's lever arms are off by as much, the height by 1e-4 a D/L^2, and with them lambda
 * by half of it: 3 lambda t delta, below 1 % for the largest ratio; sin(theta) at the end costs 1e-4. */
static void small_on_large(void **state)
{
    static const double ratio[] = {3, 10, 100};
    (void)state;
    for (int k = 0; k < 3; k++) {
        double expected, reached = roll_off(ratio[k], &expected);
        assert_close("angle", reached, expected, 0.01 * expected);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gross_sliding),
        cmocka_unit_test(spinning_spheres),
        cmocka_unit_test(sticking_oscillator),
        cmocka_unit_test(sliding_becomes_rolling),
        cmocka_unit_test(flicker_is_bounded),
        cmocka_unit_test(static_and_dynamic_friction),
        cmocka_unit_test(rotation_of_a_pair),
        cmocka_unit_test(small_on_large),
        cmocka_unit_test(friction_takes_all_while_sliding),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
