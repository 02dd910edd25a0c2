#include "common/config_literals.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LITERAL_MAX = 512 };

struct scan {
    const char *at, *name;
    int line;
    int arrays; /* depth of [ ] */
    FILE *out;
};

static bool is_name_start(char c)
{
    return isalpha((unsigned char)c) || c == '*';
}

static bool is_name_part(char c)
{
    return isalnum((unsigned char)c) || c == '-' || c == '_' || c == '*';
}

static bool is_number_start(const char *at)
{
    if (*at == '+' || *at == '-')
        at++;
    return isdigit((unsigned char)*at) || *at == '.';
}

/* Copies up to `end`. */
static void copy_to(struct scan *scan, const char *end)
{
    for (; scan->at < end; scan->at++) {
        scan->line += *scan->at == '\n';
        fputc(*scan->at, scan->out);
    }
}

static void copy_string(struct scan *scan)
{
    const char *end = scan->at + 1;
    while (*end && *end != '"')
        end += *end == '\\' && end[1] ? 2 : 1;
    copy_to(scan, *end ? end + 1 : end);
}

/* A comment of either kind, if one begins here. */
static bool copy_comment(struct scan *scan)
{
    const char *at = scan->at, *end;
    if (at[0] == '#' || (at[0] == '/' && at[1] == '/')) {
        end = at + strcspn(at, "\n");
    } else if (at[0] == '/' && at[1] == '*') {
        end = strstr(at + 2, "*/");
        end = end ? end + 2 : at + strlen(at);
    } else {
        return false;
    }
    copy_to(scan, end);
    return true;
}

static const char *number_end(const char *at)
{
    at += *at == '+' || *at == '-';
    if (at[0] == '0' && (at[1] == 'x' || at[1] == 'X')) {
        for (at += 2; isxdigit((unsigned char)*at);)
            at++;
        return at;
    }
    at += strspn(at, "0123456789");
    if (*at == '.')
        at += 1 + strspn(at + 1, "0123456789");
    if (*at == 'e' || *at == 'E') {
        const char *exponent = at + 1 + (at[1] == '+' || at[1] == '-');
        size_t digits = strspn(exponent, "0123456789");
        at = digits ? exponent + digits : at;
    }
    return at;
}

static enum status refuse(const struct scan *scan, const char *literal, const char *why)
{
    if (!scan->name)
        return status_fail(STATUS_CONFIG, "--set: %s %s", literal, why);
    return status_fail(STATUS_CONFIG, "%s:%d: %s %s", scan->name, scan->line, literal, why);
}

static enum status put_float(struct scan *scan, const char *literal)
{
    errno = 0;
    double value = strtod(literal, NULL);
    if (!strpbrk(literal, "0123456789"))
        return refuse(scan, literal, "is not a number");
    if (!isfinite(value))
        return refuse(scan, literal, "is too large for a number; allowed: below 1.8e308");
    if (errno == ERANGE)
        return refuse(scan, literal, "is too small for a number; allowed: 0, or above 2.3e-308");
    fputs(literal, scan->out);
    return STATUS_OK;
}

static enum status put_integer(struct scan *scan, const char *literal, bool hexadecimal)
{
    errno = 0;
    long long value = strtoll(literal, NULL, hexadecimal ? 16 : 10);
    if (errno == ERANGE)
        return refuse(scan, literal,
                      "is too large for an integer; a number that large is written with a point or an "
                      "exponent, 1e19");
    if (hexadecimal && !literal[2])
        return refuse(scan, literal, "is not a number");
    if (scan->arrays > 0)
        fprintf(scan->out, "%lld.0", value);
    else if (value > INT32_MAX || value < INT32_MIN)
        fprintf(scan->out, "%lldL", value);
    else
        fprintf(scan->out, "%lld", value);
    return STATUS_OK;
}

/* What may not follow a number at once: without this, 1e4+0 would be written as 1e40, 3L5 as 35. */
static enum status check_number_ends(const struct scan *scan, const char *literal)
{
    const char *at = scan->at;
    if (!is_name_part(*at) && !is_number_start(at) && *at != '+' && *at != '"')
        return STATUS_OK;
    char text[LITERAL_MAX + 2];
    snprintf(text, sizeof text, "%s%c", literal, *at);
    return refuse(scan, text, "is not a number");
}

static enum status put_number(struct scan *scan)
{
    char literal[LITERAL_MAX];
    const char *end = number_end(scan->at);
    size_t length = (size_t)(end - scan->at);
    if (length >= sizeof literal)
        return refuse(scan, "a number", "is longer than 511 characters");
    memcpy(literal, scan->at, length);
    literal[length] = '\0';
    scan->at = end;
    bool hexadecimal = strpbrk(literal, "xX") != NULL;
    const bool integer = hexadecimal || !strpbrk(literal, ".eE");
    for (int k = 0; integer && k < 2 && *scan->at == 'L'; k++)
        scan->at++; /* the suffix follows from the value */
    TRY(check_number_ends(scan, literal));
    if (!integer)
        return put_float(scan, literal);
    return put_integer(scan, literal, hexadecimal);
}

static enum status scan_text(struct scan *scan)
{
    while (*scan->at) {
        const char *end = scan->at + 1;
        if (*scan->at == '"') {
            copy_string(scan);
        } else if (copy_comment(scan)) {
            continue;
        } else if (*scan->at == '@') {
            return refuse(scan, "@include", "is not allowed: a scene is one file, which is recorded whole");
        } else if (is_name_start(*scan->at)) {
            while (is_name_part(*end))
                end++;
            copy_to(scan, end);
        } else if (is_number_start(scan->at)) {
            TRY(put_number(scan));
        } else {
            scan->arrays += (*scan->at == '[') - (*scan->at == ']');
            copy_to(scan, end);
        }
    }
    return STATUS_OK;
}

enum status config_literals(const char *text, const char *name, char **checked)
{
    size_t size = 0;
    struct scan scan = {.at = text, .name = name, .line = 1};
    *checked = NULL;
    scan.out = open_memstream(checked, &size);
    if (!scan.out)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    enum status status = scan_text(&scan);
    if (fclose(scan.out) != 0 && status == STATUS_OK)
        status = status_fail(STATUS_NO_MEMORY, "out of memory");
    if (status != STATUS_OK) {
        free(*checked);
        *checked = NULL;
    }
    return status;
}
