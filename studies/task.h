/* One run of a study in its folder, from whatever is there to its analysis.json. What counts is in the files, never an
 * exit code: a kill at any moment leaves something that goes on. */
#ifndef SHAKEDOWN_STUDIES_TASK_H
#define SHAKEDOWN_STUDIES_TASK_H

#include <stdbool.h>

#include "common/status.h"

#define TASK_PREPARED "prepared.h5" /* the checkpoint in the folder of a preparation */

struct task {
    char out[2048];       /* folder of the study */
    char folder[2304];    /* of the run */
    char hash[17];        /* of the settings that the folder is for; "": none yet */
    char preparation[17]; /* "": none */
};

/* Finds out what the folder OUT/runs/NAME is for. It need not be there. STATUS_IO, STATUS_FORMAT. */
enum status task_open(struct task *task, const char *out, const char *name) MUST_USE;

/* Makes the folder one for these settings: removes what other settings have left, then writes the scene, then the
 * settings. Waits while another process is at work in it. STATUS_IO. */
enum status task_set(struct task *task, const char *scene, const char *hash, const char *preparation) MUST_USE;

/* Whether the run is there: run.h5 complete, analysis.json of a complete run, both of these settings. */
bool task_is_done(const struct task *task);

/* Does what is missing, with the programs in the folder `bin`: the preparation, then the run (going on from its
 * checkpoint where it has one), its record, its analysis. Waits for a preparation that another process makes. What the
 * programs say goes to the folder's log. STATUS_OK: task_is_done; else the reason, with the end of the log. */
enum status task_run(const struct task *task, const char *bin) MUST_USE;

/* Why the last task_run of the folder, by any process, failed; to be freed. */
enum status task_failure(const struct task *task, char **text) MUST_USE;

#endif
