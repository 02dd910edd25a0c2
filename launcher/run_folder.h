/* The folder of a run, which says all that its processes are told. */
#ifndef SHAKEDOWN_LAUNCHER_RUN_FOLDER_H
#define SHAKEDOWN_LAUNCHER_RUN_FOLDER_H

#include <stdbool.h>

#include "common/status.h"

struct run_folder {
    char *path;        /* absolute */
    char *scene;       /* PATH/scene.cfg */
    char **overrides;  /* words of the command line, NULL ended */
    char *run_id;      /* a number */
    char *url;         /* of the bus; NULL: a run in one process */
    char **controller; /* command in place of wallctl, NULL ended; NULL: wallctl */
};

/* Reads PATH/run-id, overrides, lcm-url and controller. `folder` is freed by run_folder_free also on failure. */
enum status run_folder_read(struct run_folder *folder, const char *path) MUST_USE;
void run_folder_free(struct run_folder *folder);

/* PATH/name, to be freed by g_free. */
char *run_folder_file(const struct run_folder *folder, const char *name);
bool run_folder_has(const struct run_folder *folder, const char *name);

#endif
