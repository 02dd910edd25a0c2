/* bench_scene SCENE --sim PROGRAM --out FOLDER [--set key=value]... [--json FILE]: microseconds per step of a scene's
 * last stage and of each of its parts, for both precisions and every instruction set that the CPU can run, side by side
 * in one run. The stages before are run once by the program `sim`; the sample stays in the folder. `step` is a whole
 * step with an exchange of its own, rebuilds of lists and ledger, `run` one with the coupling that the scene asks for;
 * `advance` is kick and drift in one pass, as steps have it. A scene with friction is also run with resistance to
 * rolling, and to rolling and torsion, in turns with itself. */
#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "bench/prepared_sample.h"
#include "bench/timing.h"
#include "common/command_line.h"
#include "common/floating_point.h"
#include "common/scene_file.h"
#include "sim/measure/measure.h"
#include "sim/run/sample_source.h"
#include "sim/sample/energy.h"
#include "sim/sample/sample.h"
#include "sim/sample/stage.h"
#include "sim/sample/step_completion.h"
#include "sim/sample/time_step.h"
#include "sim/sample/wall_state.h"
#include "wallctl/control_law.h"

enum {
    BLOCKS = 100,
    BLOCKS_OF_REFERENCE = 2,
    STEPS_PER_BLOCK = 64,
    TURNS = 9,
    BLOCKS_OF_TURN = 8,
    BUILDS_PER_BLOCK = 4,
    ENERGY_STEPS = 500,
    WARM_STEPS = 5000
};

enum per { PER_PARTICLE, PER_CONTACT, PER_WALL_CONTACT, PER_COUNT };
static const char *const per_name[] = {"particle", "contact", "wall contact"};

struct bench {
    struct sample *sample;
    struct scene *scene;                /* of the sample */
    struct scene_coupling every, asked; /* an exchange at every step; as the scene has it */
    int left;                           /* steps until the next exchange */
    struct held_energy held;            /* for the controller's conditions */
    int64_t energy_step;
    int n[PER_COUNT];
    json_t *rows;
};

static enum status exchange(struct bench *bench)
{
    struct sample *sample = bench->sample;
    struct wall_state state;
    struct wall_command command;
    if (sample->stage >= 0 && sample->step - bench->energy_step >= ENERGY_STEPS) { /* no law before the first stage */
        bench->held = energy_held(sample_complete(sample));
        bench->energy_step = sample->step;
    }
    sample_wall_state(sample, &state);
    state.kinetic_energy_j = bench->held.kinetic_j;
    state.elastic_energy_j = bench->held.elastic_j;
    state.energy_step = bench->energy_step;
    TRY(wallctl_law(sample->scene, &state, &command));
    if (command.finished)
        return status_fail(STATUS_LIMIT, "the last stage is shorter than what is measured");
    bench->left = command.n_steps;
    return sample_command(sample, &command);
}

/* One step, as those of `sim --in-process`: an exchange with the law when one is due. */
static enum status next_step(struct bench *bench, const struct scene_coupling *coupling)
{
    bench->scene->coupling = *coupling;
    if (bench->left == 0)
        TRY(exchange(bench));
    bench->left--;
    return sample_step_open(bench->sample);
}

static enum status one_step(void *user)
{
    struct bench *bench = user;
    return next_step(bench, &bench->every);
}

static enum status one_step_of_run(void *user)
{
    struct bench *bench = user;
    return next_step(bench, &bench->asked);
}

/* The parts, each as often as wanted at one state: no time passes (dt = 0), so nothing changes. */
static struct sample *at_rest(void *user)
{
    return ((struct bench *)user)->sample;
}

static enum status one_pair(void *user)
{
    struct sample *sample = at_rest(user);
    struct contact_losses losses = {0};
    sample->kernels.pair(&sample->particles, &sample->pairs, 0, sample->pairs.slots.n_spans, &sample->law, 0,
                         sample->particles.force, &losses);
    return STATUS_OK;
}

