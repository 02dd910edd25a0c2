/* Status codes of every function that can fail, and the text of the last failure in this thread. */
#ifndef SHAKEDOWN_COMMON_STATUS_H
#define SHAKEDOWN_COMMON_STATUS_H

#define MUST_USE          __attribute__((warn_unused_result))
#define PRINTF_LIKE(f, a) __attribute__((format(printf, f, a)))

/* name, number (in messages, files and as a process's exit code), text */
#define STATUS_LIST(X)                                                                                                 \
    X(OK, 0, "ok")                                                                                                     \
    X(USAGE, 2, "wrong command line")                                                                                  \
    X(CONFIG, 3, "wrong scene file")                                                                                   \
    X(NO_MEMORY, 4, "out of memory")                                                                                   \
    X(IO, 5, "input or output failed")                                                                                 \
    X(FORMAT, 6, "file or message has not the expected form")                                                          \
    X(BUS, 7, "the LCM bus failed")                                                                                    \
    X(TIMEOUT, 8, "a process did not answer in time")                                                                  \
    X(INCOMPLETE, 9, "messages are missing")                                                                           \
    X(UNSTABLE, 10, "the simulation became unstable")                                                                  \
    X(LIMIT, 11, "a limit was exceeded")                                                                               \
    X(DOUBTFUL, 12, "the run ended, but its result is doubtful")                                                       \
    X(INTERRUPTED, 130, "interrupted")

enum status {
#define STATUS_ENUM(name, code, text) STATUS_##name = (code),
    STATUS_LIST(STATUS_ENUM)
#undef STATUS_ENUM
};

/* Keeps a formatted message for this thread and returns `status`: `return status_fail(STATUS_IO, "...", ...);`. */
enum status status_fail(enum status status, const char *format, ...) PRINTF_LIKE(2, 3);

/* The message kept by the last status_fail in this thread ("" if none). Valid until the next status_fail. */
const char *status_message(void);

/* The list's text and process exit code. */
const char *status_text(enum status status);
int status_exit_code(enum status status);

/* Prints "<program>: error: <message>" on stderr unless status is OK; returns the exit code for main. */
int status_report(const char *program, enum status status);

/* Returns from the calling function unless `expression` is STATUS_OK. */
#define TRY(expression)                                                                                                \
    do {                                                                                                               \
        enum status try_status_ = (expression);                                                                        \
        if (try_status_ != STATUS_OK)                                                                                  \
            return try_status_;                                                                                        \
    } while (0)

#endif
