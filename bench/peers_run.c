/* A scene as a peer is told it, and a run of the peer. */
#include <stdlib.h>
#include <string.h>

#include "bench/child.h"
#include "bench/peers_bench.h"

static const char *const PROGRAM[] = {[PEER_LAMMPS] = "lmp", [PEER_LIGGGHTS] = "liggghts"};

double peers_mean_radius(const struct sample *sample)
{
    double sum = 0;
    for (int i = 0; i < sample->particles.count; i++)
        sum += sample->particles.radius[i];
    return sum / sample->particles.count;
}

struct peer_input peers_input_of(const struct scene *scene, const struct sample *sample)
{
    const struct scene_material *m = &scene->stage[0].material;
    bool hysteretic = m->law == LAW_HYSTERETIC || m->law == LAW_ELASTOPLASTIC;
    double mass = 0;
    for (int i = 0; i < sample->particles.count; i++)
        mass += sample->particles.mass[i] / sample->particles.count;
    struct peer_input input = {.dimension = sample->particles.dimension,
                               .frictional = m->mu_s > 0 || m->mu_d > 0,
                               .kn = hysteretic ? m->k1_n_per_m : m->kn_n_per_m,
                               .gamma_n = m->gamma_n_kg_per_s,
                               .kt = m->kt_n_per_m,
                               .gamma_t = m->gamma_t_kg_per_s,
                               .mu = m->mu_s,
                               .k2 = m->k2_n_per_m,
                               .kc = m->kc_n_per_m,
                               .plasticity_depth = 0.5, /* far above the overlaps: k2 is reached there */
                               .youngs_modulus = m->youngs_modulus_pa,
                               .poisson = m->poisson_ratio,
                               .tangential = "mindlin_rescale/force",
                               .restitution = m->restitution,
                               .reduced_mass = 0.5 * mass,
                               .gamma_b = m->gamma_b_kg_per_s,
                               .dt_s = scene->stage[0].dt_s,
                               .skin_m = 0.1 * peers_mean_radius(sample)};
    for (int c = 0; c < input.dimension; c++) {
        input.lo[c] = sample->walls[2 * c].x;
        input.hi[c] = sample->walls[2 * c + 1].x;
    }
    return input;
}

static enum status write_files(const struct peer_input *input, const struct sample *sample, const char *data_path,
                               const char *script)
{
    FILE *data = fopen(data_path, "w"), *in = fopen(script, "w");
    bool good = data && in;
    if (good) {
        peers_write_data(data, input->peer, sample);
        peers_write_script(in, input);
    }
    good = (!data || fclose(data) == 0) && good;
    good = (!in || fclose(in) == 0) && good;
    return good ? STATUS_OK : status_fail(STATUS_IO, "%s or %s cannot be written", data_path, script);
}

/* mpirun refuses root, and fewer cores than ranks, unless told that it is meant. */
enum { WORDS_MAX = 20 };

static void put_command(const struct peer_input *input, const char *script, char *ranks, size_t size, const char **argv)
{
    const char *const by_mpi[] = {
        "env", "OMPI_ALLOW_RUN_AS_ROOT=1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1", "mpirun", "-np", ranks};
    const char *const program[] = {PROGRAM[input->peer], "-in", script, "-log", "none", "-nocite", NULL};
    int n = 0;
    snprintf(ranks, size, "%d", input->processes);
    for (size_t k = 0; input->processes > 1 && k < sizeof by_mpi / sizeof *by_mpi; k++)
        argv[n++] = by_mpi[k];
    for (size_t k = 0; k < sizeof program / sizeof *program; k++)
        argv[n++] = program[k];
}

enum status peers_run(struct peer_input *input, const struct sample *sample, const char *folder, const char *name)
{
    char data[1024], script[1024], log[1024], ranks[16];
    snprintf(data, sizeof data, "%s/%s.data", folder, name);
    snprintf(script, sizeof script, "%s/%s.in", folder, name);
    snprintf(log, sizeof log, "%s/%s.log", folder, name);
    input->data = strrchr(data, '/') + 1;
    enum status status = write_files(input, sample, data, script);
    if (status == STATUS_OK) {
        const char *argv[WORDS_MAX];
        put_command(input, strrchr(script, '/') + 1, ranks, sizeof ranks, argv);
        struct child child = {.argv = argv, .log = log, .folder = folder, .variable = "OMP_NUM_THREADS", .value = "1"};
        status = child_run(&child);
    }
    input->data = NULL;
    return status;
}
