#include "bench/peers_input.h"

#include <math.h>

/* In 2D, LAMMPS wants a thin box about z = 0; LIGGGHTS, which steps it in 3D so that masses are those of spheres, one
 * that is far from all particles. */
static double half_depth(enum peer peer, const struct sample *sample)
{
    const struct particles *p = &sample->particles;
    double largest = 0;
    for (int i = 0; i < p->count; i++)
        largest = fmax(largest, p->radius[i]);
    return peer == PEER_LAMMPS ? 0.1 * largest : 10 * largest;
}

void peers_write_data(FILE *out, enum peer peer, const struct sample *sample)
{
    const struct particles *p = &sample->particles;
    const double pi = acos(-1.0), depth = half_depth(peer, sample);
    fprintf(out, "packing written by shakedown\n\n%d atoms\n1 atom types\n", p->count);
    for (int c = 0; c < 3; c++) {
        double lo = c < p->dimension ? sample->walls[2 * c].x : -depth;
        double hi = c < p->dimension ? sample->walls[2 * c + 1].x : depth;
        fprintf(out, "%.17g %.17g %clo %chi\n", lo, hi, 'x' + c, 'x' + c);
    }
    fprintf(out, "\nAtoms\n\n");
    for (int i = 0; i < p->count; i++) {
        double a = p->radius[i];
        fprintf(out, "%d 1 %.17g %.17g %.17g %.17g %.17g\n", p->id[i] + 1, 2 * a,
                p->mass[i] / (4.0 / 3 * pi * a * a * a), p->x[0][i], p->x[1][i], p->dimension == 3 ? p->x[2][i] : 0);
    }
    fprintf(out, "\nVelocities\n\n");
    for (int i = 0; i < p->count; i++) {
        fprintf(out, "%d %.17g %.17g %.17g", p->id[i] + 1, p->v[0][i], p->v[1][i], p->dimension == 3 ? p->v[2][i] : 0);
        for (int c = 0; c < 3; c++)
            fprintf(out, " %.17g", p->n_rotations == 3 ? p->omega[c][i] : 0);
        fprintf(out, "\n");
    }
}

static void write_lists(FILE *out, const struct peer_input *in)
{
    fprintf(out, "neighbor %.17g bin\nneigh_modify every 1 delay %d check yes\n", in->skin_m, in->delay);
}

/* Adds to velocities, or to positions (`what` "v" or ""), `gradient` times the distance from the middle along d. */
static void write_ramp(FILE *out, const struct peer_input *in, bool velocity, int c, int d, double gradient)
{
    const double half = 0.5 * gradient * (in->hi[d] - in->lo[d]);
    fprintf(out, "%s all ramp %s%c %.17g %.17g %c %.17g %.17g %sunits box\n", velocity ? "velocity" : "displace_atoms",
            velocity ? "v" : "", 'x' + c, -half, half, 'x' + d, in->lo[d], in->hi[d], velocity ? "sum yes " : "");
}

static void renew_laws(FILE *out, const struct peer_input *in, double mu);

/* Particles are where a state says, with the velocities that it says, and forces are evaluated once. Not
 * renewed: as `pre no`, so that nothing is evaluated beforehand with histories that stay; time steps and properties are
 * taken over by a renewed run alone. */
static void write_state(FILE *out, const struct peer_input *in, const struct peer_state *state, bool renewed)
{
    fprintf(out, "velocity all set 0 0 0 units box\n");
    for (int c = 0; c < in->dimension; c++) {
        if (state->strain != 0)
            write_ramp(out, in, false, c, c, state->strain);
        for (int d = 0; d < in->dimension; d++)
            if (state->velocity_per_s[c][d] != 0)
                write_ramp(out, in, true, c, d, state->velocity_per_s[c][d]);
    }
    fprintf(out, "timestep %.17g\nrun 1%s\n", state->instant ? 1e-30 : in->dt_s, renewed ? "" : " pre no");
}

