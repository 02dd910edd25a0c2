#include "common/config_table.h"

#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "common/config_literals.h"

static _Thread_local char source_name[256] = "scene";

void config_source_name(const char *name)
{
    snprintf(source_name, sizeof source_name, "%s", name);
}

static void *field(void *target, const struct key *key)
{
    return (char *)target + key->offset;
}

static const void *field_const(const void *target, const struct key *key)
{
    return (const char *)target + key->offset;
}

static int choice_index(const struct key *key, const char *text)
{
    for (int k = 0; key->choices[k]; k++)
        if (strcmp(key->choices[k], text) == 0)
            return k;
    return -1;
}

/* "[0, 1]", "> 0" ... what a number may be, into `text`. */
static const char *range_text(const struct key *key, char *text, size_t size)
{
    const char *unit = key->unit ? key->unit : "";
    if (isinf(key->max) && isinf(key->min))
        snprintf(text, size, "any number %s", unit);
    else if (isinf(key->max))
        snprintf(text, size, "at least %g %s", key->min, unit);
    else
        snprintf(text, size, "%g to %g %s", key->min, key->max, unit);
    size_t length = strlen(text);
    if (length && text[length - 1] == ' ')
        text[length - 1] = '\0';
    return text;
}

static void choices_text(const struct key *key, char *text, size_t size)
{
    size_t used = 0;
    text[0] = '\0';
    for (int k = 0; key->choices[k] && used < size; k++)
        used += (size_t)snprintf(text + used, size - used, "%s\"%s\"", k ? ", " : "", key->choices[k]);
}

enum status config_fail(const config_setting_t *setting, const char *where, const char *format, ...)
{
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    unsigned line = config_setting_source_line(setting);
    if (line == 0) /* added by config_override */
        return status_fail(STATUS_CONFIG, "--set: %s: %s", where, text);
    return status_fail(STATUS_CONFIG, "%s:%u: %s: %s", source_name, line, where, text);
}

void config_defaults(const struct key *table, void *target)
{
    for (const struct key *key = table; key->name; key++) {
        void *value = field(target, key);
        if (key->type == KEY_GROUP) {
            config_defaults(key->group, value);
            continue;
        }
        if (key->type == KEY_FLOATS || key->type == KEY_BAND) {
            memset(value, 0, key->type == KEY_BAND ? sizeof(struct config_band) : sizeof(struct config_floats));
            continue;
        }
        const char *preset = key->preset ? key->preset : "";
        switch (key->type) {
        case KEY_BOOL:
            *(bool *)value = strcmp(preset, "true") == 0;
            break;
        case KEY_INT:
            *(int64_t *)value = strtoll(preset, NULL, 10);
            break;
        case KEY_FLOAT:
            *(double *)value =
                key->choices && strcmp(preset, key->choices[0]) == 0 ? (double)NAN : strtod(preset, NULL);
            break;
        case KEY_STRING:
            snprintf(value, CONFIG_STRING_MAX, "%s", preset);
            break;
        case KEY_CHOICE:
            *(int *)value = choice_index(key, preset) < 0 ? 0 : choice_index(key, preset);
            break;
        default:
            break;
        }
    }
}

static const struct key *table_find(const struct key *table, const char *name)
{
    for (const struct key *key = table; key->name; key++)
        if (strcmp(key->name, name) == 0)
            return key;
    return NULL;
}

static bool is_number(const config_setting_t *setting)
{
    int type = config_setting_type(setting);
    return type == CONFIG_TYPE_INT || type == CONFIG_TYPE_INT64 || type == CONFIG_TYPE_FLOAT;
}

static double number_of(const config_setting_t *setting)
{
    switch (config_setting_type(setting)) {
    case CONFIG_TYPE_INT:
        return config_setting_get_int(setting);
    case CONFIG_TYPE_INT64:
        return (double)config_setting_get_int64(setting);
    default:
        return config_setting_get_float(setting);
    }
}

static enum status check_range(const config_setting_t *setting, const struct key *key, const char *where, double value)
{
    char range[96];
    if (!isfinite(value) || !(value >= key->min && value <= key->max))
        return config_fail(setting, where, "%g is out of range; allowed: %s", value,
                           range_text(key, range, sizeof range));
    return STATUS_OK;
}

static enum status read_int(const config_setting_t *setting, const struct key *key, const char *where, int64_t *value)
{
    int type = config_setting_type(setting);
    if (type != CONFIG_TYPE_INT && type != CONFIG_TYPE_INT64)
        return config_fail(setting, where, "must be an integer%s%s", key->unit ? " in " : "",
                           key->unit ? key->unit : "");
    *value = type == CONFIG_TYPE_INT ? config_setting_get_int(setting) : config_setting_get_int64(setting);
    return check_range(setting, key, where, (double)*value);
}

