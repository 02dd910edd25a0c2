/* The sample that a scene starts from: its initial packing, or the state in a checkpoint. */
#ifndef SHAKEDOWN_SIM_RUN_SAMPLE_SOURCE_H
#define SHAKEDOWN_SIM_RUN_SAMPLE_SOURCE_H

#include "sim/sample/sample.h"

/* Makes the sample of the scene at step 0. From a checkpoint, particles, contacts and walls are taken over: histories
 * and springs where both scenes model them; a history that the checkpoint lacks starts as the overlap, a spring as
 * zero; the walls start at rest. `scene` must outlive the sample. Errors: as of sample_create; STATUS_IO (no such
 * file), STATUS_FORMAT (no checkpoint, or damaged), STATUS_CONFIG (another number of particles or dimension). */
enum status sample_from_scene(struct sample **sample, const struct scene *scene) MUST_USE;

#endif