static void write_states(FILE *out, const struct peer_input *in)
{
    fprintf(out, "thermo 1000000000\ndump state all custom 1 %s id x y z vx vy vz fx fy fz\n", in->dump);
    fprintf(
        out,
        "dump_modify state sort id format %s\"%%d %%.17g %%.17g %%.17g %%.17g %%.17g %%.17g %%.17g %%.17g %%.17g\"\n",
        in->peer == PEER_LAMMPS ? "line " : "");
    for (int k = 0; k < in->n_states; k++) {
        const struct peer_state *now = &in->state[k], *before = k > 0 ? now - 1 : now;
        const bool renewed = now->mu != before->mu || now->instant != before->instant;
        if (renewed)
            renew_laws(out, in, now->mu);
        write_state(out, in, now, k == 0 || renewed);
    }
}

/* Motion, background damping, and the steps, without any output between. In 2D nothing has a velocity along z or a
 * force, so that fix enforce2d is not needed. */
static void write_run(FILE *out, const struct peer_input *in)
{
    if (in->state) {
        write_states(out, in);
        return;
    }
    fprintf(out, "fix motion all nve%s\n", in->frictional || in->peer == PEER_LIGGGHTS ? "/sphere" : "");
    if (in->gamma_b > 0)
        fprintf(out, "fix background all viscous %.17g\n", in->gamma_b);
    fprintf(out, "timestep %.17g\nthermo 1000000000\n", in->dt_s);
    if (in->warm_up > 0)
        fprintf(out, "run %ld\n", in->warm_up);
    if (in->dump) {
        fprintf(out, "dump state all custom 1000000000 %s id x y z fx fy fz\n", in->dump);
        fprintf(out, "dump_modify state sort id format %s%s\n", in->peer == PEER_LAMMPS ? "line " : "",
                "\"%d %.17g %.17g %.17g %.17g %.17g %.17g\"");
        if (in->steps > 0) /* only the last one */
            fprintf(out, "dump_modify state first no every %ld\n", in->steps);
    }
    fprintf(out, "run %ld\n", in->steps);
}

/* --- LAMMPS --- */

/* gamma_n over sqrt(4/3 E* ac m_ij) for the restitution e. */
static double tsuji_factor(double e)
{
    const double pi = acos(-1.0), log_e = log(e);
    return -sqrt(5.0) * log_e / sqrt(pi * pi + log_e * log_e);
}

double peers_tsuji_restitution(double e)
{
    static const double factor[] = {1.2728, -4.2783, 11.087, -22.348, 27.467, -18.022, 4.8218};
    double lo = 0, hi = 1; /* the polynomial falls */
    for (int k = 0; k < 100; k++) {
        const double middle = 0.5 * (lo + hi);
        double alpha = 0;
        for (int n = 6; n >= 0; n--)
            alpha = alpha * middle + factor[n];
        if (alpha > tsuji_factor(e))
            lo = middle;
        else
            hi = middle;
    }
    return hi;
}

/* Without a dashpot not by Tsuji's polynomial, which leaves a little at e = 1. */
static const char *lammps_damping(const struct peer_input *in)
{
    return in->restitution < 1 ? "tsuji" : "velocity";
}

static double lammps_restitution(const struct peer_input *in)
{
    return in->restitution < 1 ? peers_tsuji_restitution(in->restitution) : 0;
}

/* Smooth walls: the normal law alone. Plain styles damp by mass, and a wall's reduced mass is the particle's. Hertz by
 * its factor 4/3 E*: from E and nu LAMMPS makes a wall that is stiffer than particles by 1 + nu. */
static void lammps_wall(char *text, size_t size, const struct peer_input *in)
{
    if (in->law == PEER_HERTZ)
        snprintf(text, size, "granular hertz %.17g %.17g damping %s tangential linear_nohistory 0 0",
                 4.0 / 3 * in->youngs_modulus / (2 * (1 - in->poisson * in->poisson)), lammps_restitution(in),
                 lammps_damping(in));
    else if (in->law == PEER_GRANULAR)
        snprintf(text, size, "granular hooke %.17g %.17g damping velocity tangential linear_nohistory 0 0", in->kn,
                 in->gamma_n);
    else
        snprintf(text, size, "hooke %.17g 0 %.17g 0 0 0", in->kn, in->gamma_n / (2 * in->reduced_mass));
}

