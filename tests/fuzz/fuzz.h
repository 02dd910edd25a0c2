/* A fuzz target: libFuzzer's entry, which the runner of the corpora calls too. Each file here that begins with target_
 * is one. */
#ifndef SHAKEDOWN_TESTS_FUZZ_FUZZ_H
#define SHAKEDOWN_TESTS_FUZZ_FUZZ_H

#include <stddef.h>
#include <stdint.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#endif