/* A list of at most `limit` numbers, or one number. */
static enum status read_numbers(const config_setting_t *setting, const struct key *key, const char *where, int limit,
                                int64_t *count, double *value)
{
    int type = config_setting_type(setting);
    if (is_number(setting)) {
        *count = 1;
        value[0] = number_of(setting);
        return check_range(setting, key, where, value[0]);
    }
    if (type != CONFIG_TYPE_ARRAY && type != CONFIG_TYPE_LIST)
        return config_fail(setting, where, "must be a list of numbers: [a, b, ...] or (a, b, ...)");
    int length = config_setting_length(setting);
    if (length > limit)
        return config_fail(setting, where, "has %d members; allowed: at most %d", length, limit);
    *count = length;
    for (int k = 0; k < length; k++) {
        const config_setting_t *element = config_setting_get_elem(setting, (unsigned)k);
        if (!is_number(element))
            return config_fail(setting, where, "member %d is not a number", k);
        value[k] = number_of(element);
        TRY(check_range(element, key, where, value[k]));
    }
    return STATUS_OK;
}

static enum status read_band(const config_setting_t *setting, const struct key *key, const char *where,
                             struct config_band *band)
{
    TRY(read_numbers(setting, key, where, 2, &band->count, band->value));
    if (band->count == 1 && band->value[0] == 0)
        return config_fail(setting, where,
                           "0 can be reached from either side; allowed: [low, high], or a number that "
                           "is not 0");
    if (band->count == 2 && !(band->value[0] < band->value[1]))
        return config_fail(setting, where, "[%g, %g] is not a band; allowed: [low, high]", band->value[0],
                           band->value[1]);
    return STATUS_OK;
}

static enum status read_choice(const config_setting_t *setting, const struct key *key, const char *where, int *value)
{
    char allowed[256];
    choices_text(key, allowed, sizeof allowed);
    if (config_setting_type(setting) != CONFIG_TYPE_STRING)
        return config_fail(setting, where, "must be one of %s", allowed);
    int index = choice_index(key, config_setting_get_string(setting));
    if (index < 0)
        return config_fail(setting, where, "\"%s\" is unknown; allowed: %s", config_setting_get_string(setting),
                           allowed);
    *value = index;
    return STATUS_OK;
}

static enum status read_string(const config_setting_t *setting, const char *where, char *value)
{
    if (config_setting_type(setting) != CONFIG_TYPE_STRING)
        return config_fail(setting, where, "must be a string in double quotes");
    const char *text = config_setting_get_string(setting);
    if (strlen(text) >= CONFIG_STRING_MAX)
        return config_fail(setting, where, "is longer than %d characters", CONFIG_STRING_MAX - 1);
    strcpy(value, text);
    return STATUS_OK;
}

static enum status read_value(const config_setting_t *setting, const struct key *key, const char *where, void *value)
{
    switch (key->type) {
    case KEY_BOOL:
        if (config_setting_type(setting) != CONFIG_TYPE_BOOL)
            return config_fail(setting, where, "must be true or false");
        *(bool *)value = config_setting_get_bool(setting);
        return STATUS_OK;
    case KEY_INT:
        return read_int(setting, key, where, value);
    case KEY_FLOAT:
        if (key->choices && config_setting_type(setting) == CONFIG_TYPE_STRING &&
            strcmp(config_setting_get_string(setting), key->choices[0]) == 0) {
            *(double *)value = (double)NAN; /* the reader of the table puts the number there */
            return STATUS_OK;
        }
        if (!is_number(setting))
            return config_fail(setting, where, "must be a number%s%s%s%s%s", key->unit ? " in " : "",
                               key->unit ? key->unit : "", key->choices ? ", or \"" : "",
                               key->choices ? key->choices[0] : "", key->choices ? "\"" : "");
        *(double *)value = number_of(setting);
        return check_range(setting, key, where, *(double *)value);
    case KEY_STRING:
        return read_string(setting, where, value);
    case KEY_CHOICE:
        return read_choice(setting, key, where, value);
    case KEY_FLOATS: {
        struct config_floats *list = value;
        return read_numbers(setting, key, where, CONFIG_FLOATS_MAX, &list->count, list->value);
    }
    case KEY_BAND:
        return read_band(setting, key, where, value);
    case KEY_GROUP:
        if (!config_setting_is_group(setting))
            return config_fail(setting, where, "must be a group: %s = { ... }", key->name);
        return config_group_read(setting, key->group, where, NULL, value);
    }
    return STATUS_OK;
}

