/* Damage to a valid HDF5 file that HDF5 itself takes as valid: other values, extents, types, texts, links. So fuzzing
 * reaches those who read the file instead of ending in HDF5. */
#ifndef SHAKEDOWN_TESTS_FUZZ_HDF5_MUTATION_H
#define SHAKEDOWN_TESTS_FUZZ_HDF5_MUTATION_H

#include <hdf5.h>
#include <stddef.h>
#include <stdint.h>

/* Applies the changes that `data` [size] spells, MUTATION_BYTES each, to the open file; what HDF5 refuses is left out.
 */
enum { MUTATION_BYTES = 6, MUTATIONS_MAX = 16 };
void hdf5_mutate(hid_t file, const uint8_t *data, size_t size);

#endif
