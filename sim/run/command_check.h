/* What a controller answers, wallctl or anyone's: checked before a wall is moved by it. */
#ifndef SHAKEDOWN_SIM_RUN_COMMAND_CHECK_H
#define SHAKEDOWN_SIM_RUN_COMMAND_CHECK_H

#include "common/coupling.h"
#include "common/scene.h"
#include "common/status.h"

/* `command` as the answer to `state`. STATUS_FORMAT, with step, field, value and what is allowed, for values that are
 * not finite, a wall that would jump (more than 1e-6 of the box from where it is), an unknown drive, a stage that is
 * none or lies behind, and more steps than the stage has left. */
enum status command_check(const struct scene *scene, const struct wall_state *state,
                          const struct wall_command *command) MUST_USE;

#endif
