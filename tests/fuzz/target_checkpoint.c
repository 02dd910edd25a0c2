/* A checkpoint ($FUZZ_CHECKPOINT, a valid one) with changes (hdf5_mutation.h) and a right hash. */
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "fuzz.h"
#include "hdf5_mutation.h"
#include "sim/run/checkpoint.h"
#include "sim/run/checkpoint_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const char *valid = getenv("FUZZ_CHECKPOINT");
    char path[64];
    hid_t file = H5I_INVALID_HID;
    struct checkpoint_content *content = NULL;
    if (!valid || checkpoint_image_load(valid, &file) != STATUS_OK) {
        fprintf(stderr, "FUZZ_CHECKPOINT names no checkpoint\n");
        exit(1);
    }
    hdf5_mutate(file, data, size);
    snprintf(path, sizeof path, "/dev/shm/shakedown-fuzz-%d-checkpoint", (int)getpid());
    const enum status saved = checkpoint_image_save(file, path);
    checkpoint_image_close(file);
    if (saved == STATUS_OK && checkpoint_load_sample(&content, path) == STATUS_OK)
        checkpoint_content_free(content);
    (void)unlink(path);
    return 0;
}
