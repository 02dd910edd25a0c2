/* The benchmark against peers: what it writes for them, what it reads from them. None of them is needed. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "bench/child.h"
#include "bench/peers_bench.h"
#include "bench/peers_output.h"
#include "bench/prepared_sample.h"
#include "common/scene_file.h"
#include "sim_fixture.h"

static char *text_of(void (*write)(FILE *out, const void *what), const void *what)
{
    char buffer[8192] = "";
    FILE *out = fmemopen(buffer, sizeof buffer, "w");
    assert_non_null(out);
    write(out, what);
    assert_int_equal(fclose(out), 0);
    char *text = strdup(buffer);
    assert_non_null(text);
    return text;
}

static void write_lammps_data(FILE *out, const void *sample)
{
    peers_write_data(out, PEER_LAMMPS, sample);
}

static void write_liggghts_data(FILE *out, const void *sample)
{
    peers_write_data(out, PEER_LIGGGHTS, sample);
}

static void write_script(FILE *out, const void *input)
{
    peers_write_script(out, input);
}

/* The line after `heading` and an empty one. */
static const char *line_after(const char *text, const char *heading)
{
    const char *at = strstr(text, heading);
    assert_non_null(at);
    at = strchr(at, '\n');
    assert_non_null(at);
    return at + 2;
}

/* Every number comes back to the last bit; the mass by way of the density, to rounding: three products and a quotient
 * on either side, 4 eps each. */
static void packing_is_what_we_have(void **state)
{
    (void)state;
    struct fixture_options options = {.dimension = 2, .count = 3, .material = "kn_n_per_m = 1e3;", .dt_s = 1e-6};
    struct fixture f = fixture_open(&options);
    struct particles *p = &f.sample->particles;
    p->radius[0] = 1.1e-3;
    p->x[1][0] += 1e-17;
    p->v[1][0] = -1.0 / 3;
    fixture_start(&f);
    char *text = text_of(write_lammps_data, f.sample);
    assert_non_null(strstr(text, "\n3 atoms\n1 atom types\n"));
    double lo, hi, diameter, density, x, y, z, vx, vy;
    assert_int_equal(sscanf(line_after(text, "1 atom types") - 1, "%lf %lf xlo xhi", &lo, &hi), 2);
    assert_true(lo == f.sample->walls[0].x && hi == f.sample->walls[1].x);
    assert_int_equal(sscanf(line_after(text, "Atoms"), "1 1 %lf %lf %lf %lf %lf\n2 ", &diameter, &density, &x, &y, &z),
                     5);
    assert_true(diameter == 2 * p->radius[0] && x == p->x[0][0] && y == p->x[1][0] && z == 0);
    double mass = density * 4.0 / 3 * acos(-1.0) * diameter * diameter * diameter / 8;
    assert_close("mass [kg]", mass, p->mass[0], 8 * 2.3e-16 * p->mass[0]);
    assert_int_equal(sscanf(line_after(text, "Velocities"), "1 %lf %lf 0 0 0 0\n2 0 0 0 0 0 0\n3", &vx, &vy), 2);
    assert_true(vx == 0 && vy == -1.0 / 3);
    free(text);
    text = text_of(write_liggghts_data, f.sample);
    assert_non_null(strstr(text, "\n-0.011000000000000001 0.011000000000000001 zlo zhi\n")); /* 10 largest radii */
    free(text);
    fixture_close(&f);
}

static void packing_in_three_dimensions_spins(void **state)
{
    (void)state;
    struct fixture_options options = {
        .dimension = 3, .count = 2, .material = "kn_n_per_m = 1e3; mu_s = 0.5; kt_n_per_m = 1e2;", .dt_s = 1e-6};
    struct fixture f = fixture_open(&options);
    f.sample->particles.omega[2][1] = 7;
    for (int c = 0; c < 3; c++)
        f.sample->particles.v[c][1] = 0.5 * c;
    char *text = text_of(write_lammps_data, f.sample);
    if (!strstr(text, "\n2 0 0.5 1 0 0 7\n"))
        fail_msg("no spin in:\n%s", text);
    free(text);
    fixture_close(&f);
}

