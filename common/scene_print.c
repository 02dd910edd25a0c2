#include <stdlib.h>
#include <string.h>

#include "common/scene.h"
#include "common/scene_keys.h"

static void stage_print(FILE *out, const struct scene_stage *stage, struct config_print what, bool more)
{
    struct scene_stage named = *stage;
    named.name[named.name_length] = '\0';
    fprintf(out, "  {\n");
    config_print(out, scene_stage_keys, &named, what, 4);
    fprintf(out, "  }%s\n", more ? "," : "");
}

static void group_print(FILE *out, const struct scene_stage *first, struct config_print what, bool more)
{
    fprintf(out, "  {\n    repeat = %lldL;\n    stages = (\n", (long long)first->repeat);
    for (int64_t k = 0; k < first->group_length; k++)
        stage_print(out, first + k, what, k + 1 < first->group_length);
    fprintf(out, "    );\n  }%s\n", more ? "," : "");
}

static void stages_print(FILE *out, const struct scene *scene, struct config_print what)
{
    fprintf(out, "stages = (\n");
    for (int64_t k = 0; k < scene->n_stages;) {
        const struct scene_stage *first = &scene->stage[k];
        if (first->repeat > 0) {
            const int64_t next = k + first->repeat * first->group_length;
            group_print(out, first, what, next < scene->n_stages);
            k = next;
        } else {
            stage_print(out, first, what, ++k < scene->n_stages);
        }
    }
    fprintf(out, ");\n");
}

void scene_print(FILE *out, const struct scene *scene)
{
    struct scene preset = {0};
    struct scene_stage start = {0};
    config_defaults(scene_keys, &preset);
    scene_stage_start(scene, &start);
    config_print(out, scene_keys, scene, (struct config_print){&preset, scene_key_applies}, 0);
    stages_print(out, scene, (struct config_print){&start, stage_key_applies});
}

void scene_print_every_key(FILE *out, const struct scene *scene)
{
    config_print(out, scene_keys, scene, (struct config_print){0}, 0);
    stages_print(out, scene, (struct config_print){0});
}

void scene_print_reference(FILE *out)
{
    static const char header[] = "| key | allowed | default | meaning |\n|---|---|---|---|\n";
    fprintf(
        out,
        "# Scene reference\n\nMade by `sim --reference` from the table of keys in `common/scene.c`: do not edit.\n\n"
        "A scene is a libconfig file, at most 24 kB. An unknown key is an error. Integers are taken where a number is "
        "asked for; a number that cannot be held is refused. `@include` is not taken. "
        "Compression is positive in stress and strain.\nSources: [LH] Luding & Herrmann (2001), [D] David et al. "
        "(2007), see `theory.md`.\n\n## Scene\n\n`material`, `walls` and `limits` hold for every stage that does not "
        "say "
        "otherwise.\n\n%s",
        header);
    config_print_reference(out, scene_keys, "");
    fprintf(
        out,
        "\n## Stages\n\n`stages = ( { ... }, { ... } )`, run in order. A stage takes its `material`, `walls` and "
        "`limits` "
        "from the scene and overrides key by key. A member of the list may be a group of stages, run `repeat` times: "
        "`{ repeat = 20; stages = ( { ... }, { ... } ); }`; the stages of its passes are called NAME.1, NAME.2, … "
        "At most %d stages in all.\n\n%s",
        SCENE_STAGES_MAX, header);
    config_print_reference(out, scene_stage_keys, "");
    fprintf(out,
            "\n## Preparation\n\n`prepare = { to = \"dense\"; pressure_pa = 1e5; };` stands for two stages before the "
            "others, `prepare-compress` and `prepare-settle`, which are recorded as stages like any others and which "
            "`./shakedown explain` prints: to be copied, and changed, where they do not fit.\n\n%s",
            header);
    config_print_reference(out, scene_prepare_keys, "");
}
