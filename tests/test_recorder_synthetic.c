#include "test_recorder_synthetic.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/history_kind.h"
#include "common/record_hash.h"

const struct synthetic_options synthetic_default = {
    .run_id = 42, .dimension = 2, .n_particles = 250, .n_samples = 20, .n_frames = 3};

static void *must(void *memory)
{
    if (!memory)
        abort();
    return memory;
}

uint64_t synthetic_random(uint64_t *state)
{
    uint64_t z = *state += 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}

double synthetic_position(int frame, int particle, int axis)
{
    return frame + 1e-3 * particle + 0.25 * axis;
}

double synthetic_radius(int particle)
{
    return 1e-3 + 1e-6 * (particle % 97);
}

double synthetic_strain(int sample, int axis)
{
    return 1e-3 * sample - 0.5 * axis;
}

double synthetic_wall_force(int64_t state, int wall)
{
    return 0.1 * (double)state + wall;
}

int synthetic_contacts(const struct synthetic_run *run, int frame)
{
    return frame * (run->options.n_particles - 1);
}

double synthetic_overlap(int frame, int contact)
{
    return 1e-6 * frame + 1e-9 * contact;
}

typedef int (*encode_function)(void *, int, int, const void *);

/* Encodes through the generated functions of one type. */
#define ENCODE(stem)                                                                                                   \
    {                                                                                                                  \
        size = (size_t)shakedown_##stem##_t_encoded_size(&message->stem);                                              \
        data = must(malloc(size));                                                                                     \
        if (shakedown_##stem##_t_encode(data, 0, (int)size, &message->stem) != (int)size)                              \
            abort();                                                                                                   \
    }                                                                                                                  \
    break

static struct synthetic_message encode(int kind, const union message *message)
{
    size_t size = 0;
    unsigned char *data = NULL;
    switch (kind) {
    case RECORD_RUN_INFO:
        ENCODE(run_info);
    case RECORD_PARTICLES:
        ENCODE(particles);
    case RECORD_SAMPLE:
        ENCODE(sample);
    case RECORD_FRAME_PARTICLES:
        ENCODE(frame_particles);
    case RECORD_FRAME_CONTACTS:
        ENCODE(frame_contacts);
    case RECORD_NOTE:
        ENCODE(note);
    case RECORD_CHECKPOINT:
        ENCODE(checkpoint);
    case RECORD_END:
        ENCODE(end);
    case MESSAGE_WALL_STATE:
        ENCODE(wall_state);
    default:
        ENCODE(wall_command);
    }
    return (struct synthetic_message){kind, size, data};
}

void synthetic_add(struct synthetic_run *run, int kind, union message *message)
{
    message->header.run_id = run->options.run_id;
    message->header.seq = run->next_seq[kind]++;
    if (kind == RECORD_END)
        message->end.total[RECORD_END] = run->next_seq[RECORD_END];
    if (run->count == run->capacity) {
        run->capacity = run->capacity ? 2 * run->capacity : 64;
        run->messages = must(realloc(run->messages, run->capacity * sizeof *run->messages));
    }
    const struct synthetic_message encoded = encode(kind, message);
    run->hash[kind] = record_hash_add(run->hash[kind], encoded.data, encoded.size);
    run->messages[run->count++] = encoded;
}

static void add_run_info(struct synthetic_run *run)
{
    char config[2048];
    const struct synthetic_options *options = &run->options;
    snprintf(config, sizeof config,
             "name = \"synthetic\"; dimension = %d;\n"
             "sample = { count = %d; radius_min_m = 1e-3; radius_max_m = 2e-3; density_kg_per_m3 = 2000.0; };\n"
             "material = { law = \"linear\"; kn_n_per_m = 1e5; };\n"
             "record = { walls = \"%s\"; event_log = %s; };\n"
             "stages = ( { name = \"only\"; dt_s = 1e-6; duration_s = 1.0; } );\n",
             options->dimension, options->n_particles, options->walls ? "full" : "sampled",
             options->event_log ? "true" : "false");
    if (options->unreadable)
        snprintf(config, sizeof config, "name = \"synthetic\"; dimension = %d;\n", options->dimension);
    /* one of each kind, with friction: as the overlap, as the normal, and as its reverse */
    static const char *const name[] = {"depth", "way", "roll"}, *const unit[] = {"m", "N", "1"};
    static const int8_t kind[] = {HISTORY_NUMBER, HISTORY_TANGENT, HISTORY_ROTATION};
    union message message = {.run_info = {.name = "synthetic",
                                          .version = "0.1.0",
                                          .kernel_set = "none",
                                          .controller = "",
                                          .scene_text = "# \xc3\xbc",
                                          .effective_config = config,
                                          .seed = 7,
                                          .dimension = options->dimension,
                                          .n_particles = options->n_particles,
                                          .n_stages = 1,
                                          .frictional = options->frictional,
                                          .n_history = options->frictional ? 3 : 0,
                                          .history_name = (char **)(uintptr_t)name,
                                          .history_unit = (char **)(uintptr_t)unit,
                                          .history_kind = (int8_t *)(uintptr_t)kind}};
    synthetic_add(run, RECORD_RUN_INFO, &message);
}

static int chunk_count(int n)
{
    return n == 0 ? 1 : (n + SYNTHETIC_CHUNK - 1) / SYNTHETIC_CHUNK;
}

static int chunk_size(int n, int chunk)
{
    int left = n - chunk * SYNTHETIC_CHUNK;
    return left < SYNTHETIC_CHUNK ? left : SYNTHETIC_CHUNK;
}

static void add_particles(struct synthetic_run *run)
{
    int n = run->options.n_particles;
    for (int chunk = 0; chunk < chunk_count(n); chunk++) {
        double radius_m[SYNTHETIC_CHUNK], mass_kg[SYNTHETIC_CHUNK];
        int first = chunk * SYNTHETIC_CHUNK, count = chunk_size(n, chunk);
        for (int k = 0; k < count; k++) {
            radius_m[k] = synthetic_radius(first + k);
            mass_kg[k] = 2.0 * radius_m[k];
        }
        union message message = {.particles = {.chunk = chunk,
                                               .n_chunks = chunk_count(n),
                                               .first = first,
                                               .count = count,
                                               .radius_m = radius_m,
                                               .mass_kg = mass_kg}};
        synthetic_add(run, RECORD_PARTICLES, &message);
    }
}

static void add_sample(struct synthetic_run *run, int sample)
{
    int d = run->options.dimension;
    double strain[3], values[9] = {0};
    for (int axis = 0; axis < d; axis++)
        strain[axis] = synthetic_strain(sample, axis);
    union message message = {.sample = {.step = 10 * sample,
                                        .time_s = 1e-3 * sample,
                                        .dimension = d,
                                        .box_length_m = values,
                                        .strain = strain,
                                        .stress_wall_pa = values,
                                        .n_stress = d * d,
                                        .stress_contact_pa = values,
                                        .fabric = values,
                                        .n_walls = 2 * d,
                                        .wall_position_m = values,
                                        .wall_velocity_m_per_s = values,
                                        .wall_force_n = values,
                                        .coordination = 4.0 + sample,
                                        .n_contacts = 100 + sample,
                                        .interface_residual_j = -1.0 - sample}};
    synthetic_add(run, RECORD_SAMPLE, &message);
}

static void add_frame_particles(struct synthetic_run *run, int frame)
{
    int n = run->options.n_particles, d = run->options.dimension;
    double lo_m[3] = {-1.0, -2.0, -3.0}, hi_m[3] = {1.0, 1.0, 1.0};
    if (d == 2)
        lo_m[1] = -3.0;
    for (int chunk = 0; chunk < chunk_count(n); chunk++) {
        double position_m[3 * SYNTHETIC_CHUNK], spin[3 * SYNTHETIC_CHUNK];
        int first = chunk * SYNTHETIC_CHUNK, count = chunk_size(n, chunk);
        for (int k = 0; k < count * d; k++) {
            position_m[k] = synthetic_position(frame, first + k / d, k % d);
            spin[k] = -position_m[k];
        }
        union message message = {.frame_particles = {.step = 100 * frame,
                                                     .time_s = 1e-2 * frame,
                                                     .frame = frame,
                                                     .chunk = chunk,
                                                     .n_chunks = chunk_count(n),
                                                     .stage = frame / 2,
                                                     .dimension = d,
                                                     .box_lo_m = lo_m,
                                                     .box_hi_m = hi_m,
                                                     .first = first,
                                                     .count = count,
                                                     .n_values = count * d,
                                                     .position_m = position_m,
                                                     .velocity_m_per_s = spin,
                                                     .n_angular = run->options.frictional ? count * (2 * d - 3) : 0,
                                                     .angular_velocity_rad_per_s = spin}};
        synthetic_add(run, RECORD_FRAME_PARTICLES, &message);
    }
}

static void add_frame_contacts(struct synthetic_run *run, int frame)
{
    int n = synthetic_contacts(run, frame), d = run->options.dimension;
    for (int chunk = 0; chunk < chunk_count(n); chunk++) {
        int32_t i[SYNTHETIC_CHUNK], j[SYNTHETIC_CHUNK];
        double overlap_m[SYNTHETIC_CHUNK], normal[3 * SYNTHETIC_CHUNK];
        double history[7 * SYNTHETIC_CHUNK];
        int8_t sliding[SYNTHETIC_CHUNK];
        int first = chunk * SYNTHETIC_CHUNK, count = chunk_size(n, chunk);
        for (int k = 0; k < count; k++) {
            i[k] = (first + k) % (run->options.n_particles - 1);
            j[k] = k == 0 ? -1 : i[k] + 1;
            overlap_m[k] = synthetic_overlap(frame, first + k);
            sliding[k] = (first + k) % 2;
        }
        for (int k = 0; k < count * d; k++)
            normal[k] = k % d + 0.5;
        const int spins = 2 * d - 3;
        memcpy(history, overlap_m, (size_t)count * sizeof *history);
        memcpy(history + count, normal, (size_t)(count * d) * sizeof *history);
        for (int k = 0; k < count * spins; k++)
            history[count * (1 + d) + k] = -(k % spins + 0.5);
        bool frictional = run->options.frictional;
        union message message = {.frame_contacts = {.step = 100 * frame,
                                                    .time_s = 1e-2 * frame,
                                                    .frame = frame,
                                                    .chunk = chunk,
                                                    .n_chunks = chunk_count(n),
                                                    .dimension = d,
                                                    .count = count,
                                                    .i = i,
                                                    .j = j,
                                                    .overlap_m = overlap_m,
                                                    .normal_force_n = overlap_m,
                                                    .n_values = count * d,
                                                    .normal = normal,
                                                    .n_tangential = frictional ? count * d : 0,
                                                    .tangential_force_n = normal,
                                                    .n_sliding = frictional ? count : 0,
                                                    .sliding = sliding,
                                                    .n_history = frictional ? count * (1 + d + spins) : 0,
                                                    .history = history}};
        synthetic_add(run, RECORD_FRAME_CONTACTS, &message);
    }
}

static void add_wall_exchange(struct synthetic_run *run, int64_t state)
{
    int n_walls = 2 * run->options.dimension;
    double force_n[6], zeros[6] = {0};
    int32_t drive[6] = {0};
    for (int w = 0; w < n_walls; w++)
        force_n[w] = synthetic_wall_force(state, w);
    union message message = {.wall_state = {.step = 5 * state,
                                            .time_s = 1e-6 * (double)state,
                                            .stage_step = state,
                                            .n_walls = n_walls,
                                            .position_m = force_n,
                                            .velocity_m_per_s = force_n,
                                            .force_n = force_n,
                                            .stiffness_n_per_m = force_n,
                                            .damping_kg_per_s = zeros,
                                            .stage_position_m = zeros,
                                            .acceleration_m_per_s2 = zeros,
                                            .force_before_n = zeros,
                                            .ahead_position_m = force_n,
                                            .ahead_velocity_m_per_s = force_n}};
    synthetic_add(run, MESSAGE_WALL_STATE, &message);
    message = (union message){.wall_command = {.step = 5 * state,
                                               .time_s = 1e-6 * (double)state,
                                               .n_steps = 5,
                                               .n_walls = n_walls,
                                               .drive = drive,
                                               .position_m = force_n,
                                               .velocity_m_per_s = force_n,
                                               .acceleration_m_per_s2 = zeros,
                                               .force_n = force_n,
                                               .force_rate_n_per_s = zeros,
                                               .force_rate2_n_per_s2 = zeros,
                                               .mass_kg = zeros,
                                               .damping_kg_per_s = zeros}};
    synthetic_add(run, MESSAGE_WALL_COMMAND, &message);
}

static void add_notes(struct synthetic_run *run)
{
    union message message = {.note = {.step = 10, .stage = 0, .stage_name = "only", .text = "at rest"}};
    synthetic_add(run, RECORD_NOTE, &message);
    message = (union message){
        .note = {.step = 900, .stage = 0, .stage_name = "on;ly", .severity = NOTE_DOUBTFUL, .text = "residual 2 %"}};
    synthetic_add(run, RECORD_NOTE, &message);
}

static void add_checkpoint(struct synthetic_run *run)
{
    int64_t total[RECORD_CHANNELS];
    memcpy(total, run->next_seq, sizeof total);
    union message message = {.checkpoint = {.step = 900,
                                            .time_s = 0.9,
                                            .n_channels = RECORD_CHANNELS,
                                            .total = total,
                                            .hash = run->hash,
                                            .n_frames = run->options.checkpoint_first ? 0 : run->options.n_frames,
                                            .wall_states = run->next_seq[MESSAGE_WALL_STATE]}};
    synthetic_add(run, RECORD_CHECKPOINT, &message);
}

static void add_end(struct synthetic_run *run)
{
    int64_t total[RECORD_CHANNELS];
    memcpy(total, run->next_seq, sizeof total);
    union message message = {.end = {.step = 1000,
                                     .time_s = 1.0,
                                     .reason = "",
                                     .state_hash = 0x1234,
                                     .elapsed_s = 2.5,
                                     .n_channels = RECORD_CHANNELS,
                                     .channel = (char **)(uintptr_t)record_channel_name,
                                     .total = total,
                                     .hash = run->hash,
                                     .wall_states = run->next_seq[MESSAGE_WALL_STATE],
                                     .wall_commands = run->next_seq[MESSAGE_WALL_COMMAND]}};
    synthetic_add(run, RECORD_END, &message);
}

void synthetic_create(struct synthetic_run *run, const struct synthetic_options *options)
{
    *run = (struct synthetic_run){.options = *options};
    for (int kind = 0; kind < MESSAGE_LOGGED_KINDS; kind++)
        run->hash[kind] = RECORD_HASH_OF_NONE;
    int walls_per_sample = options->n_samples > 0 ? options->n_wall_states / options->n_samples : 0;
    int64_t state = 0;
    add_run_info(run);
    add_particles(run);
    add_notes(run);
    if (options->checkpoint_first)
        add_checkpoint(run);
    for (int frame = 0; frame < options->n_frames; frame++) {
        add_frame_particles(run, frame);
        add_frame_contacts(run, frame);
    }
    for (int sample = 0; sample < options->n_samples; sample++) {
        add_sample(run, sample);
        for (int k = 0; k < walls_per_sample; k++)
            add_wall_exchange(run, state++);
    }
    while (state < options->n_wall_states)
        add_wall_exchange(run, state++);
    if (!options->checkpoint_first)
        add_checkpoint(run);
    add_end(run);
}

void synthetic_free(struct synthetic_run *run)
{
    for (size_t k = 0; k < run->count; k++)
        free(run->messages[k].data);
    free(run->messages);
    *run = (struct synthetic_run){0};
}

void synthetic_directory(char path[64])
{
    snprintf(path, 64, "test_recorder_XXXXXX");
    if (!mkdtemp(path))
        abort();
}

void synthetic_directory_remove(const char *path)
{
    static const char *const names[] = {"run.h5", "run.lcm", "run.xdmf", "in.lcm", "h5dump.txt", ""};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        char file[128];
        snprintf(file, sizeof file, "%s/%s", path, names[k]);
        (void)remove(file); /* most are not there */
    }
}