static struct peer_input two_dimensions(enum peer peer, enum peer_law law)
{
    return (struct peer_input){.peer = peer,
                               .law = law,
                               .dimension = 2,
                               .data = "the.data",
                               .kn = 1000,
                               .gamma_n = 0.5,
                               .k2 = 4000,
                               .kc = 2000,
                               .restitution = 0.5,
                               .reduced_mass = 0.25,
                               .gamma_b = 0.125,
                               .hi = {1, 2},
                               .dt_s = 0.5,
                               .skin_m = 0.25,
                               .delay = 3,
                               .steps = 40};
}

static struct peer_input three_dimensions(enum peer peer, enum peer_law law)
{
    struct peer_input input = two_dimensions(peer, law);
    input.dimension = 3;
    input.frictional = true;
    input.hi[2] = 4;
    input.kt = 200;
    input.gamma_t = 0.125;
    input.mu = 0.5;
    return input;
}

static void assert_says(const struct peer_input *input, const char *const *lines)
{
    char *text = text_of(write_script, input);
    for (; *lines; lines++)
        if (!strstr(text, *lines))
            fail_msg("no \"%s\" in:\n%s", *lines, text);
    free(text);
}

/* gran/hooke: damping gamma_n/m_12, at walls, where the reduced mass is the particle's, 2 m_12, half of that. */
static void lammps_is_told_the_scene(void **state)
{
    (void)state;
    struct peer_input input = two_dimensions(PEER_LAMMPS, PEER_HOOKE);
    assert_says(&input,
                (const char *const[]){"dimension 2\nboundary f f p\n", "read_data the.data\n",
                                      "pair_style gran/hooke 1000 0 2 0 0 0\npair_coeff * *\n",
                                      "neighbor 0.25 bin\nneigh_modify every 1 delay 3 check yes\n",
                                      "fix wallx all wall/gran hooke 1000 0 1 0 0 0 xplane 0 1\n", "yplane 0 2\n",
                                      "fix motion all nve\n", "viscous 0.125\n", "timestep 0.5\n", "run 40\n", NULL});
    input = three_dimensions(PEER_LAMMPS, PEER_HOOKE);
    assert_says(&input,
                (const char *const[]){"dimension 3\nboundary f f f\n", "gran/hooke/history 1000 200 2 0.5 0.5 1\n",
                                      "zplane 0 4\n", "fix motion all nve/sphere\n", NULL});
    input = three_dimensions(PEER_LAMMPS, PEER_GRANULAR);
    assert_says(&input, (const char *const[]){"hooke 1000 0.5 tangential linear_history 200 0.25 0.5 damping velocity",
                                              "wall/gran granular hooke 1000 0.5 damping velocity", NULL});
    input.walls_move = true;
    assert_says(&input, (const char *const[]){"region wall5 plane 0 0 4 0 0 -1 side in move NULL NULL v_path5",
                                              "fix wall5 all wall/gran/region", NULL});
}

static void liggghts_is_told_the_scene(void **state)
{
    (void)state;
    struct peer_input input = three_dimensions(PEER_LIGGGHTS, PEER_STIFFNESS);
    assert_says(&input,
                (const char *const[]){"kn peratomtypepair 1 1000\n", "kt peratomtypepair 1 200\n",
                                      "gamman_abs peratomtypepair 1 0.5\n", "gammat_abs peratomtypepair 1 0.125\n",
                                      "coefficientFriction peratomtypepair 1 0.5\n",
                                      "model hooke/stiffness tangential history absolute_damping on\n",
                                      "primitive type 1 zplane 4 absolute_damping on\n", NULL});
    input = two_dimensions(PEER_LIGGGHTS, PEER_LUDING);
    assert_says(&input, (const char *const[]){"boundary f f f\n", "LoadingStiffness peratomtypepair 1 1000\n",
                                              "UnloadingStiffness peratomtypepair 1 4\n",
                                              "coefficientAdhesionStiffness peratomtypepair 1 2\n",
                                              "coefficientRestitution peratomtypepair 1 0.5\n",
                                              "coefficientFriction peratomtypepair 1 0\n",
                                              "model luding tangential no_history", "yplane 2 \n", NULL});
    input.dump = "the.dump";
    assert_says(&input, (const char *const[]){"custom 1000000000 the.dump id x y z fx fy fz\n",
                                              "dump_modify state first no every 40\n", NULL});
}

