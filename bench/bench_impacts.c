/* The eight tests of Chung & Ooi (Granular Matter 13 (2011) 643), scenes/benchmarks/, beside closed forms and LAMMPS:
 * bench_impacts --scenes DIR --out DIR [--lammps [--tangential STYLE]] [--set KEY=VALUE]
 * [--coarser FACTOR]: of the time step. Exit code 11 if a value is
 * not what it should be. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/child.h"
#include "bench/impacts.h"
#include "common/command_line.h"
#include "common/floating_point.h"
#include "common/scene_file.h"
#include "sim/run/sample_source.h"

/* What the checks allow. Steps are a 1000th of the shortest contact of a scene, so that second order leaves some 1e-5;
 * forces that start as x^(3/2), and dashpots that start as x^(1/4), cost more at the ends of a contact. */
static const double ELASTIC = 1e-4; /* of contact time, overlap and force without loss */
static const double LOSSY = 1e-3;   /* of the restitution */
static const double SLIDING = 1e-3; /* of slip and spin, in parts of their change */
static const double LEVER = 1e-6;   /* of the ratio of spin and velocity, beside: */

/* The lever of the torque is what is left of the radius: a - overlap at a wall, a (1 - overlap/(a_i + a_j)) in a pair,
 * where closed forms have a. */
static double shortened(const struct impact *k)
{
    return k->peak_overlap_m / (k->radius_m[0] + (k->pair ? k->radius_m[1] : 0));
}

/* What the spin differs by from that of a lever a, a d(omega) + 5/2 dv over the approach: the lever that is missing
 * times the friction in either direction, which is at most mu times the push. The line of centres of a pair turns, and
 * turns the normal impulse with it: by at most the way of the centres, in the time of contact with twice the change of
 * velocity, over their distance. */
static double lever_allowed(const struct impact *k, const struct scene_material *material, double push_per_mv)
{
    const double distance = k->radius_m[0] + k->radius_m[1], v = k->normal_m_per_s;
    const double friction = material->mu_s * push_per_mv * impact_mass_kg(k) / k->mass_kg[0];
    const double turn = k->pair ? 2 * (1 + material->restitution) * v * k->contact_s / distance : 0;
    return 2.5 * (LEVER + shortened(k) + turn) * friction;
}

static const struct {
    int test;
    bool pair;
    const char *scene;
} scenes[] = {{1, true, "1_glass"},
              {1, true, "1_limestone"},
              {2, false, "2_aluminium_alloy"},
              {2, false, "2_magnesium_alloy"},
              {3, false, "3_aluminium_oxide"},
              {3, false, "3_cast_iron"},
              {4, false, "4_aluminium_oxide"},
              {4, false, "4_aluminium_alloy"},
              {5, false, "5_steel"},
              {5, false, "5_polyethylene"},
              {6, false, "6_aluminium_alloy"},
              {6, false, "6_copper"},
              {7, true, "7_aluminium_alloy"},
              {7, true, "7_copper"},
              {8, true, "8_aluminium_alloy"},
              {8, true, "8_nylon"}};

static const char *const titles[] = {
    "",
    "Test 1: elastic normal impact of two identical spheres",
    "Test 2: elastic normal impact of a sphere with a rigid plane",
    "Test 3: normal contact with different restitution coefficients",
    "Test 4: oblique impact with a rigid plane, constant resultant velocity, different angles",
    "Test 5: oblique impact with a rigid plane, constant normal velocity, different tangential velocities",
    "Test 6: impact with a rigid plane, constant normal velocity, different angular velocities",
    "Test 7: two identical spheres, constant normal velocity, different angular velocities",
    "Test 8: two differently sized spheres, constant normal velocity, different angular velocities"};

struct work {
    const char *folder, *out, *tangential;
    struct command_line *line;
    bool lammps;
    double coarser;
    int checks, missed;
    /* of the scene at hand */
    struct impacts ours, theirs;
    struct scene_material material;
    /* over all oblique impacts without and with pull: largest difference to LAMMPS, in parts of the approach */
    double slip_difference[2], spin_difference[2], ours_lever, their_lever;
};

/* Marks what is off. */
static const char *check(struct work *w, double difference, double allowed)
{
    const bool good = fabs(difference) <= allowed;
    w->checks++;
    w->missed += !good;
    return good ? " " : "*";
}

/* --- Normal impacts --- */

static void print_value(struct work *w, const char *name, const char *unit, double exact, double ours, double theirs)
{
    printf("    %-16s %-3s %14.8g %14.8g %9.1e%s", name, unit, exact, ours, ours / exact - 1,
           check(w, ours / exact - 1, ELASTIC));
    if (w->lammps)
        printf(" %14.8g %9.1e", theirs, theirs / exact - 1);
    printf("\n");
}