static enum status one_walls(void *user)
{
    struct sample *sample = at_rest(user);
    struct contact_losses losses = {0};
    for (int w = 0; w < sample->n_walls; w++)
        sample->kernels.wall(&sample->particles, &sample->walls[w], &sample->law, 0, &losses);
    return STATUS_OK;
}

static enum status one_advance(void *user)
{
    struct sample *sample = at_rest(user);
    const struct kick_constants constants = {0};
    double power_w;
    (void)sample->kernels.advance(&sample->particles, &constants, 0, INFINITY, &power_w);
    return STATUS_OK;
}

static enum status one_drift(void *user)
{
    struct sample *sample = at_rest(user);
    (void)sample->kernels.drift(&sample->particles, 0, 0, INFINITY);
    return STATUS_OK;
}

static enum status one_kick(void *user)
{
    struct sample *sample = at_rest(user);
    const struct kick_constants constants = {0};
    (void)sample->kernels.kick(&sample->particles, &constants);
    return STATUS_OK;
}

static enum status one_build(void *user)
{
    struct sample *sample = at_rest(user);
    return sample_build_lists(sample);
}

static const struct part {
    const char *name;
    timed_part *run;
    int repeats;
    enum per per;
} parts[] = {{"step", one_step, STEPS_PER_BLOCK, PER_PARTICLE}, {"run", one_step_of_run, STEPS_PER_BLOCK, PER_PARTICLE},
             {"pair", one_pair, STEPS_PER_BLOCK, PER_CONTACT},  {"walls", one_walls, STEPS_PER_BLOCK, PER_WALL_CONTACT},
             {"advance", one_advance, STEPS_PER_BLOCK, 0},      {"drift", one_drift, STEPS_PER_BLOCK, PER_PARTICLE},
             {"kick", one_kick, STEPS_PER_BLOCK, PER_PARTICLE}, {"build", one_build, BUILDS_PER_BLOCK, PER_PARTICLE}};

static void report(struct bench *bench, const struct part *part, const struct timing *t, double step_us)
{
    const struct sample *sample = bench->sample;
    const char *precision = sample->pairs.model.mixed ? "mixed" : "double", *isa = instruction_set_name(sample->isa);
    double n = bench->n[part->per] ? bench->n[part->per] : 1, ns = 1e3 * t->least_us / n;
    printf("%-6s %-9s %-7s %9.2f %9.2f %5.0f %% %9.2f ns per %-12s", precision, isa, part->name, t->least_us,
           t->median_us, 100 * t->least_us / step_us, ns, per_name[part->per]);
    if (t->instructions >= 0)
        printf(" %7.1f instructions", t->instructions / n);
    if (part->run == one_step || part->run == one_step_of_run)
        printf(" %.3g particle-steps/s", 1e9 / ns);
    printf("\n");
    json_array_append_new(bench->rows,
                          json_pack("{s:s, s:s, s:s, s:f, s:f, s:f, s:s, s:f, s:f}", "precision", precision, "isa", isa,
                                    "part", part->name, "least_us", t->least_us, "median_us", t->median_us,
                                    "share_of_step", t->least_us / step_us, "per", per_name[part->per], "ns_each", ns,
                                    "instructions_each", t->instructions < 0 ? -1 : t->instructions / n));
}

static enum status measure_isa(struct bench *bench, enum instruction_set isa)
{
    struct sample *sample = bench->sample;
    const int blocks = isa == ISA_reference ? BLOCKS_OF_REFERENCE : BLOCKS;
    double step_us = 0;
    sample->isa = isa;
    sample->kernels = kernels_select(isa, &sample->pairs.model);
    for (size_t k = 0; k < sizeof parts / sizeof *parts; k++) {
        struct timing timing;
        if (k == 0)
            TRY(one_step(bench)); /* steps complete the one before, but this one has none */
        TRY(timing_take(parts[k].run, bench, blocks, parts[k].repeats, &timing));
        step_us = k == 0 ? timing.least_us : step_us;
        report(bench, &parts[k], &timing, step_us);
        if (parts[k].run == one_step_of_run)
            (void)sample_complete(sample);
    }
    return STATUS_OK;
}

