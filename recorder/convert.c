#include "recorder/convert.h"

#include <inttypes.h>
#include <stdio.h>

#include "recorder/event_log.h"

/* As when recording live, so that what was written so far is readable if the disk becomes full. */
static const double FLUSH_EVERY_S = 2.0;

static enum status flush_now_and_then(struct recording *recording, double *flush_at_s)
{
    if (clock_now_s() - *flush_at_s < FLUSH_EVERY_S)
        return STATUS_OK;
    TRY(recording_flush(recording));
    *flush_at_s = clock_now_s();
    return STATUS_OK;
}

static enum status take_events(struct recording *recording, struct event_reader *reader)
{
    struct event event;
    double flush_at_s = clock_now_s();
    bool found;
    TRY(event_reader_next(reader, &event, &found));
    while (found) {
        enum recording_answer answer;
        int kind = message_kind(event.channel);
        if (kind >= 0 && kind < MESSAGE_LOGGED_KINDS)
            TRY(recording_take(recording, kind, event.data, event.size, &answer));
        TRY(flush_now_and_then(recording, &flush_at_s));
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
