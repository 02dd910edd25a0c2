#include "analyzer/quantity.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

static const char *const keys[QUANTITIES] = {
#define QUANTITY_KEY(id, key, unit, tests) key,
    QUANTITY_LIST(QUANTITY_KEY)
#undef QUANTITY_KEY
};

static const char *const units[QUANTITIES] = {
#define QUANTITY_UNIT(id, key, unit, tests) unit,
    QUANTITY_LIST(QUANTITY_UNIT)
#undef QUANTITY_UNIT
};

const char *quantity_key(enum quantity_id id)
{
    return keys[id];
}

const char *quantity_unit(enum quantity_id id)
{
    return units[id];
}

bool quantity_belongs(enum quantity_id id, enum test_kind kind)
{
    static const unsigned tests_of[QUANTITIES] = {
#define QUANTITY_TESTS(id, key, unit, tests) TESTS_##tests,
        QUANTITY_LIST(QUANTITY_TESTS)
#undef QUANTITY_TESTS
    };
    return (tests_of[id] >> kind & 1) != 0;
}

bool quantity_is_reported(enum quantity_id id, enum test_kind kind, const struct quantity *quantity)
{
    return quantity_belongs(id, kind) && !quantity->absent;
}

void quantity_undefined(struct quantity *quantity, const char *format, ...)
{
    va_list arguments;
    *quantity = (struct quantity){.value = NAN, .uncertainty = NAN};
    va_start(arguments, format);
    vsnprintf(quantity->text, sizeof quantity->text, format, arguments);
    va_end(arguments);
}

void quantity_absent(struct quantity *quantity, const char *reason)
{
    quantity_undefined(quantity, "%s", reason);
    quantity->absent = true;
}

void quantity_set(struct quantity *quantity, struct estimate estimate)
{
    if (!isfinite(estimate.value)) {
        quantity_undefined(quantity, "not a finite number");
        return;
    }
    *quantity = (struct quantity){.value = estimate.value, .uncertainty = estimate.error};
}

void quantity_window(struct quantity *quantity, double a, double b)
{
    quantity->has_window = true;
    quantity->window[0] = a;
    quantity->window[1] = b;
}

void quantity_note(struct quantity *quantity, const char *format, ...)
{
    va_list arguments;
    if (isnan(quantity->value)) /* keep the reason */
        return;
    va_start(arguments, format);
    vsnprintf(quantity->text, sizeof quantity->text, format, arguments);
    va_end(arguments);
}
