/* Compares two effective configurations, as scene_print_every_key writes them: one key per line. */
#ifndef SHAKEDOWN_SIM_RUN_CONFIG_DIFFERENCE_H
#define SHAKEDOWN_SIM_RUN_CONFIG_DIFFERENCE_H

#include <stdbool.h>
#include <stddef.h>

/* Whether they say the same, apart from what changes no bits (how often checkpoints are written, how long answers are
 * waited for, and where the starting state came from). Else `difference` [size] becomes "KEY was OLD, is now NEW" for
 * the first key that differs. */
bool config_is_same(const char *before, const char *now, char *difference, size_t size);

#endif
