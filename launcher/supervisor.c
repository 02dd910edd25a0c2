#include "launcher/supervisor.h"

#include <glib.h>
#include <stdio.h>

#include "common/bus.h"

bool supervisor_has(const struct supervisor *s, enum role role)
{
    return s->child[role].running;
}

bool supervisor_has_any(const struct supervisor *s)
{
    for (int role = 0; role < ROLES; role++)
        if (role != ROLE_WATCH && supervisor_has(s, role))
            return true;
    return false;
}

void supervisor_wait_at_most(struct supervisor *s, double wait_s)
{
    s->deadline_s = clock_now_s() + wait_s;
}

void supervisor_signal_all(struct supervisor *s, int signal_number)
{
    for (int role = 0; role < ROLES; role++)
        if (role != ROLE_WATCH)
            child_signal(&s->child[role], signal_number);
}

static void note_pid(const struct supervisor *s, const struct child *child)
{
    char *path = run_folder_file(&s->launch->folder, "log/pids");
    FILE *file = fopen(path, "a");
    if (file) { /* for people: without it the run goes on */
        fprintf(file, "%s %d\n", child->name, (int)child->pid);
        (void)fclose(file);
    }
    g_free(path);
}

enum status supervisor_start(struct supervisor *s, enum role role, bool resume)
{
    const bool shows = role == ROLE_WATCH || role == ROLE_ANALYZER;
    const bool in_folder = role == ROLE_CONVERTER || (role == ROLE_SIM && launch_in_process(s->launch));
    const char *name = role_name(s->launch, role);
    char *file = g_strdup_printf("log/%s.log", name), *log = run_folder_file(&s->launch->folder, file);
    char **command = role_command(s->launch, role, resume);
    const struct child_place place = {.directory = in_folder ? s->launch->folder.path : NULL,
                                      .log = shows ? NULL : log,
                                      .shown = role == ROLE_SIM && launch_in_process(s->launch)};
    enum status status = child_start(&s->child[role], name, command, &place);
    if (status == STATUS_OK && !shows)
        note_pid(s, &s->child[role]);
    g_strfreev(command);
    g_free(file);
    g_free(log);
    return status;
}
