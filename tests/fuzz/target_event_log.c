/* An event log: any bytes as a file. */
#include <stdio.h>
#include <sys/mman.h>
#include <unistd.h>

#include "common/event_log.h"
#include "common/message.h"
#include "fuzz.h"

static void events_read(const char *path)
{
    struct event_reader reader;
    struct event event;
    bool found = true;
    enum status status = event_reader_open(&reader, path);
    while (status == STATUS_OK && found) {
        union message message;
        status = event_reader_next(&reader, &event, &found);
        const int kind = status == STATUS_OK && found ? message_kind(event.channel) : -1;
        if (kind >= 0 && message_decode(kind, event.data, event.size, &message) == STATUS_OK)
            message_free(kind, &message);
    }
    event_reader_close(&reader);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char path[64];
    const int file = memfd_create("log", 0);
    if (file < 0)
        return 0;
    snprintf(path, sizeof path, "/proc/self/fd/%d", file);
    if (write(file, data, size) == (ssize_t)size)
        events_read(path);
    close(file);
    return 0;
}
