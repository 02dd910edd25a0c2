#include "launcher/report.h"

#include <glib.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { LINES_OF_LOG = 15 };

void say(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    char *text = g_strdup_vprintf(format, arguments);
    va_end(arguments);
    fprintf(stderr, "%sshakedown: %s\n", isatty(STDERR_FILENO) ? "\r\033[K" : "", text);
    g_free(text);
}

void end_text(char *text, int exit_code)
{
    const char *name = exit_code > EXIT_CODE_OF_SIGNAL ? sigabbrev_np(exit_code - EXIT_CODE_OF_SIGNAL) : NULL;
    if (exit_code == EXIT_CODE_TIMEOUT)
        snprintf(text, END_TEXT_MAX, "did not end in time");
    else if (name)
        snprintf(text, END_TEXT_MAX, "was ended by signal %s", name);
    else
        snprintf(text, END_TEXT_MAX, "ended with exit code %d", exit_code);
}

static void show_log(struct child *child)
{
    char **lines = g_strsplit(child_log_last_lines(&child->log, LINES_OF_LOG), "\n", -1);
    for (char **line = lines; *line; line++)
        if (**line || line[1])
            fprintf(stderr, "    %s\n", *line);
    g_strfreev(lines);
}

void report_failure(struct child *child, int exit_code, const struct run_folder *folder)
{
    char text[END_TEXT_MAX];
    end_text(text, exit_code);
    say("%s %s", child->name, text);
    show_log(child);
    if (exit_code == status_exit_code(STATUS_BUS))
        say("if multicast is blocked on this machine, try --private");
    say("logs: %s/log", folder->path);
}

void report_record(const struct run_folder *folder)
{
    if (run_folder_has(folder, "run.h5"))
        say("recorded so far: %s/run.h5", folder->path);
    else
        say("nothing was recorded in %s", folder->path);
}

char *report_shell_word(const char *path)
{
    static const char plain[] = G_CSET_a_2_z G_CSET_A_2_Z G_CSET_DIGITS "/._-+:,=@%";
    return path[strspn(path, plain)] == '\0' ? g_strdup(path) : g_shell_quote(path);
}

void report_way_on(const struct run_folder *folder)
{
    char *path = report_shell_word(folder->path);
    fprintf(stderr, "go on with: ./shakedown run --resume %s\n", path);
    g_free(path);
}