static void report_elastic(struct work *w)
{
    const struct impact *k = &w->ours.impact[0], *l = &w->theirs.impact[0];
    const struct impact_theory theory = impact_theory_of(k, &w->material);
    printf("    %-20s %14s %14s %9s ", "", "closed form", "Shakedown", "off by");
    printf(w->lammps ? " %14s %9s\n" : "\n", "LAMMPS", "off by");
    print_value(w, "contact time", "s", theory.contact_s, k->contact_s, l->contact_s);
    print_value(w, "largest overlap", "m", theory.peak_overlap_m, k->peak_overlap_m, l->peak_overlap_m);
    print_value(w, "largest force", "N", theory.peak_force_n, k->peak_force_n, l->peak_force_n);
    print_value(w, "restitution", "", 1, k->rebound_m_per_s / k->normal_m_per_s,
                l->rebound_m_per_s / k->normal_m_per_s);
}

static void report_restitution(struct work *w)
{
    const struct impact *k = &w->ours.impact[0], *l = &w->theirs.impact[0];
    const struct impact_theory theory = impact_theory_of(k, &w->material);
    const double e = k->rebound_m_per_s / k->normal_m_per_s;
    printf("    %8.4g %10.6f%s %14.6g %14.6g %9.1e%s", w->material.restitution, e,
           check(w, e - w->material.restitution, LOSSY), theory.contact_s, k->contact_s,
           k->contact_s / theory.contact_s - 1, check(w, k->contact_s / theory.contact_s - 1, LOSSY));
    if (w->lammps)
        printf(" %10.6f %14.6g", l->rebound_m_per_s / k->normal_m_per_s, l->contact_s);
    printf("\n");
}

/* --- Oblique impacts --- */

static double spin_change(const struct impact *k)
{
    return k->radius_m[0] * (k->spin_after_rad_per_s - k->spin_rad_per_s) / k->normal_m_per_s;
}

/* 0 if the torque is a times the force. */
static double lever_error(const struct impact *k)
{
    return fabs(spin_change(k) + 2.5 * (k->tangential_after_m_per_s - k->tangential_m_per_s) / k->normal_m_per_s);
}

static void compare(struct work *w, const struct impact *k, const struct impact *l)
{
    const int lossy = w->material.restitution < 0.9;
    const double slip = (k->slip_after_m_per_s - l->slip_after_m_per_s) / k->normal_m_per_s;
    w->slip_difference[lossy] = fmax(w->slip_difference[lossy], fabs(slip));
    w->spin_difference[lossy] = fmax(w->spin_difference[lossy], fabs(spin_change(k) - spin_change(l)));
    w->their_lever = k->pair ? w->their_lever : fmax(w->their_lever, lever_error(l));
}

static void report_oblique(struct work *w, const struct impact *k, const struct impact *l)
{
    const struct impact_theory theory = impact_theory_of(k, &w->material);
    const double v = k->normal_m_per_s, change = 3.5 * w->material.mu_s * theory.push_per_mv;
    double slip, spin;
    const bool slides = impact_sliding(k, &theory, w->material.mu_s, &slip, &spin);
    const double wanted = k->radius_m[0] * (spin - k->spin_rad_per_s) / v;
    w->ours_lever = k->pair ? w->ours_lever : fmax(w->ours_lever, lever_error(k));
    printf("    %10.4f %10.5f", k->slip_m_per_s / v, k->slip_after_m_per_s / v);
    if (slides)
        printf("%s %10.5f", check(w, (k->slip_after_m_per_s - slip) / v, (SLIDING + shortened(k)) * change), slip / v);
    else
        printf("%s %10s", check(w, lever_error(k), lever_allowed(k, &w->material, theory.push_per_mv)), "-");
    if (w->lammps)
        printf(" %10.5f", l->slip_after_m_per_s / v);
    printf("   %10.5f", spin_change(k));
    if (slides)
        printf("%s %10.5f", check(w, spin_change(k) - wanted, (SLIDING + shortened(k)) * fabs(wanted)), wanted);
    else
        printf("  %10s", "-");
    if (w->lammps)
        printf(" %10.5f", spin_change(l));
    printf("\n");
    if (w->lammps)
        compare(w, k, l);
}

static void report_all_oblique(struct work *w)
{
    printf("    %10s %10s  %10s%s   %10s  %10s%s\n", "slip/v", "after", "sliding", w->lammps ? "     LAMMPS" : "",
           "a dspin/v", "sliding", w->lammps ? "     LAMMPS" : "");
    for (int k = 0; k < w->ours.count; k++)
        report_oblique(w, &w->ours.impact[k], &w->theirs.impact[k]);
}

/* --- Scenes --- */

