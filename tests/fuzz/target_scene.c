/* Scenes: any text. What is taken must be taken again in the form in which it is recorded. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/scene_file.h"
#include "fuzz.h"

static char *printed(const struct scene *scene)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return NULL;
    scene_print(out, scene);
    return fclose(out) == 0 ? text : NULL;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static struct scene scene;
    char *text = malloc(size + 1);
    if (!text)
        return 0;
    memcpy(text, data, size);
    text[size] = '\0';
    if (scene_parse(&scene, text, "fuzz") == STATUS_OK) {
        char *again = printed(&scene);
        scene_free(&scene);
        if (again && scene_parse(&scene, again, "again") != STATUS_OK) {
            fprintf(stderr, "not taken again: %s\n", status_message());
            abort();
        }
        if (again)
            scene_free(&scene);
        free(again);
    }
    free(text);
    return 0;
}
