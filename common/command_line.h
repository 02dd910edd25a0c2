/* The command line of every process: SCENE [--set path=value]... [--seed N] [--run-id N] [--lcm URL], and the options a
 * process adds. */
#ifndef SHAKEDOWN_COMMON_COMMAND_LINE_H
#define SHAKEDOWN_COMMON_COMMAND_LINE_H

#include <stdbool.h>
#include <stdint.h>

#include "common/status.h"

enum { COMMAND_LINE_OVERRIDES_MAX = 128, COMMAND_LINE_POSITIONAL_MAX = 16, COMMAND_LINE_OWN_MAX = 32 };

struct command_line {
    const char *positional[COMMAND_LINE_POSITIONAL_MAX];
    int n_positional;
    const char *override[COMMAND_LINE_OVERRIDES_MAX]; /* "path=value" for scene_load, --seed among them */
    int n_overrides;
    char seed_override[32]; /* what one of them points to */
    int64_t run_id;
    bool run_id_given;
    const char *lcm_url; /* NULL: not given */
    bool help, version;
};

/* An option of the process itself, without the leading dashes: with `value` it takes an argument, else it sets `flag`.
 * A list ends with name NULL. */
struct command_line_option {
    const char *name;
    const char **value;
    bool *flag;
};

/* Parses argv (reordering it); strings in `line` point into argv, so it must outlive `line`; `line` must not be moved.
 * `own` may be NULL. STATUS_USAGE with a message on anything unknown or malformed. */
enum status command_line_parse(struct command_line *line, int argc, char **argv,
                               const struct command_line_option *own) MUST_USE;

#endif
