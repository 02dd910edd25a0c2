#include "sim/sample/stage.h"

#include <math.h>
#include <string.h>

#include "sim/sample/contact_state.h"
#include "sim/sample/coupling_audit.h"
#include "sim/sample/energy.h"
#include "sim/sample/step_completion.h"
#include "sim/sample/time_step.h"
#include "sim/sample/wall_motion.h"

/* The stiffness of contacts under the largest pressure of the stage, with a force of four times the mean. */
static void set_scale(struct sample *sample)
{
    const struct particles *p = &sample->particles;
    const struct scene_stage *stage = &sample->scene->stage[sample->stage];
    double radius = 0, pressure = 0;
    for (int i = 0; i < p->count; i++)
        radius += p->radius[i] / p->count;
    for (int k = 0; k < SCENE_AXES; k++)
        pressure = fmax(pressure, fmax(fabs(stage->axis[k].pressure_pa) + fabs(stage->axis[k].amplitude_pa),
                                       fabs(stage->axis[k].pressure_end_pa)));
    const double area = p->dimension == 2 ? 2 * radius : 4 * radius * radius;
    contact_law_set_scale(&sample->law, sample->pairs.model.normal, radius, 4 * pressure * area);
    for (int c = 0; c < p->dimension; c++)
        contact_law_set_scale(&sample->wall_law[c], sample->pairs.model.normal, radius, 4 * pressure * area);
}

void sample_set_law(struct sample *sample)
{
    sample->material = sample->stage < 0 ? NULL : &sample->scene->stage[sample->stage].material;
    if (sample->material) {
        sample->law = contact_law_constants_of(sample->material, sample->pairs.model.normal);
        for (int c = 0; c < sample->particles.dimension; c++)
            sample->wall_law[c] = contact_law_constants_of_walls(&sample->scene->stage[sample->stage],
                                                                 sample_axis(sample, c), sample->pairs.model.normal);
        set_scale(sample);
        sample->particles.springs = sample->law.springs;
        for (int c = 0; c < sample->particles.dimension; c++)
            sample->particles.springs = sample->particles.springs || sample->wall_law[c].springs;
        coupling_audit_set_law(sample);
    }
}

static const struct contact_law_constants *law_of_list(const struct sample *sample, int l)
{
    return l == 0 ? &sample->law : &sample->wall_law[(l - 1) / 2];
}

/* Whether contacts of this law have what is kept in column c of the history of friction. */
static bool has_spring(const struct contact_law_constants *law, int c)
{
    if (c >= HISTORY_TORSION)
        return law->torsion.k > 0;
    return c >= HISTORY_ROLLING ? law->rolling.k > 0 : law->springs;
}

static bool has_springs(const struct sample *sample)
{
    bool all = true;
    for (int l = 0; l <= sample->n_walls; l++)
        for (int c = HISTORY_SPRING; c < HISTORY_COLUMNS; c++)
            all = all && (!history_has(&sample->pairs.model, c) || has_spring(law_of_list(sample, l), c));
    return all;
}

static struct contact_list *list_of(struct sample *sample, int l)
{
    return l == 0 ? &sample->pairs : &sample->walls[l - 1].contacts;
}

/* In a stage whose friction has no springs, or that has no friction, contacts remember none. */
static enum status forget_friction(struct sample *sample)
{
    for (int l = 0; l <= sample->n_walls; l++) {
        struct contact_list *list = list_of(sample, l);
        contact_list_read(list);
        for (int c = HISTORY_SPRING; c < HISTORY_COLUMNS; c++)
            if (list->history[c] && list->count && c != HISTORY_CONTACT_RADIUS &&
                !has_spring(law_of_list(sample, l), c))
                memset(list->history[c], 0, (size_t)list->count * sizeof(double));
    }
    return sample_close_lists(sample);
}

