/* What is in a checkpoint: one table of members drives saving, loading and comparing. */
#ifndef SHAKEDOWN_SIM_RUN_CHECKPOINT_ITEMS_H
#define SHAKEDOWN_SIM_RUN_CHECKPOINT_ITEMS_H

#include "sim/run/checkpoint_file.h"
#include "sim/run/run_progress.h"
#include "sim/sample/sample.h"

/* One dataset. */
struct checkpoint_item {
    char path[64];
    enum checkpoint_type type;
    size_t count;
    void *data;
    bool late;
    int columns;               /* of the blocks that the values stand in (particles.h); 1: one after the other */
    struct contact_list *list; /* whose column of the history this is: checkpoint_item_read; NULL: none */
    int column;
};

enum { CHECKPOINT_ITEMS_MAX = 512 };
struct checkpoint_items {
    int n;
    struct checkpoint_item item[CHECKPOINT_ITEMS_MAX];
};

/* Every item of a run, whose last step is completed; `progress` NULL: of the sample alone. To be freed; NULL: no
 * memory. */
struct checkpoint_items *checkpoint_items_of(struct sample *sample, struct run_progress *progress);

/* What contacts remember comes to `data` when it is asked for, and may leave it then: a large sample's memory does not
 * hold all of it twice. */
void checkpoint_item_read(const struct checkpoint_item *item);
void checkpoint_item_forget(const struct checkpoint_item *item);

/* Whether two items of one path hold the same bits. */
bool checkpoint_item_equal(const struct checkpoint_item *a, const struct checkpoint_item *b);

/* Values that stand in blocks: one after the other, to be freed (NULL: no memory); and to where they stand. */
void *checkpoint_item_gather(const struct checkpoint_item *item);
void checkpoint_item_scatter(const struct checkpoint_item *item, const void *values);

/* List l of contacts (sample_list) and the group of its items. */
struct contact_list *checkpoint_list(struct sample *sample, int l);
void checkpoint_list_group(char group[32], int l);

#endif