static struct peer_input hertz(enum peer peer)
{
    struct peer_input input = three_dimensions(peer, PEER_HERTZ);
    input.youngs_modulus = 75;
    input.poisson = 0.5; /* E* = E/(2 (1 - 1/4)) = 50, S_t/S_n = 2 (1/2)/(3/2) = 2/3 */
    input.tangential = "mindlin_rescale/force";
    input.restitution = 1; /* no dashpot */
    return input;
}

static void both_are_told_hertz(void **state)
{
    (void)state;
    struct peer_input input = hertz(PEER_LAMMPS);
    char damped[200];
    assert_says(&input,
                (const char *const[]){"pair_style granular\npair_coeff * * hertz/material 75 0 0.5 damping velocity "
                                      "tangential mindlin_rescale/force NULL 0.8164965809277",
                                      "wall/gran granular hertz 66.66666666666", NULL});
    input.restitution = 0.5;
    snprintf(damped, sizeof damped, "hertz/material 75 %.17g 0.5 damping tsuji ", peers_tsuji_restitution(0.5));
    assert_says(&input, (const char *const[]){damped, NULL});
    input.frictional = false;
    assert_says(&input, (const char *const[]){"damping tsuji tangential linear_nohistory 0 0\n", NULL});
    input = hertz(PEER_LIGGGHTS);
    assert_says(&input,
                (const char *const[]){"hard_particles yes\nunits si\n", "youngsModulus peratomtype 75\n",
                                      "poissonsRatio peratomtype 0.5\n", "coefficientRestitution peratomtypepair 1 1\n",
                                      "pair_style gran model hertz tangential history \n", NULL});
}

/* LAMMPS' polynomial at what it is told is sqrt(5) beta, to the polynomial's rounding. */
static void tsuji_is_told_another_restitution(void **state)
{
    (void)state;
    for (double e = 0.15; e < 0.99; e += 0.1) {
        const double x = peers_tsuji_restitution(e), pi = acos(-1.0), beta = -log(e) / sqrt(pi * pi + log(e) * log(e));
        const double alpha = 1.2728 - 4.2783 * x + 11.087 * x * x - 22.348 * pow(x, 3) + 27.467 * pow(x, 4) -
                             18.022 * pow(x, 5) + 4.8218 * pow(x, 6);
        assert_true(x > 0 && x < e);
        assert_close("alpha", alpha, sqrt(5) * beta, 1e-13);
    }
}

/* The box is 1 x 2 x 4: a strain s moves its ends by s/2, s and 2 s; the shear rate of x along y is 3/s. */
static void states_follow_each_other(void **state)
{
    (void)state;
    const struct peer_state states[] = {{.name = "start", .mu = 9},
                                        {.strain = 0.25, .velocity_per_s = {{0, 3, 0}}, .mu = 9},
                                        {.name = "end", .instant = true, .mu = 0.5}};
    static const char *const lines[] = {
        "dump state all custom 1 the.dump id x y z vx vy vz fx fy fz\n",
        "velocity all set 0 0 0 units box\ntimestep 0.5\nrun 1\n",
        "displace_atoms all ramp x -0.125 0.125 x 0 1 units box\n",
        "velocity all ramp vx -3 3 y 0 2 sum yes units box\n",
        "displace_atoms all ramp z -0.5 0.5 z 0 4 units box\ntimestep 0.5\nrun 1 pre no\n",
        "timestep 1.0000000000000001e-30\nrun 1\n",
        NULL};
    for (int peer = PEER_LAMMPS; peer <= PEER_LIGGGHTS; peer++) {
        struct peer_input input = hertz(peer);
        input.dump = "the.dump";
        input.state = states;
        input.n_states = 3;
        assert_says(&input, lines);
        assert_says(&input, peer == PEER_LAMMPS
                                ? (const char *const[]){"0.5\nunfix wallx\n", "unfix wallz\nfix wallx all", NULL}
                                : (const char *const[]){"unfix coefficientFriction\nfix coefficientFriction all "
                                                        "property/global coefficientFriction peratomtypepair 1 0.5\n",
                                                        NULL});
    }
}

static const char LAMMPS_LOG[] =
    "LAMMPS (29 Sep 2021 - Update 2)\nSetting up Verlet run ...\nStep Temp E_pair E_mol TotEng Press \n"
    "       0            0            0            0            0            0 \n"
    "Loop time of 3.0 on 1 procs for 50 steps with 1950 atoms\n\n43.6% CPU use with 1 MPI tasks x 1 OpenMP threads\n"
    "Loop time of 0.5 on 1 procs for 4000 steps with 1950 atoms\n\nTotal # of neighbors = 4325\n";
