/* Which fields of the messages become columns of run.h5, with their units: a new field of a message is one line in
 * message_columns.c. */
#ifndef SHAKEDOWN_RECORDER_MESSAGE_COLUMNS_H
#define SHAKEDOWN_RECORDER_MESSAGE_COLUMNS_H

#include <stddef.h>

enum field_type { FIELD_I8, FIELD_I32, FIELD_I64, FIELD_F64 };

/* Values per message: one, or the length of the array behind a pointer, D the dimension. */
enum field_width { WIDTH_ONE, WIDTH_AXES /* D */, WIDTH_TENSOR /* D*D */, WIDTH_WALLS /* 2 D */ };

struct field {
    const char *name; /* of the field and of its column; NULL ends a list */
    const char *unit;
    size_t offset; /* in the generated struct: of the value, or of the pointer to the values if width is not one */
    enum field_type type;
    enum field_width width;
};

extern const struct field sample_fields[]; /* step and time_s first */
extern const struct field wall_state_fields[];
extern const struct field wall_command_fields[];

#endif
