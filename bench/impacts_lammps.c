/* LAMMPS: pair_style granular hertz/material with a tangential style of Mindlin's, state of every step dumped as text.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "bench/child.h"
#include "bench/impacts.h"
#include "bench/peers_input.h"

/* LAMMPS takes the damping from e by the polynomial of Tsuji et al. (1992), an approximation of sqrt(5) beta; what it
 * is told here is the number for which the polynomial gives that exactly. */
static double tsuji(double e)
{
    return 1.2728 + e * (-4.2783 + e * (11.087 + e * (-22.348 + e * (27.467 + e * (-18.022 + e * 4.8218)))));
}

static double lammps_restitution(double e)
{
    const double pi = acos(-1.0), wanted = -sqrt(5) * log(e) / sqrt(pi * pi + log(e) * log(e));
    double low = 0, high = 1.1;
    for (int k = 0; k < 60; k++) {
        const double middle = 0.5 * (low + high);
        if (tsuji(middle) > wanted)
            low = middle;
        else
            high = middle;
    }
    return 0.5 * (low + high);
}

/* For the floor, LAMMPS of 2021 takes E/(2 (1 - nu)) for E*, not E/(2 (1 - nu^2)) (findings/lammps-wall-modulus.sh): it
 * is told E/(1 + nu). */
static void law_text(char *text, size_t size, const struct scene_material *m, const char *tangential, bool of_floor)
{
    const double nu = m->poisson_ratio, modulus = m->youngs_modulus_pa / (2 * (1 - nu * nu));
    const double shear = m->youngs_modulus_pa / (4 * (2 - nu) * (1 + nu));
    int n = snprintf(text, size, "hertz/material %.17g %.17g %.17g damping tsuji tangential ",
                     m->youngs_modulus_pa / (of_floor ? 1 + nu : 1), lammps_restitution(m->restitution), nu);
    if (m->mu_s > 0) /* damping of both directions by one beta: gamma_t over gamma_n is the root of S_t over S_n */
        snprintf(text + n, size - (size_t)n, "%s %.17g %.17g %.17g", tangential, 8 * shear, sqrt(4 * shear / modulus),
                 m->mu_s);
    else
        snprintf(text + n, size - (size_t)n, "linear_nohistory 0 0");
}

static void write_script(FILE *out, const struct sample *sample, const char *tangential, const char *name,
                         bool floor_there, double radius_m)
{
    const struct scene_stage *stage = &sample->scene->stage[0];
    char law[512];
    law_text(law, sizeof law, &stage->material, tangential, false);
    fprintf(out,
            "units si\ndimension 3\nboundary f f f\natom_style sphere\natom_modify map array sort 0 0\nnewton off\n"
            "comm_modify mode single vel yes\nread_data %s.data\npair_style granular\npair_coeff * * %s\n"
            "neighbor %.17g bin\nneigh_modify every 1 delay 0 check yes\n",
            name, law, 0.1 * radius_m);
    law_text(law, sizeof law, &stage->material, tangential, true);
    if (floor_there)
        fprintf(out, "fix floor all wall/gran granular %s zplane %.17g NULL\n", law, sample->walls[4].x);
    fprintf(out,
            "fix motion all nve/sphere\ntimestep %.17g\nthermo 1000000000\n"
            "dump state all custom 1 %s.dump id x y z vx vy vz fx fy fz omegay\n"
            "dump_modify state sort id format line \"%%d%s\"\nrun %lld\n",
            stage->dt_s, name, " %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g",
            llround(stage->duration_s / stage->dt_s));
}

static enum status write_input(const struct impacts *impacts, const struct sample *sample, const char *tangential,
                               const char *folder, const char *name)
{
    char path[1024];
    snprintf(path, sizeof path, "%s/%s.data", folder, name);
    FILE *data = fopen(path, "w");
    snprintf(path, sizeof path, "%s/%s.in", folder, name);
    FILE *script = fopen(path, "w");
    bool good = data && script;
    if (good) {
        peers_write_data(data, PEER_LAMMPS, sample);
        write_script(script, sample, tangential, name, !impacts->impact[0].pair, impacts->impact[0].radius_m[0]);
    }
    good = (!data || fclose(data) == 0) && good;
    good = (!script || fclose(script) == 0) && good;
    return good ? STATUS_OK : status_fail(STATUS_IO, "%s cannot be written", path);
}

static enum status frame_read(FILE *dump, int count, double *values, bool *there)
{
    enum { HEADER_LINES = 9 };
    char line[1024];
    *there = false;
    for (int k = 0; k < HEADER_LINES; k++)
        if (!fgets(line, sizeof line, dump))
            return k == 0 ? STATUS_OK : status_fail(STATUS_FORMAT, "a frame of LAMMPS breaks off");
    for (int id = 0; id < count; id++) {
        int of = 0;
        bool good = fscanf(dump, "%d", &of) == 1 && of == id + 1;
        for (int c = 0; c < 10 && good; c++)
            good = fscanf(dump, "%lf", &values[c * count + id]) == 1;
        if (!good || (getc(dump) != '\n' && !fgets(line, sizeof line, dump)))
            return status_fail(STATUS_FORMAT, "a frame of LAMMPS is not what was asked for");
    }
    *there = true;
    return STATUS_OK;
}

static enum status frames_look(struct impacts *impacts, FILE *dump, const struct sample *sample, double *values)
{
    const int n = sample->particles.count;
    struct impact_state state = {0};
    bool there;
    for (int c = 0; c < 3; c++) {
        state.x[c] = values + c * n;
        state.v[c] = values + (3 + c) * n;
        state.force[c] = values + (6 + c) * n;
    }
    state.omega_y = values + 9 * n;
    for (int64_t step = 0;; step++) {
        TRY(frame_read(dump, n, values, &there));
        if (!there)
            return step > 1 ? STATUS_OK : status_fail(STATUS_FORMAT, "LAMMPS dumped nothing");
        state.time_s = (double)step * sample->scene->stage[0].dt_s;
        impacts_look(impacts, &state);
    }
}

enum status impacts_run_lammps(struct impacts *impacts, const struct sample *sample, const char *tangential,
                               const char *folder, const char *name)
{
    char script[300], log[1024], path[1024];
    TRY(write_input(impacts, sample, tangential, folder, name));
    snprintf(script, sizeof script, "%s.in", name);
    snprintf(log, sizeof log, "%s/%s.log", folder, name);
    snprintf(path, sizeof path, "%s/%s.dump", folder, name);
    const char *const argv[] = {"lmp", "-in", script, "-log", "none", "-nocite", NULL};
    struct child child = {.argv = argv, .log = log, .folder = folder, .variable = "OMP_NUM_THREADS", .value = "1"};
    TRY(child_run(&child));
    FILE *dump = fopen(path, "r");
    double *values = calloc(10 * (size_t)sample->particles.count, sizeof *values);
    enum status status =
        dump && values ? frames_look(impacts, dump, sample, values) : status_fail(STATUS_IO, "%s cannot be read", path);
    free(values);
    if (dump)
        fclose(dump);
    return status;
}
