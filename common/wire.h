/* Checks the bytes of an LCM message before they are decoded. The decoders that lcm-gen writes take array sizes and
 * string lengths as they come (8 * n is computed in an int, so n = 2^29 + 1 passes their check of the length), so bytes
 * from a bus or a damaged log must be looked at first. */
#ifndef SHAKEDOWN_RECORDER_WIRE_H
#define SHAKEDOWN_RECORDER_WIRE_H

#include <stdbool.h>
#include <stddef.h>

/* Whether `data` [size] is, after the 8 bytes of the type's hash, exactly one message of `layout`.
 * A layout has one code per field in the order of the .lcm file: b int8_t, i int32_t, q int64_t, d double, s string;
 * `*` code letter: an array of it, whose count is the letter-th (a = first) int32_t scalar of the message.
 * Counts must not be negative; a string must end where its length says, and not before. */
bool wire_check(const char *layout, const void *data, size_t size);

#endif