static void set_spring(struct contact_list *list, int c, int rest, int k, double now)
{
    const double unit =
        history_field(c)->force ? list->slots.force_unit : 1; /* in which the slots have it as a float */
    list->history[c][k] = list->model.mixed ? unit * (float)(now / unit) : now;
    if (list->model.mixed)
        list->history[rest][k] = now - list->history[c][k];
}

/* Springs (Mindlin: forces) of contact k of list l as they are now. */
static void settle_spring(struct complete_sample whole, struct contact_list *list, int l, int k)
{
    const bool mindlin = list->model.traits & NORMAL_MINDLIN;
    const int first = mindlin ? HISTORY_FORCE : HISTORY_SPRING,
              rest = mindlin ? HISTORY_FORCE_REST : HISTORY_SPRING_REST;
    struct contact_geometry g;
    struct contact_forces f;
    if (!contact_state_at(whole, l, k, &g, &f))
        return;
    const struct contact_law_constants *law = law_of_list(whole.sample, l);
    for (int c = 0; c < contact_model_springs(&list->model); c++) {
        set_spring(list, first + c, rest + c, k, f.spring[c] * (mindlin ? 1 : law->inv_kt));
        if (list->model.rolling)
            set_spring(list, HISTORY_ROLLING + c, HISTORY_ROLLING_REST + c, k, f.rolling[c] * law->rolling.inv_k);
    }
    if (history_has(&list->model, HISTORY_TORSION))
        set_spring(list, HISTORY_TORSION, HISTORY_TORSION_REST, k, f.torsion * law->torsion.inv_k);
}

enum status stage_settle_springs(struct sample *sample)
{
    const struct complete_sample whole = sample_complete(sample);
    if (sample->pairs.model.frictional && sample->kicked_s > 0) {
        for (int l = 0; l <= sample->n_walls; l++) {
            struct contact_list *list = list_of(sample, l);
            contact_list_read(list);
            for (int k = 0; k < list->count && law_of_list(sample, l)->springs; k++)
                settle_spring(whole, list, l, k);
        }
        TRY(sample_close_lists(sample));
    }
    sample->kicked_s = 0;
    return STATUS_OK;
}

static enum status stage_start(struct sample *sample, int stage)
{
    TRY(stage_settle_springs(sample));
    const bool first = sample->stage < 0; /* no law so far */
    const struct scene_stage *next = &sample->scene->stage[stage];
    sample->stage = stage;
    sample->stage_step = 0;
    sample->stage_time_start_s = sample->time_s;
    sample->dt = next->dt_s;
    const double elastic_before = energy_held(sample_complete(sample)).elastic_j; /* with the material of before */
    sample_set_law(sample);
    if (sample->pairs.model.frictional && !has_springs(sample))
        TRY(forget_friction(sample));
    for (int w = 0; w < sample->n_walls; w++)
        sample->stage_position_m[w] = sample->walls[w].x;
    time_step_forces_anew(sample);
    sample->ledger = energy_ledger_start(sample_complete(sample));
    if (!first) {
        sample->ledger.work_material = sample->ledger.elastic_start - elastic_before;
        sample->ledger.elastic_start = elastic_before;
    }
    coupling_audit_stage_start(sample);
    return STATUS_OK;
}

enum status sample_command(struct sample *sample, const struct wall_command *command)
{
    if (command->step != sample->step || command->n_walls != sample->n_walls || command->n_steps < 1)
        return status_fail(STATUS_FORMAT, "step %lld: a command for step %lld, %d walls, %d steps does not fit",
                           (long long)sample->step, (long long)command->step, command->n_walls, command->n_steps);
    if (command->stage < 0 || command->stage >= sample->scene->n_stages || command->stage < sample->stage)
        return status_fail(STATUS_FORMAT, "step %lld: a command for stage %d does not fit stage %d",
                           (long long)sample->step, command->stage, sample->stage);
    coupling_audit_close(sample, command);
    if (command->stage != sample->stage)
        TRY(stage_start(sample, command->stage));
    coupling_audit_open(sample);
    walls_take_command(sample, command);
    return STATUS_OK;
}
