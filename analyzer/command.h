/* The command line of the analyzer. */
#ifndef SHAKEDOWN_ANALYZER_COMMAND_H
#define SHAKEDOWN_ANALYZER_COMMAND_H

#include <stdbool.h>

#include "common/status.h"

enum { COMMAND_SETTINGS_MAX = 32 };

struct command {
    const char *out;    /* NULL: no ensemble.json */
    const char *series; /* key of the scene; NULL: an ensemble */
    const char *stage;  /* name, or "all"; NULL: analysis.stage of the scene */
    bool plots, help;
    int n_settings;
    const char *setting[COMMAND_SETTINGS_MAX]; /* "analysis.KEY=VALUE" */
    int first;                                 /* argument that is the first directory */
};

extern const char command_usage[];

/* STATUS_USAGE with what is wrong. */
enum status command_read(struct command *command, int argc, char **argv) MUST_USE;

#endif