static void lammps_fixed_walls(FILE *out, const struct peer_input *in, const char *law)
{
    for (int c = 0; c < in->dimension; c++)
        fprintf(out, "fix wall%c all wall/gran %s %cplane %.17g %.17g\n", 'x' + c, law, 'x' + c, in->lo[c], in->hi[c]);
}

/* Half-spaces that move: each wall has a displacement of its own, evaluated in every step. */
static void lammps_moving_walls(FILE *out, const struct peer_input *in, const char *law)
{
    const double speed = 1e-5; /* m/s, so slow that the packing stays what it is */
    for (int w = 0; w < 2 * in->dimension; w++) {
        int c = w / 2;
        double at[3] = {0}, normal[3] = {0};
        const char *move[3] = {"NULL", "NULL", "NULL"};
        char name[24];
        snprintf(name, sizeof name, "v_path%d", w);
        at[c] = w % 2 ? in->hi[c] : in->lo[c];
        normal[c] = w % 2 ? -1 : 1;
        move[c] = name;
        fprintf(out, "variable path%d equal vdisplace(0,%.17g)\n", w, normal[c] * speed);
        fprintf(out, "region wall%d plane %.17g %.17g %.17g %g %g %g side in move %s %s %s units box\n", w, at[0],
                at[1], at[2], normal[0], normal[1], normal[2], move[0], move[1], move[2]);
        fprintf(out, "fix wall%d all wall/gran/region %s region wall%d\n", w, law, w);
    }
}

/* Mindlin's force with the scene's friction, damped by sqrt(S_t/S_n) of the normal dashpot, S_t = 8 G* ac, S_n = 2 E*
 * ac: S_t/S_n = 2 (1 - nu)/(2 - nu). */
static void lammps_hertz(FILE *out, const struct peer_input *in, double mu)
{
    const double nu = in->poisson;
    fprintf(out, "pair_coeff * * hertz/material %.17g %.17g %.17g damping %s tangential ", in->youngs_modulus,
            lammps_restitution(in), nu, lammps_damping(in));
    if (in->frictional)
        fprintf(out, "%s NULL %.17g %.17g\n", in->tangential, sqrt(2 * (1 - nu) / (2 - nu)), mu);
    else
        fprintf(out, "linear_nohistory 0 0\n");
}

static void lammps_pair(FILE *out, const struct peer_input *in)
{
    if (in->law == PEER_HERTZ) {
        fprintf(out, "pair_style granular\n");
        lammps_hertz(out, in, in->mu);
        return;
    }
    const double damping = in->gamma_n / in->reduced_mass;
    if (in->law == PEER_GRANULAR) {
        fprintf(out, "pair_style granular\npair_coeff * * hooke %.17g %.17g tangential ", in->kn, in->gamma_n);
        if (in->frictional) /* damping of the tangential part: a factor of the normal one */
            fprintf(out, "linear_history %.17g %.17g %.17g damping velocity\n", in->kt,
                    in->gamma_n > 0 ? in->gamma_t / in->gamma_n : 0, in->mu);
        else
            fprintf(out, "linear_nohistory 0 0 damping velocity\n");
        return;
    }
    if (in->frictional)
        fprintf(out, "pair_style gran/hooke/history %.17g %.17g %.17g %.17g %.17g 1\n", in->kn, in->kt, damping,
                in->gamma_t / in->reduced_mass, in->mu);
    else
        fprintf(out, "pair_style gran/hooke %.17g 0 %.17g 0 0 0\n", in->kn, damping);
    fprintf(out, "pair_coeff * *\n");
}

static void write_lammps(FILE *out, const struct peer_input *in)
{
    char wall[256];
    fprintf(out,
            "units si\ndimension %d\nboundary f f %c\natom_style sphere\natom_modify map array sort 1000 0\n"
            "newton off\ncomm_modify mode single vel yes\nread_data %s\n",
            in->dimension, in->dimension == 3 ? 'f' : 'p', in->data);
    lammps_pair(out, in);
    write_lists(out, in);
    lammps_wall(wall, sizeof wall, in);
    if (in->walls_move)
        lammps_moving_walls(out, in, wall);
    else
        lammps_fixed_walls(out, in, wall);
    write_run(out, in);
}