static void unknown_key_text(const struct key *table, char *text, size_t size)
{
    size_t used = 0;
    text[0] = '\0';
    for (const struct key *key = table; key->name && used < size; key++)
        used += (size_t)snprintf(text + used, size - used, "%s%s", key == table ? "" : " ", key->name);
}

enum status config_group_read(const config_setting_t *setting, const struct key *table, const char *where,
                              const char *const *skip, void *target)
{
    for (int k = 0; k < config_setting_length(setting); k++) {
        const config_setting_t *member = config_setting_get_elem(setting, (unsigned)k);
        const char *name = config_setting_name(member);
        bool skipped = false;
        for (int s = 0; skip && skip[s]; s++)
            skipped = skipped || strcmp(skip[s], name) == 0;
        if (skipped)
            continue;
        char path[256];
        snprintf(path, sizeof path, "%s%s%s", where, where[0] ? "." : "", name);
        const struct key *key = table_find(table, name);
        if (!key) {
            char allowed[400];
            unknown_key_text(table, allowed, sizeof allowed);
            return config_fail(member, path, "unknown key; allowed here: %s", allowed);
        }
        TRY(read_value(member, key, path, field(target, key)));
    }
    return STATUS_OK;
}

enum status config_require(const config_setting_t *setting, const struct key *table, const char *where)
{
    for (const struct key *key = table; key->name; key++) {
        const config_setting_t *member = setting ? config_setting_get_member(setting, key->name) : NULL;
        char path[256];
        snprintf(path, sizeof path, "%s%s%s", where, where[0] ? "." : "", key->name);
        if (key->type == KEY_GROUP) {
            TRY(config_require(member, key->group, path));
            continue;
        }
        if (!key->preset && !member)
            return status_fail(STATUS_CONFIG, "%s:%u: %s: missing; %s%s%s", source_name,
                               setting ? config_setting_source_line(setting) : 0, path, key->doc,
                               key->unit ? ", in " : "", key->unit ? key->unit : "");
    }
    return STATUS_OK;
}

/* The text as a libconfig assignment to "v", to be freed: bare words become strings. */
static enum status assignment_text(const char *value, char **text)
{
    bool word = isalpha((unsigned char)value[0]) && strcmp(value, "true") != 0 && strcmp(value, "false") != 0;
    size_t size = strlen(value) + 16;
    char *raw = malloc(size);
    if (!raw)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    snprintf(raw, size, word ? "v = \"%s\";" : "v = %s;", value);
    enum status status = config_literals(raw, NULL, text);
    free(raw);
    return status;
}

static enum status setting_copy_value(config_setting_t *parent, const char *name, const config_setting_t *from)
{
    config_setting_t *to = config_setting_add(parent, name, config_setting_type(from));
    if (!to)
        return status_fail(STATUS_CONFIG, "--set: '%s' cannot be set here", name ? name : "list member");
    switch (config_setting_type(from)) {
    case CONFIG_TYPE_INT:
        config_setting_set_int(to, config_setting_get_int(from));
        break;
    case CONFIG_TYPE_INT64:
        config_setting_set_int64(to, config_setting_get_int64(from));
        break;
    case CONFIG_TYPE_FLOAT:
        config_setting_set_float(to, config_setting_get_float(from));
        break;
    case CONFIG_TYPE_BOOL:
        config_setting_set_bool(to, config_setting_get_bool(from));
        break;
    case CONFIG_TYPE_STRING:
        config_setting_set_string(to, config_setting_get_string(from));
        break;
    default: /* group, array, list */
        for (int k = 0; k < config_setting_length(from); k++) {
            const config_setting_t *member = config_setting_get_elem(from, (unsigned)k);
            TRY(setting_copy_value(to, config_setting_name(member), member));
        }
    }
    return STATUS_OK;
}

