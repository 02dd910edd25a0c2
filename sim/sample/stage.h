/* Commands of the controller, and the stages that they begin. */
#ifndef SHAKEDOWN_SIM_SAMPLE_STAGE_H
#define SHAKEDOWN_SIM_SAMPLE_STAGE_H

#include "sim/sample/sample.h"

/* Sets what follows from the stage and the scene: material and law. */
void sample_set_law(struct sample *sample);

/* Springs are kept half a step ahead; from here on they are those of now, as at the start of a stage: the next drift is
 * the first one after a pause. Errors: STATUS_NO_MEMORY. */
enum status stage_settle_springs(struct sample *sample) MUST_USE;

/* Takes a command: switches to its stage if that is new (the ledger starts anew, forces follow the new material) and
 * sets the walls on their path. STATUS_FORMAT if the command does not fit the current step. */
enum status sample_command(struct sample *sample, const struct wall_command *command) MUST_USE;

#endif