static const char LIGGGHTS_LOG[] = "LIGGGHTS (Version LIGGGHTS-PUBLIC 3.8.0)\n    Step    Atoms         KinEng\n"
                                   "Loop time of 0.25 on 1 procs for 1000 steps with 1950 atoms, finish time Sun\n";
static const char OUR_LOG[] = "sim: note: hold: starts at rest\nsim: 40000 steps, 0.400 s, 10.00 us per step, 25 list "
                              "builds, 4700 candidates, hash 0\nsim: verdict: sound\n";

static void time_of_the_last_loop(void **state)
{
    (void)state;
    double us = 0;
    must(peers_read_loop(LAMMPS_LOG, 1, &us));
    assert_close("LAMMPS [us]", us, 125, 1e-10);
    must(peers_read_loop(LIGGGHTS_LOG, 1, &us));
    assert_close("LIGGGHTS [us]", us, 250, 1e-10);
    must(peers_read_loop(OUR_LOG, 1, &us));
    assert_close("ours [us]", us, 10, 1e-11);
}

/* Of ranks: the wall time of the loop, which they have in common. */
static void time_of_a_loop_of_ranks(void **state)
{
    (void)state;
    static const char log[] = "Loop time of 3.0 on 2 procs for 50 steps with 100000 atoms\n\n"
                              "99.1% CPU use with 2 MPI tasks x 1 OpenMP threads\n"
                              "Loop time of 2.5 on 2 procs for 500 steps with 100000 atoms\n";
    double us = 0;
    must(peers_read_loop(log, 2, &us));
    assert_close("two ranks [us]", us, 5000, 1e-10);
    assert_int_equal(peers_read_loop(log, 1, &us), STATUS_FORMAT);
    assert_int_equal(peers_read_loop(log, 4, &us), STATUS_FORMAT);
    assert_int_equal(peers_read_loop(LAMMPS_LOG, 2, &us), STATUS_FORMAT); /* mpirun of a program without MPI */
}

static void logs_without_a_time_are_refused(void **state)
{
    (void)state;
    static const char *const bad[] = {"",
                                      "ERROR: Loop time of 1 on 1 procs for 10 steps\n",
                                      "Loop time of 1e-6 on 1 procs for 0 steps with 2 atoms\n",
                                      "Loop time of 1 on 2 procs for 100 steps with 2 atoms\n",
                                      "Loop time of x on 1 procs for 100 steps with 2 atoms\n",
                                      "sim: error: broken\n"};
    double us;
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++)
        assert_int_equal(peers_read_loop(bad[k], 1, &us), STATUS_FORMAT);
}

#define DUMP_HEAD(step)                                                                                                \
    "ITEM: TIMESTEP\n" step "\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n-1 1\n"                  \
    "ITEM: ATOMS id x y z fx fy fz \n"

static void dump_gives_the_last_state(void **state)
{
    (void)state;
    double x[6], f[6];
    must(peers_read_dump(DUMP_HEAD("0") "1 9 9 9 9 9 9 \n2 9 9 9 9 9 9 \n" DUMP_HEAD(
                             "5") "1 0.5 0.25 0 -1.0033424329307579 0 1 \n2 0.75 1 2 3 4 5 \n",
                         2, x, f));
    assert_true(x[0] == 0.5 && x[1] == 0.25 && x[2] == 0 && x[3] == 0.75 && x[5] == 2);
    assert_true(f[0] == -1.0033424329307579 && f[2] == 1 && f[3] == 3 && f[5] == 5);
}

static void broken_dumps_are_refused(void **state)
{
    (void)state;
    static const char *const bad[] = {"", "ITEM: ATOMS id x y z\n1 0 0 0\n2 0 0 0\n",
                                      DUMP_HEAD("0") "1 0 0 0 0 0 0\n",                /* cut */
                                      DUMP_HEAD("0") "2 0 0 0 0 0 0\n1 0 0 0 0 0 0\n", /* not sorted */
                                      DUMP_HEAD("0") "1 0 0 0 nan 0 0\n2 0 0 0 0 0 0\n"};
    double x[6], f[6];
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++)
        assert_int_equal(peers_read_dump(bad[k], 2, x, f), STATUS_FORMAT);
}