/* Sets member `part` of a list or array, which must be there and of the same kind. */
static enum status member_set(config_setting_t *list, const char *part, const config_setting_t *from,
                              const char *assignment)
{
    config_setting_t *to = config_setting_get_elem(list, (unsigned)strtoul(part, NULL, 10));
    int type = to ? config_setting_type(to) : CONFIG_TYPE_NONE, set = CONFIG_FALSE;
    if (type == CONFIG_TYPE_FLOAT && is_number(from))
        set = config_setting_set_float(to, number_of(from));
    else if (type == CONFIG_TYPE_INT && config_setting_type(from) == type)
        set = config_setting_set_int(to, config_setting_get_int(from));
    else if (type == CONFIG_TYPE_STRING && config_setting_type(from) == type)
        set = config_setting_set_string(to, config_setting_get_string(from));
    if (set == CONFIG_TRUE)
        return STATUS_OK;
    return status_fail(STATUS_CONFIG, "--set '%s': the list has no member '%s' of this kind", assignment, part);
}

/* The child `part` of `parent`, by name or by number in a list; a missing group is made. */
static config_setting_t *descend(config_setting_t *parent, const char *part)
{
    if (isdigit((unsigned char)part[0]))
        return config_setting_get_elem(parent, (unsigned)strtoul(part, NULL, 10));
    config_setting_t *child = config_setting_get_member(parent, part);
    return child ? child : config_setting_add(parent, part, CONFIG_TYPE_GROUP);
}

enum status config_override(config_t *config, const char *assignment)
{
    char path[256];
    const char *equals = strchr(assignment, '=');
    if (!equals || equals == assignment || (size_t)(equals - assignment) >= sizeof path)
        return status_fail(STATUS_USAGE, "--set '%s': expected key=value, e.g. material.kc_n_per_m=5e4", assignment);
    snprintf(path, sizeof path, "%.*s", (int)(equals - assignment), assignment);

    config_setting_t *parent = config_root_setting(config);
    char *part = path;
    for (char *dot = strchr(part, '.'); dot; dot = strchr(part, '.')) {
        *dot = '\0';
        parent = descend(parent, part);
        if (!parent || !config_setting_is_aggregate(parent))
            return status_fail(STATUS_CONFIG, "--set '%s': there is no '%.*s' in the scene", assignment,
                               (int)(dot - path), assignment);
        part = dot + 1;
    }

    char *text;
    TRY(assignment_text(equals + 1, &text));
    config_t value;
    config_init(&value);
    int read = config_read_string(&value, text);
    free(text);
    if (read != CONFIG_TRUE || config_setting_length(config_root_setting(&value)) != 1) {
        config_destroy(&value);
        return status_fail(STATUS_USAGE, "--set '%s': '%s' is not a value in libconfig syntax", assignment, equals + 1);
    }
    enum status status = STATUS_OK;
    if (config_setting_is_group(parent)) {
        if (config_setting_get_member(parent, part))
            (void)config_setting_remove(parent, part);
        status = setting_copy_value(parent, part, config_lookup(&value, "v"));
    } else {
        status = member_set(parent, part, config_lookup(&value, "v"), assignment);
    }
    config_destroy(&value);
    return status;
}

/* %.17g with a point or exponent, so that libconfig reads a float. */
static void print_float(FILE *out, double value)
{
    char text[40];
    snprintf(text, sizeof text, "%.17g", value);
    fprintf(out, strpbrk(text, ".en") ? "%s" : "%s.0", text);
}

static void print_string(FILE *out, const char *text)
{
    fputc('"', out);
    for (; *text; text++) {
        if (*text == '"' || *text == '\\')
            fputc('\\', out);
        fputc(*text, out);
    }
    fputc('"', out);
}

static void print_numbers(FILE *out, int64_t count, const double *value)
{
    fprintf(out, "[");
    for (int64_t k = 0; k < count; k++) {
        fprintf(out, k ? ", " : "");
        print_float(out, value[k]);
    }
    fprintf(out, "]");
}

static void print_value(FILE *out, const struct key *key, const void *value)
{
    const struct config_floats *list = value;
    const struct config_band *band = value;
    switch (key->type) {
    case KEY_BOOL:
        fprintf(out, "%s", *(const bool *)value ? "true" : "false");
        break;
    case KEY_INT:
        fprintf(out, "%lldL", (long long)*(const int64_t *)value);
        break;
    case KEY_FLOAT:
        if (key->choices && isnan(*(const double *)value))
            print_string(out, key->choices[0]);
        else
            print_float(out, *(const double *)value);
        break;
    case KEY_STRING:
        print_string(out, value);
        break;
    case KEY_CHOICE:
        print_string(out, key->choices[*(const int *)value]);
        break;
    case KEY_FLOATS:
        print_numbers(out, list->count, list->value);
        break;
    case KEY_BAND:
        print_numbers(out, band->count, band->value);
        break;
    case KEY_GROUP:
        break;
    }
}

