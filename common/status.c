#include "common/status.h"

#include <stdarg.h>
#include <stdio.h>

static _Thread_local char last_message[1024];

enum status status_fail(enum status status, const char *format, ...)
{
    char text[sizeof last_message];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    snprintf(last_message, sizeof last_message, "%s", text);
    return status;
}

const char *status_message(void)
{
    return last_message;
}

const char *status_text(enum status status)
{
    switch (status) {
#define STATUS_TEXT(name, code, text)                                                                                  \
    case STATUS_##name:                                                                                                \
        return text;
        STATUS_LIST(STATUS_TEXT)
#undef STATUS_TEXT
    }
    return "unknown status";
}

int status_exit_code(enum status status)
{
    return (int)status;
}

int status_report(const char *program, enum status status)
{
    if (status != STATUS_OK)
        fprintf(stderr, "%s: %s%s\n", program,
                status == STATUS_DOUBTFUL ? "" : "error: ", last_message[0] ? last_message : status_text(status));
    return status_exit_code(status);
}
