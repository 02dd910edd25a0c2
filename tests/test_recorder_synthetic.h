/* A made-up run as encoded messages, with values that a reader can compute again. */
#ifndef SHAKEDOWN_TESTS_TEST_RECORDER_SYNTHETIC_H
#define SHAKEDOWN_TESTS_TEST_RECORDER_SYNTHETIC_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/message.h"

struct synthetic_options {
    int64_t run_id;
    int dimension;
    bool frictional;
    bool walls;     /* record.walls = "full" */
    bool event_log; /* record.event_log */
    int n_particles;
    int n_samples;
    int n_frames;
    int n_wall_states;     /* and as many commands; spread over the run */
    bool unreadable;       /* RUN_INFO carries a scene that says nothing of a sample */
    bool checkpoint_first; /* CHECKPOINT behind the notes, before frames and samples; else behind all of them */
};

struct synthetic_message {
    int kind;
    size_t size;
    unsigned char *data;
};

struct synthetic_run {
    struct synthetic_options options;
    struct synthetic_message *messages;
    size_t count, capacity;
    int64_t next_seq[MESSAGE_LOGGED_KINDS];
    int64_t hash[MESSAGE_LOGGED_KINDS];
};

enum { SYNTHETIC_CHUNK = 100 /* particles or contacts per chunk */ };

/* 2D, no friction, 250 particles, 20 samples, 3 frames. */
extern const struct synthetic_options synthetic_default;

/* Aborts when memory runs out. */
void synthetic_create(struct synthetic_run *run, const struct synthetic_options *options);
void synthetic_free(struct synthetic_run *run);

/* The values. */
double synthetic_position(int frame, int particle, int axis);
double synthetic_radius(int particle);
double synthetic_strain(int sample, int axis);
double synthetic_wall_force(int64_t state, int wall);
int synthetic_contacts(const struct synthetic_run *run, int frame); /* their number in a frame; none in frame 0 */
double synthetic_overlap(int frame, int contact);

/* Adds a message with the next seq of its kind (header and END's totals are filled in by it). */
void synthetic_add(struct synthetic_run *run, int kind, union message *message);

/* Random numbers of a fixed sequence (SplitMix64). */
uint64_t synthetic_random(uint64_t *state);

/* A new empty directory, to be removed by synthetic_directory_remove. */
void synthetic_directory(char path[64]);
void synthetic_directory_remove(const char *path);

#endif