static void snapshots_in_turn(void **state)
{
    static const char head[] = "ITEM: ATOMS id x y z vx vy vz fx fy fz\n";
    char text[300];
    double x[3], v[3], f[3];
    (void)state;
    snprintf(text, sizeof text, "%s1 1 2 3 4 5 6 7 8 9\nITEM: TIMESTEP\n1\n%s1 9 8 7 6 5 4 3 2 1\n", head, head);
    must(peers_read_snapshot(text, 0, 1, x, v, f));
    assert_true(x[0] == 1 && v[0] == 4 && f[2] == 9);
    must(peers_read_snapshot(text, 1, 1, x, v, f));
    assert_true(x[0] == 9 && v[2] == 4 && f[2] == 1);
    assert_int_equal(peers_read_snapshot(text, 2, 1, x, v, f), STATUS_FORMAT);
    assert_int_equal(peers_read_snapshot(text, 1, 2, x, v, f), STATUS_FORMAT);
}

/* What is done to a copy does not reach the scene. */
static void a_copy_is_its_own(void **state)
{
    (void)state;
    struct fixture_options options = {.dimension = 2, .count = 3, .material = "kn_n_per_m = 1e3;", .dt_s = 1e-6};
    struct fixture f = fixture_open(&options);
    struct scene *copy = prepare_scene_copy(f.scene);
    assert_non_null(copy);
    assert_string_equal(copy->text, f.scene->text);
    copy->stage[0].material.kn_n_per_m = 7;
    prepare_scene_free(copy);
    prepare_scene_free(NULL);
    assert_true(f.scene->stage[0].material.kn_n_per_m == 1e3);
    fixture_close(&f);
}

/* Differences of length 5 and 0: largest 5, rms 5/sqrt(2). */
static void difference_of_states(void **state)
{
    (void)state;
    const double a[6] = {0, 0, 0, 1, 1, 1}, b[6] = {3, 0, -4, 1, 1, 1};
    struct peers_difference d = peers_compare(a, b, 2);
    assert_close("largest", d.largest, 5, 1e-15);
    assert_close("rms", d.rms, 5 / sqrt(2), 1e-15);
}

/* The last stage, written and read again, starts from the checkpoint and is what it was. */
static void last_stage_alone(void **state)
{
    (void)state;
    struct scene *scene = fixture_scene_of(
        "dimension = 2; sample = { count = 4; radius_min_m = 1e-3; radius_max_m = 1e-3; density_kg_per_m3 = 2e3; };\n"
        "material = { kn_n_per_m = 1e3; }; analysis = { stage = \"b\"; };\n"
        "stages = ( { name = \"a\"; dt_s = 1e-6; duration_s = 1.0; },\n"
        "           { name = \"b\"; dt_s = 2e-6; duration_s = 3.0; material = { kn_n_per_m = 2e3; }; } );\n");
    char path[] = "/tmp/shakedown-stage-XXXXXX";
    int file = mkstemp(path);
    assert_true(file >= 0);
    prepare_stage(scene, 1, path);
    must(prepare_scene_file(scene, path));
    struct scene *again = calloc(1, sizeof *again);
    assert_non_null(again);
    must(scene_load(again, path, NULL, 0));
    assert_int_equal(again->n_stages, 1);
    assert_string_equal(again->stage[0].name, "b");
    assert_true(again->stage[0].dt_s == 2e-6 && again->stage[0].material.kn_n_per_m == 2e3);
    assert_int_equal(again->sample.initial, INITIAL_CHECKPOINT);
    assert_string_equal(again->sample.checkpoint, path);
    fixture_scene_free(again);
    fixture_scene_free(scene);
    assert_int_equal(remove(path), 0);
}