static void count(struct bench *bench)
{
    struct sample *sample = bench->sample;
    bench->n[PER_PARTICLE] = sample->particles.count;
    bench->n[PER_WALL_CONTACT] = 0;
    for (int w = 0; w < sample->n_walls; w++)
        bench->n[PER_WALL_CONTACT] += sample->walls[w].contacts.count;
    bench->n[PER_CONTACT] = sample->pairs.count; /* candidates */
    printf("%s: %d particles, %d contacts with walls, %d candidates between particles in %d slots, %d at walls\n",
           sample->scene->name, sample->particles.count, measure_contacts(sample_complete(sample), NULL),
           sample->pairs.count, sample->pairs.n_sets * SET_WIDTH, bench->n[PER_WALL_CONTACT]);
}

/* Steps of the run first, until the skin of the lists suits them. */
static enum status warm_up(struct bench *bench)
{
    for (int k = 0; k < WARM_STEPS || bench->left > 0; k++)
        TRY(one_step_of_run(bench));
    return STATUS_OK;
}

/* The sample in this precision, warmed up. */
static enum status start(struct bench *bench, int precision)
{
    bench->scene->precision = precision;
    bench->left = 0;
    bench->energy_step = 0;
    TRY(sample_from_scene(&bench->sample, bench->scene));
    return warm_up(bench);
}

/* Blocks of either side in turns: what the machine does meanwhile is the same for both. part: what `with` has more. */
static enum status measure_beside(struct bench *without, struct bench *with, enum instruction_set isa, const char *part)
{
    struct bench *side[2] = {without, with};
    double us[2][TURNS], least[2] = {INFINITY, INFINITY}, ratio[TURNS];
    for (int k = 0; k < 2; k++) {
        side[k]->sample->isa = isa;
        side[k]->sample->kernels = kernels_select(isa, &side[k]->sample->pairs.model);
    }
    for (int turn = 0; turn < TURNS; turn++) {
        for (int k = 0; k < 2; k++) {
            struct timing timing;
            TRY(timing_take(one_step_of_run, side[(turn + k) % 2], BLOCKS_OF_TURN, STEPS_PER_BLOCK, &timing));
            us[(turn + k) % 2][turn] = timing.median_us;
            least[(turn + k) % 2] = fmin(least[(turn + k) % 2], timing.least_us);
        }
        ratio[turn] = us[1][turn] / us[0][turn];
    }
    for (int k = 0; k < 2; k++)
        (void)sample_complete(side[k]->sample);
    const double middle = timing_rank(ratio, TURNS, 0.5), low = timing_rank(ratio, TURNS, 0.25),
                 high = timing_rank(ratio, TURNS, 0.75);
    const char *precision = with->sample->pairs.model.mixed ? "mixed" : "double", *name = instruction_set_name(isa);
    printf("%-6s %-9s %-7s %9.2f us least, without %.2f: x %.3f; median of turns x %.3f, half of them %.3f to %.3f\n",
           precision, name, part, least[1], least[0], least[1] / least[0], middle, low, high);
    json_array_append_new(without->rows, json_pack("{s:s, s:s, s:s, s:f, s:f, s:f, s:[f, f]}", "precision", precision,
                                                   "isa", name, "part", part, "least_us", least[1], "without_us",
                                                   least[0], "over_without", middle, "half_of_turns", low, high));
    return STATUS_OK;
}

/* The same scene with resistance to rolling, and to torsion, as stiff as friction, which half of mu limits. */
static enum status measure_rolling(struct bench *bench, bool torsion)
{
    struct bench with = *bench;
    if (!scene_is_frictional(bench->scene) || scene_resists_rolling(bench->scene) ||
        (torsion && bench->scene->dimension == 2))
        return STATUS_OK;
    with.scene = prepare_scene_copy(bench->scene);
    if (!with.scene)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    struct scene_material *m = &with.scene->stage[with.scene->n_stages - 1].material;
    m->mu_rolling = 0.5 * m->mu_s;
    m->mu_torsion = torsion ? m->mu_rolling : 0;
    m->kr_n_per_m = m->ko_n_per_m = m->kt_n_per_m;
    m->gamma_r_kg_per_s = m->gamma_o_kg_per_s = m->gamma_t_kg_per_s;
    with.sample = NULL;
    enum status status = start(&with, (int)bench->scene->precision);
    for (int isa = 0; status == STATUS_OK && isa < ISA_COUNT; isa++)
        if (isa != ISA_reference && instruction_set_supported(isa))
            status = measure_beside(bench, &with, isa, torsion ? "torsion" : "rolling");
    sample_free(with.sample);
    prepare_scene_free(with.scene);
    return status;
}

