/* run.h5 as the analyzer and the export read it: a valid file with changes (hdf5_mutation.h). */
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "analyzer/run_file.h"
#include "fuzz.h"
#include "hdf5_mutation.h"
#include "recorder/log_conversion.h"
#include "recorder/run_frames.h"
#include "test_recorder_synthetic.h"

static const char *file_of_this_process(const char *what)
{
    static char path[64];
    snprintf(path, sizeof path, "/dev/shm/shakedown-fuzz-%d-%s", (int)getpid(), what);
    return path;
}

struct image {
    unsigned char *bytes;
    size_t size;
};

static void must(enum status status)
{
    if (status == STATUS_OK || status == STATUS_INCOMPLETE)
        return;
    fprintf(stderr, "the valid file cannot be made: %s\n", status_message());
    exit(1);
}

static struct image image_read(const char *path)
{
    struct image image = {0};
    FILE *in = fopen(path, "rb");
    if (!in || fseek(in, 0, SEEK_END) != 0)
        exit(1);
    image.size = (size_t)ftell(in);
    image.bytes = malloc(image.size);
    rewind(in);
    if (!image.bytes || fread(image.bytes, 1, image.size, in) != image.size || fclose(in) != 0)
        exit(1);
    return image;
}

/* A small run with friction, recorded by the recorder. */
static struct image image_make(void)
{
    struct synthetic_options options = synthetic_default;
    struct synthetic_run run;
    struct record_receiver *recording;
    enum recording_answer answer;
    char directory[64], path[128];
    options.frictional = true;
    options.n_particles = 20;
    options.n_samples = 8;
    synthetic_create(&run, &options);
    synthetic_directory(directory);
    const struct record_receiver_options how = {.directory = directory, .any_run = true, .from_log = true};
    must(record_receiver_create(&recording, &how));
    for (size_t k = 0; k < run.count; k++)
        must(
            record_receiver_take(recording, run.messages[k].kind, run.messages[k].data, run.messages[k].size, &answer));
    must(record_receiver_finish(recording));
    record_receiver_free(recording);
    snprintf(path, sizeof path, "%s/run.h5", directory);
    struct image image = image_read(path);
    synthetic_directory_remove(directory);
    synthetic_free(&run);
    return image;
}

static void frames_read(const char *path)
{
    struct run_frames run;
    enum status status = run_frames_open(&run, path);
    if (status != STATUS_OK)
        return;
    for (int64_t f = 0; status == STATUS_OK && f < run.n_frames && f < 8; f++) {
        double end_m[2][3];
        status = run_frames_read(&run, f);
        for (int64_t c = 0; status == STATUS_OK && c < run.contacts.rows; c++)
            run_frames_contact_ends(&run, c, end_m);
    }
    run_frames_close(&run);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static struct image image;
    struct run run;
    if (!image.bytes)
        image = image_make();
    const char *path = file_of_this_process("run");
    FILE *out = fopen(path, "wb");
    if (!out || fwrite(image.bytes, 1, image.size, out) != image.size || fclose(out) != 0)
        exit(1);
    hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
    if (file >= 0)
        hdf5_mutate(file, data, size);
    if (file >= 0 && H5Fclose(file) >= 0) {
        if (run_read(&run, path) == STATUS_OK)
            run_free(&run);
        frames_read(path);
    }
    (void)unlink(path);
    return 0;
}