static enum status run_sample(struct work *w, const struct scene *scene, bool pair, const char *name)
{
    struct sample *sample;
    TRY(sample_from_scene(&sample, scene));
    enum status status = impacts_of(&w->ours, sample, pair);
    w->theirs = w->ours;
    if (status == STATUS_OK && w->lammps)
        status = impacts_run_lammps(&w->theirs, sample, w->tangential, w->out, name);
    if (status == STATUS_OK)
        status = impacts_run(&w->ours, sample);
    sample_free(sample);
    return status;
}

/* The scene with one more assignment, or NULL. */
static enum status run_scene_with(struct work *w, int s, const char *assignment)
{
    char path[1024];
    const char *overrides[COMMAND_LINE_OVERRIDES_MAX + 1];
    int n = 0;
    struct scene *scene = calloc(1, sizeof *scene);
    if (!scene)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    for (; n < w->line->n_overrides; n++)
        overrides[n] = w->line->override[n];
    if (assignment)
        overrides[n++] = assignment;
    snprintf(path, sizeof path, "%s/%s.cfg", w->folder, scenes[s].scene);
    enum status status = scene_load(scene, path, overrides, n);
    if (status == STATUS_OK) {
        scene->stage[0].dt_s *= w->coarser;
        w->material = scene->stage[0].material;
        status = run_sample(w, scene, scenes[s].pair, scenes[s].scene);
    }
    scene_free(scene);
    free(scene);
    return status;
}

static enum status restitutions(struct work *w, int s)
{
    static const char *const values[] = {"0.1", "0.2", "0.4", "0.6", "0.8", "0.9", "1.0"};
    printf("    %8s %10s  %14s %14s %9s ", "asked", "Shakedown", "time by ODE, s", "Shakedown", "off by");
    printf(w->lammps ? " %10s %14s\n" : "\n", "LAMMPS", "its time");
    for (size_t k = 0; k < sizeof values / sizeof *values; k++) {
        char assignment[64];
        snprintf(assignment, sizeof assignment, "material.restitution=%s", values[k]);
        TRY(run_scene_with(w, s, assignment));
        report_restitution(w);
    }
    return STATUS_OK;
}

static enum status report_scene(struct work *w, int s)
{
    if (s == 0 || scenes[s].test != scenes[s - 1].test)
        printf("\n%s\n", titles[scenes[s].test]);
    printf("  %s\n", scenes[s].scene + 2);
    if (scenes[s].test == 3)
        return restitutions(w, s);
    TRY(run_scene_with(w, s, NULL));
    if (scenes[s].test < 3)
        report_elastic(w);
    else
        report_all_oblique(w);
    return STATUS_OK;
}

static enum status summary(const struct work *w)
{
    printf("\n%d checks, %d missed (*). Levers of walls: spins differ from those of a lever a by %.1e", w->checks,
           w->missed, w->ours_lever);
    if (w->lammps)
        printf("; of LAMMPS's by %.1e.\nLargest difference to LAMMPS (%s), in parts of the approach: "
               "slip %.1e, a times spin %.1e for e near 1; %.1e and %.1e for e = 0.5",
               w->their_lever, w->tangential, w->slip_difference[0], w->spin_difference[0], w->slip_difference[1],
               w->spin_difference[1]);
    printf(".\n");
    return w->missed ? status_fail(STATUS_LIMIT, "%d of %d checks missed", w->missed, w->checks) : STATUS_OK;
}

int main(int argc, char **argv)
{
    struct command_line line;
    const char *coarser = "1";
    struct work w = {.line = &line, .folder = "scenes/benchmarks", .out = ".", .tangential = "mindlin_rescale/force"};
    const struct command_line_option own[] = {{"scenes", &w.folder, NULL},         {"out", &w.out, NULL},
                                              {"coarser", &coarser, NULL},         {"lammps", NULL, &w.lammps},
                                              {"tangential", &w.tangential, NULL}, {NULL, NULL, NULL}};
    floating_point_flush_subnormals();
    enum status status = command_line_parse(&line, argc, argv, own);
    if (status == STATUS_OK && line.n_positional > 0)
        status = status_fail(STATUS_USAGE, "usage: bench_impacts [--scenes DIR] [--out DIR] [--lammps] [--set K=V]...");
    w.coarser = strtod(coarser, NULL);
    if (status == STATUS_OK && !(w.coarser > 0))
        status = status_fail(STATUS_USAGE, "--coarser wants a number above 0, not \"%s\"", coarser);
    if (status == STATUS_OK)
        status = folder_make(w.out);
    for (size_t s = 0; s < sizeof scenes / sizeof *scenes && status == STATUS_OK; s++)
        status = report_scene(&w, (int)s);
    if (status == STATUS_OK)
        status = summary(&w);
    return status_report("bench_impacts", status);
}
