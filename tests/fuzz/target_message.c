/* Messages: any bytes as any kind. The first byte says which. */
#include <stdlib.h>

#include "common/coupling.h"
#include "common/message.h"
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    union message message;
    struct message_header header;
    struct wall_state state;
    struct wall_command command;
    if (size < 1)
        return 0;
    const int kind = data[0] % MESSAGE_KINDS;
    uint8_t *own = malloc(size); /* a block of just that length, so that reading past its end is seen */
    if (!own)
        return 0;
    for (size_t k = 1; k < size; k++)
        own[k - 1] = data[k];
    if (message_decode(kind, own, size - 1, &message) == STATUS_OK)
        message_free(kind, &message);
    (void)wall_state_decode(own, size - 1, &header, &state);
    (void)wall_command_decode(own, size - 1, &header, &command);
    free(own);
    return 0;
}