/* A pair that has been pressed and sheared knows nothing of it afterwards. */
static void contacts_forget(void **state)
{
    (void)state;
    struct fixture_options options = {
        .dimension = 3,
        .material = "law = \"hysteretic\"; k1_n_per_m = 1e3; k2_n_per_m = 2e3; mu_s = 0.5; kt_n_per_m = 1e2;",
        .dt_s = 1e-7};
    struct fixture f = fixture_pair(&options, 1e-5, 0.01);
    f.sample->particles.v[1][0] = 0.01;
    fixture_steps(&f, 10);
    assert_true(contact_list_value(&f.sample->pairs, HISTORY_MAX_OVERLAP, 0) > 0 &&
                contact_list_spring(&f.sample->pairs, 1, 0) != 0);
    must(prepare_forget(f.sample));
    assert_true(contact_list_value(&f.sample->pairs, HISTORY_MAX_OVERLAP, 0) == 0);
    for (int c = 0; c < 3; c++)
        assert_true(contact_list_spring(&f.sample->pairs, c, 0) == 0);
    fixture_close(&f);
}

/* A peer that writes down its packing and leaves a log where it runs, as LIGGGHTS does whatever it is told. */
static const char FAKE_PEER[] = "#!/bin/sh\n"
                                "echo left >log.peer && [ -f physics.data ] && cat \"$2\"\n";

/* mpirun -np N PROGRAM ...: says how many ranks, and starts one. */
static const char FAKE_MPIRUN[] = "#!/bin/sh\n"
                                  "[ \"$1\" = -np ] && echo \"$2 ranks\" && shift 2 && exec \"$@\"\n";

static void write_fake(const char *folder, const char *name, const char *text)
{
    char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
    assert_int_equal(chmod(path, 0755), 0);
}

/* The folder is told relative to the current one, and what the peer leaves is in it. */
static void a_peer_runs_in_its_folder(void **state)
{
    static const char *const files[] = {"log.peer", "physics.data", "physics.in", "physics.log"};
    struct fixture_options options = {.dimension = 2, .count = 3, .material = "kn_n_per_m = 1e3;", .dt_s = 1e-6};
    struct fixture f = fixture_open(&options);
    struct peer_input input = two_dimensions(PEER_LAMMPS, PEER_HOOKE);
    char here[] = "/tmp/shakedown-peers-XXXXXX", path[4200], *text;
    (void)state;
    assert_non_null(mkdtemp(here));
    assert_int_equal(chdir(here), 0);
    must(folder_make("its"));
    write_fake(here, "lmp", FAKE_PEER);
    write_fake(here, "mpirun", FAKE_MPIRUN);
    snprintf(path, sizeof path, "%s:%s", here, getenv("PATH"));
    assert_int_equal(setenv("PATH", path, 1), 0);
    must(peers_run(&input, f.sample, "its", "physics"));
    must(file_read("its/physics.log", &text));
    assert_non_null(strstr(text, "read_data physics.data\n"));
    assert_null(strstr(text, "ranks"));
    free(text);
    input.processes = 3;
    must(peers_run(&input, f.sample, "its", "physics"));
    must(file_read("its/physics.log", &text));
    assert_true(strncmp(text, "3 ranks\n", 8) == 0 && strstr(text, "read_data physics.data\n"));
    free(text);
    for (size_t k = 0; k < sizeof files / sizeof *files; k++) {
        snprintf(path, sizeof path, "its/%s", files[k]);
        assert_int_equal(remove(path), 0);
    }
    assert_int_equal(remove("lmp"), 0);
    assert_int_equal(remove("mpirun"), 0);
    assert_int_equal(remove("its"), 0);
    assert_int_equal(remove(here), 0); /* nothing else was left */
    assert_int_equal(chdir("/"), 0);
    fixture_close(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(packing_is_what_we_have),
        cmocka_unit_test(packing_in_three_dimensions_spins),
        cmocka_unit_test(lammps_is_told_the_scene),
        cmocka_unit_test(liggghts_is_told_the_scene),
        cmocka_unit_test(time_of_the_last_loop),
        cmocka_unit_test(time_of_a_loop_of_ranks),
        cmocka_unit_test(logs_without_a_time_are_refused),
        cmocka_unit_test(dump_gives_the_last_state),
        cmocka_unit_test(broken_dumps_are_refused),
        cmocka_unit_test(difference_of_states),
        cmocka_unit_test(last_stage_alone),
        cmocka_unit_test(contacts_forget),
        cmocka_unit_test(a_peer_runs_in_its_folder),
        cmocka_unit_test(both_are_told_hertz),
        cmocka_unit_test(tsuji_is_told_another_restitution),
        cmocka_unit_test(states_follow_each_other),
        cmocka_unit_test(snapshots_in_turn),
        cmocka_unit_test(a_copy_is_its_own),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
