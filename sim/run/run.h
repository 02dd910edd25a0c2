/* A whole run: exchange, steps, records, status, until the protocol is done. */
#ifndef SHAKEDOWN_SIM_RUN_RUN_H
#define SHAKEDOWN_SIM_RUN_RUN_H

#include "sim/run/run_options.h"

/* Runs the scene. On an error, or when a stop is requested, END says so and the records so far stay valid. The status
 * of the run is returned. */
enum status run_scene(const struct scene *scene, const struct run_options *options) MUST_USE;

/* Whether the scene could go on from the checkpoint at `path`; errors are those of checkpoint_resume. */
enum status run_check_resume(const struct scene *scene, const char *path) MUST_USE;

#endif
