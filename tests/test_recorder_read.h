/* Reads run.h5 back with plain HDF5 calls. */
#ifndef SHAKEDOWN_TESTS_TEST_RECORDER_READ_H
#define SHAKEDOWN_TESTS_TEST_RECORDER_READ_H

#include <hdf5.h>
#include <stdbool.h>

/* Opens DIR/run.h5; fails the test if it does not open. */
hid_t read_open(const char *directory);

/* The number of rows of a dataset (-1: there is none), and all its values as double, to be freed. */
long read_rows(hid_t file, const char *path);
double *read_values(hid_t file, const char *path);

/* Number in the attribute of an object; NAN if there is none. */
double read_attribute(hid_t file, const char *object, const char *name);
bool read_text_is(hid_t file, const char *object, const char *name, const char *expected);

#endif
