/* Numbers in a text in libconfig's syntax, looked at before libconfig reads it: libconfig 1.5 wraps integers that do
 * not fit 32 bits without a word, takes 1e999 as infinity and a lone point as zero. */
#ifndef SHAKEDOWN_COMMON_CONFIG_LITERALS_H
#define SHAKEDOWN_COMMON_CONFIG_LITERALS_H

#include "common/status.h"

/* `*checked`: the text, to be freed, with each number written so that libconfig holds it exactly (integers) or as the
 * nearest double: integers beyond 32 bits get their suffix, and numbers in arrays [ ] a point, so that whole numbers
 * and others may stand in one array. Lines stay where they are.
 * STATUS_CONFIG, as `name:line: ...`, without a name as "--set: ...", for an integer beyond 64 bits, a number that no
 * double can hold (1e999, 1e-400), a lone point, and @include: a scene is one text, recorded as a whole.
 * STATUS_NO_MEMORY. */
enum status config_literals(const char *text, const char *name, char **checked) MUST_USE;

#endif
