#include "common/command_line.h"

#include <errno.h>
#include <getopt.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { OPTION_SET = 1, OPTION_SEED, OPTION_RUN_ID, OPTION_LCM, OPTION_HELP, OPTION_VERSION, OPTION_SHARED_END };
enum { OPTION_OWN = 1000 }; /* first value of the process's own options, clear of characters and shared ones */

static const struct option shared_options[] = {
    {"set", required_argument, NULL, OPTION_SET},       {"seed", required_argument, NULL, OPTION_SEED},
    {"run-id", required_argument, NULL, OPTION_RUN_ID}, {"lcm", required_argument, NULL, OPTION_LCM},
    {"help", no_argument, NULL, OPTION_HELP},           {"version", no_argument, NULL, OPTION_VERSION}};
enum { SHARED_OPTIONS = sizeof shared_options / sizeof shared_options[0] };

static enum status integer_parse(const char *option, const char *text, int64_t *value)
{
    char *end = NULL;
    errno = 0;
    long long parsed = strtoll(text, &end, 10);
    if (errno != 0 || end == text || *end != '\0')
        return status_fail(STATUS_USAGE, "--%s wants an integer, not \"%s\"", option, text);
    *value = parsed;
    return STATUS_OK;
}

static enum status override_add(struct command_line *line, const char *assignment)
{
    if (strchr(assignment, '=') == NULL || assignment[0] == '=')
        return status_fail(STATUS_USAGE, "--set wants path=value, not \"%s\"", assignment);
    if (line->n_overrides == COMMAND_LINE_OVERRIDES_MAX)
        return status_fail(STATUS_USAGE, "more than %d times --set", COMMAND_LINE_OVERRIDES_MAX);
    line->override[line->n_overrides++] = assignment;
    return STATUS_OK;
}

static enum status seed_set(struct command_line *line, const char *text)
{
    int64_t seed = 0;
    TRY(integer_parse("seed", text, &seed));
    if (line->seed_override[0])
        return status_fail(STATUS_USAGE, "--seed is given twice");
    /* The L keeps seeds of 2^31 and more whole: without it libconfig reads 32 bits. */
    snprintf(line->seed_override, sizeof line->seed_override, "seed=%" PRId64 "L", seed);
    return override_add(line, line->seed_override);
}

static enum status shared_option_take(struct command_line *line, int option, const char *argument)
{
    switch (option) {
    case OPTION_SET:
        return override_add(line, argument);
    case OPTION_SEED:
        return seed_set(line, argument);
    case OPTION_RUN_ID:
        line->run_id_given = true;
        return integer_parse("run-id", argument, &line->run_id);
    case OPTION_LCM:
        line->lcm_url = argument;
        return STATUS_OK;
    case OPTION_HELP:
        line->help = true;
        return STATUS_OK;
    default:
        line->version = true;
        return STATUS_OK;
    }
}

/* Fills `options` with the shared and the process's own options, zero ended. */
static enum status options_collect(struct option options[SHARED_OPTIONS + COMMAND_LINE_OWN_MAX + 1],
                                   const struct command_line_option *own)
{
    int count = SHARED_OPTIONS;
    memset(options, 0, sizeof(struct option) * (SHARED_OPTIONS + COMMAND_LINE_OWN_MAX + 1));
    memcpy(options, shared_options, sizeof shared_options);
    for (int k = 0; own && own[k].name; k++) {
        if (k == COMMAND_LINE_OWN_MAX)
            return status_fail(STATUS_LIMIT, "a process has more than %d options", COMMAND_LINE_OWN_MAX);
        options[count++] =
            (struct option){own[k].name, own[k].value ? required_argument : no_argument, NULL, OPTION_OWN + k};
    }
    return STATUS_OK;
}

static enum status positional_take(struct command_line *line, int argc, char **argv)
{
    for (int k = optind; k < argc; k++) {
        if (line->n_positional == COMMAND_LINE_POSITIONAL_MAX)
            return status_fail(STATUS_USAGE, "too many arguments, from \"%s\" on", argv[k]);
        line->positional[line->n_positional++] = argv[k];
    }
    return STATUS_OK;
}

enum status command_line_parse(struct command_line *line, int argc, char **argv, const struct command_line_option *own)
{
    struct option options[SHARED_OPTIONS + COMMAND_LINE_OWN_MAX + 1];
    memset(line, 0, sizeof *line);
    TRY(options_collect(options, own));
    optind = 0; /* glibc: start afresh, so that a test may parse more than once */
    opterr = 0;
    for (;;) {
        int option = getopt_long(argc, argv, ":", options, NULL);
        if (option == -1)
            return positional_take(line, argc, argv);
        if (option == ':')
            return status_fail(STATUS_USAGE, "%s wants a value", argv[optind - 1]);
        if (option == '?')
            return status_fail(STATUS_USAGE, "unknown option \"%s\" (see --help)", argv[optind - 1]);
        if (option < OPTION_SHARED_END)
            TRY(shared_option_take(line, option, optarg));
        else if (own[option - OPTION_OWN].value)
            *own[option - OPTION_OWN].value = optarg;
        else
            *own[option - OPTION_OWN].flag = true;
    }
}
