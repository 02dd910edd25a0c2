#include "launcher/record_state.h"

#include <glib.h>
#include <hdf5.h>
#include <stdlib.h>

#include "common/event_log.h"
#include "common/message.h"

/* -1 if it cannot be read. */
static int attribute_read(hid_t file, const char *name)
{
    int value = -1;
    const hid_t attribute = H5Aopen_by_name(file, "/", name, H5P_DEFAULT, H5P_DEFAULT);
    if (attribute < 0)
        return -1;
    if (H5Aread(attribute, H5T_NATIVE_INT, &value) < 0)
        value = -1;
    (void)H5Aclose(attribute);
    return value;
}

bool record_is_complete(const struct run_folder *folder)
{
    if (!run_folder_has(folder, "run.h5"))
        return false;
    /* A file that a kill has left may be damaged: not worth HDF5's words. A lock would disturb others. */
    if (H5Eset_auto2(H5E_DEFAULT, NULL, NULL) < 0 || setenv("HDF5_USE_FILE_LOCKING", "FALSE", 0) != 0)
        return false;
    char *path = run_folder_file(folder, "run.h5");
    const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    g_free(path);
    if (file < 0)
        return false;
    const bool complete = attribute_read(file, "complete") == 1 && attribute_read(file, "status") == 0;
    (void)H5Fclose(file);
    return complete;
}

static enum status log_look(struct event_reader *reader, bool *complete)
{
    struct event event;
    bool found;
    *complete = false;
    TRY(event_reader_next(reader, &event, &found));
    while (found) {
        *complete = message_is_good_end(event.channel, event.data, event.size);
        TRY(event_reader_next(reader, &event, &found));
    }
    *complete &= reader->skipped_bytes == 0 && !reader->cut;
    return STATUS_OK;
}

bool log_is_complete(const struct run_folder *folder)
{
    struct event_reader reader;
    bool complete = false;
    if (!run_folder_has(folder, "run.lcm"))
        return false;
    char *path = run_folder_file(folder, "run.lcm");
    if (event_reader_open(&reader, path) != STATUS_OK || log_look(&reader, &complete) != STATUS_OK)
        complete = false; /* who has to read it says why it cannot be read */
    event_reader_close(&reader);
    g_free(path);
    return complete;
}
