/* fuzz_seeds FOLDER: valid inputs to begin with: FOLDER/message, FOLDER/event_log, FOLDER/run_file, FOLDER/checkpoint.
 */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/event_log.h"
#include "hdf5_mutation.h"
#include "test_recorder_synthetic.h"

static void must(bool ok, const char *what)
{
    if (ok)
        return;
    fprintf(stderr, "fuzz_seeds: %s\n", what);
    exit(1);
}

static void folder_make(char *path, size_t size, const char *folder, const char *name)
{
    snprintf(path, size, "%s/%s", folder, name);
    must(mkdir(path, 0777) == 0 || errno == EEXIST, path);
}

static void file_write(const char *path, const void *head, size_t head_size, const void *data, size_t size)
{
    FILE *out = fopen(path, "wb");
    must(out && fwrite(head, 1, head_size, out) == head_size && fwrite(data, 1, size, out) == size && fclose(out) == 0,
         path);
}

/* Of each kind the first and the last. */
static void messages_write(const struct synthetic_run *run, const char *folder)
{
    char own[512], path[600];
    folder_make(own, sizeof own, folder, "message");
    for (size_t k = 0; k < run->count; k++) {
        const uint8_t kind = (uint8_t)run->messages[k].kind;
        snprintf(path, sizeof path, "%s/%d-last", own, kind);
        file_write(path, &kind, 1, run->messages[k].data, run->messages[k].size);
        snprintf(path, sizeof path, "%s/%d-first", own, kind);
        if (access(path, F_OK) != 0)
            file_write(path, &kind, 1, run->messages[k].data, run->messages[k].size);
    }
}

/* With our checksums, and without, as LCM's logger writes. */
static void log_write(const struct synthetic_run *run, const char *folder)
{
    char own[512], path[600];
    struct event_writer *writer;
    folder_make(own, sizeof own, folder, "event_log");
    snprintf(path, sizeof path, "%s/checked", own);
    (void)unlink(path);
    must(event_writer_open(&writer, path, EVENT_START_NEW) == STATUS_OK, path);
    for (size_t k = 0; k < run->count && k < 24; k++) {
        const struct synthetic_message *message = &run->messages[k];
        must(event_writer_add(writer, message_channel(message->kind), message->data, message->size) == STATUS_OK, path);
    }
    must(event_writer_close(writer) == STATUS_OK, path);
    static unsigned char bytes[1 << 16];
    FILE *in = fopen(path, "rb");
    must(in != NULL, path);
    const size_t size = fread(bytes, 1, sizeof bytes, in);
    must(fclose(in) == 0, path);
    for (size_t at = 0; at + 8 <= size; at++) { /* the checksum follows the magic number */
        if (bytes[at] == 0xed && bytes[at + 1] == 0xa1 && bytes[at + 2] == 0xda && bytes[at + 3] == 0x01)
            bytes[at + 4] = bytes[at + 5] = bytes[at + 6] = bytes[at + 7] = 0;
    }
    snprintf(path, sizeof path, "%s/plain", own);
    file_write(path, "", 0, bytes, size);
}

/* Changes of HDF5 files: one of each kind to each of many objects. */
static void mutations_write(const char *folder, const char *name)
{
    char own[512], path[600];
    folder_make(own, sizeof own, folder, name);
    for (int k = 0; k < 6; k++) {
        uint8_t bytes[MUTATION_BYTES * 3];
        for (size_t b = 0; b < sizeof bytes; b++)
            bytes[b] = (uint8_t)(b % MUTATION_BYTES == 0 ? (size_t)k : 37 * b + 11 * (size_t)k);
        snprintf(path, sizeof path, "%s/kind-%d", own, k);
        file_write(path, "", 0, bytes, k < 5 ? sizeof bytes : 0);
    }
}

int main(int argc, char **argv)
{
    struct synthetic_options options = synthetic_default;
    struct synthetic_run run;
    must(argc == 2, "usage: fuzz_seeds FOLDER");
    must(mkdir(argv[1], 0777) == 0 || errno == EEXIST, argv[1]);
    options.frictional = options.walls = true;
    options.n_particles = 12;
    options.n_samples = 4;
    options.n_frames = 2;
    options.n_wall_states = 3;
    synthetic_create(&run, &options);
    messages_write(&run, argv[1]);
    log_write(&run, argv[1]);
    mutations_write(argv[1], "run_file");
    mutations_write(argv[1], "checkpoint");
    synthetic_free(&run);
    return 0;
}