static bool same_value(const struct key *key, const void *a, const void *b)
{
    switch (key->type) {
    case KEY_BOOL:
        return *(const bool *)a == *(const bool *)b;
    case KEY_INT:
        return *(const int64_t *)a == *(const int64_t *)b;
    case KEY_FLOAT:
        return memcmp(a, b, sizeof(double)) == 0;
    case KEY_STRING:
        return strcmp(a, b) == 0;
    case KEY_CHOICE:
        return *(const int *)a == *(const int *)b;
    case KEY_FLOATS:
        return memcmp(a, b, sizeof(struct config_floats)) == 0;
    case KEY_BAND:
        return memcmp(a, b, sizeof(struct config_band)) == 0;
    case KEY_GROUP: /* by its members */
        break;
    }
    return false;
}

/* Of a group within a struct. */
static struct config_print print_within(struct config_print what, const struct key *key)
{
    return (struct config_print){.base = what.base ? field_const(what.base, key) : NULL, .applies = what.applies};
}

static bool any_printed(const struct key *table, const void *target, struct config_print what);

static bool is_printed(const struct key *table, const struct key *key, const void *target, struct config_print what)
{
    const void *value = field_const(target, key);
    if (key->type == KEY_GROUP)
        return any_printed(key->group, value, print_within(what, key));
    return !what.base || !same_value(key, value, field_const(what.base, key)) ||
           (what.applies && what.applies(table, key, target));
}

static bool any_printed(const struct key *table, const void *target, struct config_print what)
{
    for (const struct key *key = table; key->name; key++)
        if (is_printed(table, key, target, what))
            return true;
    return false;
}

void config_print(FILE *out, const struct key *table, const void *target, struct config_print what, int indent)
{
    for (const struct key *key = table; key->name; key++) {
        const void *value = field_const(target, key);
        if (!is_printed(table, key, target, what))
            continue;
        fprintf(out, "%*s%s = ", indent, "", key->name);
        if (key->type == KEY_GROUP) {
            fprintf(out, "{\n");
            config_print(out, key->group, value, print_within(what, key), indent + 2);
            fprintf(out, "%*s}", indent, "");
        } else {
            print_value(out, key, value);
        }
        fprintf(out, ";\n");
    }
}

static void print_allowed(FILE *out, const struct key *key)
{
    char text[256];
    switch (key->type) {
    case KEY_BOOL:
        fprintf(out, "true, false");
        break;
    case KEY_CHOICE:
        choices_text(key, text, sizeof text);
        fprintf(out, "%s", text);
        break;
    case KEY_STRING:
        fprintf(out, "text");
        break;
    default:
        if (key->type == KEY_FLOAT && key->choices)
            fprintf(out, "\"%s\" or ", key->choices[0]);
        fprintf(out, "%s%s",
                key->type == KEY_FLOATS ? "list; each "
                : key->type == KEY_BAND ? "number or [low, high]; "
                : key->type == KEY_INT  ? "integer; "
                                        : "",
                range_text(key, text, sizeof text));
    }
}

/* The group of the same keys that stands before this one. */
static const struct key *group_twin(const struct key *table, const struct key *group)
{
    for (const struct key *key = table; key != group; key++)
        if (key->type == KEY_GROUP && key->group == group->group)
            return key;
    return NULL;
}

int config_overlay(const struct key *table, const void *from, void *to)
{
    int taken = 0;
    for (const struct key *key = table; key->name; key++) {
        const double value = *(const double *)field_const(from, key);
        if (isnan(value))
            continue;
        *(double *)field(to, key) = value;
        taken++;
    }
    return taken;
}

void config_print_reference(FILE *out, const struct key *table, const char *path)
{
    for (const struct key *key = table; key->name; key++) {
        char full[256];
        snprintf(full, sizeof full, "%s%s%s", path, path[0] ? "." : "", key->name);
        const struct key *twin = key->type == KEY_GROUP ? group_twin(table, key) : NULL;
        if (twin) {
            fprintf(out, "| `%s` | as `%s%s%s` | | %s |\n", full, path, path[0] ? "." : "", twin->name, key->doc);
            continue;
        }
        if (key->type == KEY_GROUP) {
            config_print_reference(out, key->group, full);
            continue;
        }
        fprintf(out, "| `%s` | ", full);
        print_allowed(out, key);
        const char *preset = key->preset;
        if (!preset)
            fprintf(out, " | *required* | %s |\n", key->doc);
        else if (!preset[0])
            fprintf(out, " | none | %s |\n", key->doc);
        else
            fprintf(out, " | %s | %s |\n", preset, key->doc);
    }
}
