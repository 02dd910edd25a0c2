/* `sim --explain`: what a scene models, with which kernel, and what it costs in memory. */
#ifndef SHAKEDOWN_SIM_MEASURE_EXPLAIN_H
#define SHAKEDOWN_SIM_MEASURE_EXPLAIN_H

#include <stdio.h>

#include "common/scene.h"

/* Prints the explanation. Errors: those of sample_create. */
enum status explain_scene(FILE *out, const struct scene *scene) MUST_USE;

/* What a scene says is right, and the particles that it places bear its time steps (measure/step_limit.h). Errors:
 * those of placing them; STATUS_CONFIG. */
enum status explain_check(const struct scene *scene) MUST_USE;

#endif