static enum status measure_precision(struct bench *bench, int precision)
{
    enum status status = start(bench, precision);
    if (status == STATUS_OK)
        count(bench);
    for (int isa = 0; status == STATUS_OK && isa < ISA_COUNT; isa++) {
        if (instruction_set_supported(isa))
            status = measure_isa(bench, isa);
        else
            printf("*** %s: THIS CPU CANNOT RUN IT, NOT MEASURED ***\n", instruction_set_name(isa));
    }
    for (int torsion = 0; status == STATUS_OK && torsion < 2; torsion++)
        status = measure_rolling(bench, torsion);
    sample_free(bench->sample);
    return status;
}

static enum status bench_scene(struct scene *scene, const char *json_path)
{
    struct bench bench = {.rows = json_array(), .scene = scene, .every = scene->coupling, .asked = scene->coupling};
    bench.every.scheme = SCHEME_HOLD;
    bench.every.interval_steps = 1;
    bool counts = timing_counts_instructions();
    const struct timing_core before = timing_core();
    printf("%-6s %-9s %-7s %9s %9s %7s\n", "", "kernels", "part", "least us", "median us", "of step");
    enum status status = measure_precision(&bench, PRECISION_DOUBLE);
    if (status == STATUS_OK)
        status = measure_precision(&bench, PRECISION_MIXED);
    const struct timing_core after = timing_core();
    timing_core_print(&before, &after);
    json_t *all = json_pack("{s:s, s:i, s:i, s:b, s:o, s:o}", "scene", scene->name, "particles", bench.n[PER_PARTICLE],
                            "candidates", bench.n[PER_CONTACT], "instructions_counted", counts, "core",
                            timing_core_json(&before, &after), "rows", bench.rows);
    if (status == STATUS_OK && json_path && json_dump_file(all, json_path, JSON_INDENT(1)) != 0)
        status = status_fail(STATUS_IO, "%s: cannot be written", json_path);
    json_decref(all);
    return status;
}

static enum status prepare_and_bench(const struct command_line *line, const char *sim, const char *folder,
                                     const char *json_path)
{
    char checkpoint[CONFIG_STRING_MAX];
    if (line->n_positional != 1 || !sim || !folder)
        return status_fail(STATUS_USAGE, "usage: bench_scene SCENE --sim PROGRAM --out FOLDER [--set key=value]... "
                                         "[--json FILE]");
    const char *path = line->positional[0];
    TRY(prepare_sample(sim, path, line->override, line->n_overrides, folder, checkpoint));
    struct scene *scene = calloc(1, sizeof *scene);
    if (!scene)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    enum status status = scene_load(scene, path, line->override, line->n_overrides);
    if (status == STATUS_OK) {
        prepare_stage(scene, (int)scene->n_stages - 1, checkpoint);
        status = bench_scene(scene, json_path);
    }
    scene_free(scene);
    free(scene);
    return status;
}

int main(int argc, char **argv)
{
    const char *sim = NULL, *folder = NULL, *json_path = NULL;
    const struct command_line_option own[] = {
        {"sim", &sim, NULL}, {"out", &folder, NULL}, {"json", &json_path, NULL}, {NULL, NULL, NULL}};
    struct command_line line;
    floating_point_flush_subnormals();
    enum status status = command_line_parse(&line, argc, argv, own);
    if (status == STATUS_OK)
        status = prepare_and_bench(&line, sim, folder, json_path);
    return status_report("bench_scene", status);
}
