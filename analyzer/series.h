/* A series: runs that differ in one key of the scene, e.g. friction against mu. */
#ifndef SHAKEDOWN_ANALYZER_SERIES_H
#define SHAKEDOWN_ANALYZER_SERIES_H

#include <stdbool.h>
#include <stdio.h>

#include "analyzer/ensemble.h"
#include "common/scene.h"
#include "common/status.h"

/* The number that the scene in force has under `key`, as after --set: "material.mu_s", "stages.2.duration_s",
 * "stages.2.walls.z.until_stress_pa" (one bound). STATUS_USAGE if there is no such number, STATUS_NO_MEMORY. */
enum status series_key_value(const struct scene *scene, const char *key, double *value) MUST_USE;

/* Refuses runs that do not differ in `key`, as a key that their stage does not use (ensemble_member.key_value filled by
 * the caller): STATUS_USAGE. */
enum status series_check(const struct ensemble *ensemble, const char *key) MUST_USE;

/* Sorts the ensemble by the names of the runs, then by the key's value (ensemble_member.key_value, filled by the
 * caller). Runs of one name are one curve. */
void series_sort(struct ensemble *ensemble);

/* Prints one row per run: cyclic tests if any run is one, else peak and critical state. */
void series_print(FILE *out, const struct ensemble *ensemble, const char *key);

/* Writes `directory`/series.csv: name, key, classification and every quantity with its uncertainty, one line per run,
 * names separated by two empty lines; and series.gp, which plots `*curves` curves of them (0: there is nothing to
 * plot). STATUS_IO. */
enum status series_write(const struct ensemble *ensemble, const char *key, const char *directory, int *curves) MUST_USE;

/* Where some run liquefied: writes `directory`/liquefaction.gp, which plots the cyclic stress ratio of series.csv
 * against the number of cycles. STATUS_IO. */
enum status series_liquefaction_write(const struct ensemble *ensemble, const char *directory, bool *liquefied) MUST_USE;

#endif