/* --- LIGGGHTS --- */

static void liggghts_property(FILE *out, const char *name, double value)
{
    fprintf(out, "fix %s all property/global %s peratomtypepair 1 %.17g\n", name, name, value);
}

static void liggghts_properties(FILE *out, const struct peer_input *in)
{
    liggghts_property(out, "coefficientFriction", in->frictional ? in->mu : 0);
    if (in->law == PEER_HERTZ) {
        fprintf(out, "fix youngsModulus all property/global youngsModulus peratomtype %.17g\n", in->youngs_modulus);
        fprintf(out, "fix poissonsRatio all property/global poissonsRatio peratomtype %.17g\n", in->poisson);
        liggghts_property(out, "coefficientRestitution", in->restitution);
        return;
    }
    if (in->law == PEER_STIFFNESS) {
        liggghts_property(out, "kn", in->kn);
        liggghts_property(out, "kt", in->kt);
        liggghts_property(out, "gamman_abs", in->gamma_n);
        liggghts_property(out, "gammat_abs", in->gamma_t);
        return;
    }
    liggghts_property(out, "LoadingStiffness", in->kn);
    liggghts_property(out, "UnloadingStiffness", in->k2 / in->kn);
    liggghts_property(out, "coefficientAdhesionStiffness", in->kc / in->kn);
    liggghts_property(out, "coefficientPlasticityDepth", in->plasticity_depth);
    liggghts_property(out, "pullOffForce", 0);
    liggghts_property(out, "coefficientRestitution", in->restitution);
}

/* Coulomb's limit from here on, of Hertz-Mindlin. In LAMMPS walls are made anew, as every run that begins puts their
 * coefficient of restitution through the polynomial once more. */
static void renew_laws(FILE *out, const struct peer_input *in, double mu)
{
    if (in->peer == PEER_LAMMPS) {
        char wall[256];
        lammps_hertz(out, in, mu);
        lammps_wall(wall, sizeof wall, in);
        for (int c = 0; c < in->dimension; c++)
            fprintf(out, "unfix wall%c\n", 'x' + c);
        lammps_fixed_walls(out, in, wall);
        return;
    }
    fprintf(out, "unfix coefficientFriction\n");
    liggghts_property(out, "coefficientFriction", mu);
}

/* Without friction "no_history", the form that LIGGGHTS has compiled as a whole, is faster than "off". */
static void write_liggghts(FILE *out, const struct peer_input *in)
{
    const char *model = in->law == PEER_LUDING ? "luding" : in->law == PEER_HERTZ ? "hertz" : "hooke/stiffness";
    const char *options = in->law == PEER_STIFFNESS ? "absolute_damping on" : "";
    fprintf(out,
            "%sunits si\natom_style granular\natom_modify map array sort 1000 0\nboundary f f f\nnewton off\n"
            "communicate single vel yes\nread_data %s\n",
            in->law == PEER_HERTZ ? "hard_particles yes\n" : "", in->data);
    liggghts_properties(out, in);
    fprintf(out, "pair_style gran model %s tangential %s %s\npair_coeff * *\n", model,
            in->frictional ? "history" : "no_history", options);
    write_lists(out, in);
    for (int w = 0; w < 2 * in->dimension; w++) /* smooth */
        fprintf(out, "fix wall%d all wall/gran model %s tangential %s primitive type 1 %cplane %.17g %s\n", w, model,
                in->frictional ? "off" : "no_history", 'x' + w / 2, w % 2 ? in->hi[w / 2] : in->lo[w / 2], options);
    write_run(out, in);
}

void peers_write_script(FILE *out, const struct peer_input *input)
{
    if (input->peer == PEER_LAMMPS)
        write_lammps(out, input);
    else
        write_liggghts(out, input);
}
