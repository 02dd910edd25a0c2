/* Reading a libconfig file through tables of keys: each key has a type, unit, range, default and a sentence of
 * documentation. Unknown keys, wrong types and values out of range are errors that name file, line, key and what is
 * allowed. The same tables print the scene reference and the effective configuration. */
#ifndef SHAKEDOWN_COMMON_CONFIG_TABLE_H
#define SHAKEDOWN_COMMON_CONFIG_TABLE_H

#include <libconfig.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "common/status.h"

enum key_type {
    KEY_BOOL,   /* bool */
    KEY_INT,    /* int64_t */
    KEY_FLOAT,  /* double; integers are taken too */
    KEY_STRING, /* char[CONFIG_STRING_MAX] */
    KEY_CHOICE, /* int, index in `choices` */
    KEY_FLOATS, /* struct config_floats; a number is a list of one */
    KEY_BAND,   /* struct config_band */
    KEY_GROUP,  /* a nested struct with a table of its own */
};

enum { CONFIG_STRING_MAX = 256, CONFIG_FLOATS_MAX = 64 };

struct config_floats {
    int64_t count;
    double value[CONFIG_FLOATS_MAX];
};

/* Where a quantity ends something. Members: 0: nowhere; 1: at a bound, reached from below if it is positive, from above
 * if it is negative; 2: where it leaves the band between them. */
struct config_band {
    int64_t count;
    double value[2];
};

struct key {
    const char *name; /* NULL ends a table */
    enum key_type type;
    size_t offset; /* of the value in the struct the table describes */
    const char *unit;
    double min, max;            /* of numbers; for lists, of each element */
    const char *preset;         /* the default as the scene file would say it; NULL: must be given */
    const char *const *choices; /* KEY_CHOICE: NULL-ended; KEY_FLOAT: the first may stand for a number, read as NAN */
    const struct key *group;    /* KEY_GROUP: its table */
    const char *doc;
};

/* Sets every value of `target` that has a default (groups too). */
void config_defaults(const struct key *table, void *target);

/* Reads the keys present in `setting` (a group) into `target` and leaves the others as they are; `where` is the path
 * printed in errors ("" at the top), `skip` lists top-level names that the caller reads itself (NULL-ended, or NULL).
 * STATUS_CONFIG with "file:line: key: ..." on an unknown key, a wrong type or a value out of range. */
enum status config_group_read(const config_setting_t *setting, const struct key *table, const char *where,
                              const char *const *skip, void *target) MUST_USE;

/* Takes the numbers of a table of KEY_FLOAT over, but for those for which a word stands; returns how many. */
int config_overlay(const struct key *table, const void *from, void *to);

/* STATUS_CONFIG if a key without default is missing in `setting`. */
enum status config_require(const config_setting_t *setting, const struct key *table, const char *where) MUST_USE;

/* The file name that errors of this thread print. */
void config_source_name(const char *name);

/* "file:line: where.key: message" as STATUS_CONFIG, for checks between keys. */
enum status config_fail(const config_setting_t *setting, const char *where, const char *format, ...)
    PRINTF_LIKE(3, 4) MUST_USE;

/* Applies one "path=value" of the command line to a parsed file, value in libconfig syntax; a bare word that is not
 * true or false is taken as a string. Missing groups on the path are made; list members are path parts
 * ("stages.1.dt_s=1e-6"). */
enum status config_override(config_t *config, const char *assignment) MUST_USE;

/* Whether a key has a meaning beside the others of its group. */
typedef bool config_applies(const struct key *table, const struct key *key, const void *group);

/* What is printed of a struct: the keys whose values are not those of `base`, a struct of the same table, and those
 * that `applies` says; `base` NULL: all; `applies` NULL: no more. Groups of which nothing is printed are left out. */
struct config_print {
    const void *base;
    config_applies *applies;
};

/* Prints `target` in libconfig syntax, numbers with 17 digits. */
void config_print(FILE *out, const struct key *table, const void *target, struct config_print what, int indent);

/* Prints a Markdown table of the keys; groups recurse with `path` as prefix. */
void config_print_reference(FILE *out, const struct key *table, const char *path);

#endif
