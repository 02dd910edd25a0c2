#include "recorder/convert.h"

#include <inttypes.h>
#include <stdio.h>

#include "recorder/event_log.h"

static enum status take_events(struct recording *recording, struct event_reader *reader)
{
    struct event event;
    bool found;
    TRY(event_reader_next(reader, &event, &found));
    while (found) {
        enum recording_answer answer;
        int kind = message_kind(event.channel);
        if (kind >= 0)
            TRY(recording_take(recording, kind, event.data, event.size, &answer));
        TRY(event_reader_next(reader, &event, &found));
    }
    return STATUS_OK;
}

static void report_damage(const struct event_reader *reader, const char *path)
{
    if (reader->cut)
        fprintf(stderr, "recorder: warning: %s ends in the middle of a message\n", path);
    if (reader->skipped_bytes > 0)
        fprintf(stderr, "recorder: warning: %s: skipped %" PRId64 " bytes that are no message\n", path,
                reader->skipped_bytes);
}

enum status convert_log(struct recording *recording, const char *path)
{
    struct event_reader reader;
    enum status status = event_reader_open(&reader, path);
    if (status == STATUS_OK)
        status = take_events(recording, &reader);
    if (status == STATUS_OK)
        report_damage(&reader, path);
    event_reader_close(&reader);
    if (status == STATUS_OK)
        return recording_finish(recording);
    char reason[1024];
    snprintf(reason, sizeof reason, "%s", status_message());
    return recording_finish(recording) == STATUS_OK ? status : status_fail(status, "%s", reason);
}
