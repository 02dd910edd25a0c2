#include "recorder/log_conversion.h"

#include <inttypes.h>
#include <stdio.h>

#include "common/event_log.h"

static enum status take_events(struct record_receiver *recording, struct event_reader *reader)
{
    struct event event;
    bool found;
    TRY(event_reader_next(reader, &event, &found));
    while (found) {
        enum recording_answer answer;
        int kind = message_kind(event.channel);
        if (kind >= 0 && kind < MESSAGE_LOGGED_KINDS)
            TRY(record_receiver_take(recording, kind, event.data, event.size, &answer));
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

enum status convert_log(struct record_receiver *recording, const char *path)
{
    struct event_reader reader;
    enum status status = event_reader_open(&reader, path);
    if (status == STATUS_OK)
        status = take_events(recording, &reader);
    if (status == STATUS_OK)
        report_damage(&reader, path);
    event_reader_close(&reader);
    if (status == STATUS_OK)
        return record_receiver_finish(recording);
    if (status != STATUS_INCOMPLETE)
        return status;
    char reason[512]; /* records that are not those that were sent: what came before them is kept */
    snprintf(reason, sizeof reason, "%s", status_message());
    enum status finished = record_receiver_finish(recording);
    if (finished != STATUS_OK && finished != STATUS_INCOMPLETE)
        return finished;
    return status_fail(STATUS_INCOMPLETE, "%s: %s", path, reason);
}

enum status convert_into(const char *path, const char *directory, struct run_counts *counts)
{
    struct record_receiver *recording;
    const struct record_receiver_options options = {
        .directory = directory, .any_run = true, .from_log = true, .replace = true};
    enum status status = record_receiver_create(&recording, &options);
    if (status == STATUS_OK)
        status = convert_log(recording, path);
    if (recording)
        *counts = record_receiver_counts(recording);
    record_receiver_free(recording);
    return status;
}
