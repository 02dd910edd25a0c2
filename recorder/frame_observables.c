#include "recorder/frame_observables.h"

#include <stdlib.h>

static enum status add(struct moments *moments, struct moment moment)
{
    if (moments->n == moments->room) {
        const int64_t room = moments->room > 0 ? 2 * moments->room : 256;
        struct moment *grown = realloc(moments->at, (size_t)room * sizeof *grown);
        if (!grown)
            return status_fail(STATUS_NO_MEMORY, "no memory for %lld moments", (long long)room);
        moments->at = grown;
        moments->room = room;
    }
    moments->at[moments->n++] = moment;
    return STATUS_OK;
}

enum status frame_observables_sample(struct frame_observables *observed, struct moment moment)
{
    return add(&observed->samples, moment);
}

enum status frame_observables_frame(struct frame_observables *observed, struct moment moment)
{
    return add(&observed->frames, moment);
}

/* At a stage's end there are a sample and a frame of either stage at one step. */
static bool is_after(struct moment a, struct moment b)
{
    return a.step > b.step || (a.step == b.step && a.stage > b.stage);
}

bool frame_observables_next(struct frame_observables *observed, bool last, int64_t *sample)
{
    const struct moments *samples = &observed->samples;
    if (observed->next == observed->frames.n || samples->n == 0)
        return false;
    const struct moment frame = observed->frames.at[observed->next];
    while (observed->near < samples->n && !is_after(samples->at[observed->near], frame))
        observed->near++;
    const int64_t found = observed->near > 0 ? observed->near - 1 : 0;
    const bool is_its_own = samples->at[found].step == frame.step && samples->at[found].stage == frame.stage;
    if (!last && !is_its_own && observed->near == samples->n)
        return false;
    observed->next++;
    *sample = found;
    return true;
}

void frame_observables_free(struct frame_observables *observed)
{
    free(observed->samples.at);
    free(observed->frames.at);
    *observed = (struct frame_observables){0};
}
