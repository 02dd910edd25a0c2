#include "wallctl/coupled_axes.h"

#include <math.h>
#include <string.h>

#include "common/pressure_target.h"

double walls_area_m2(const struct wall_state *state, int pair)
{
    double area_m2 = 1;
    for (int other = 0; other < state->n_walls / 2; other++)
        if (other != pair)
            area_m2 *= state->position_m[2 * other + 1] - state->position_m[2 * other];
    return area_m2;
}

double walls_stress_pa(const struct wall_state *state, int pair)
{
    return 0.5 * (state->force_n[2 * pair] + state->force_n[2 * pair + 1]) / walls_area_m2(state, pair);
}

double walls_mean_stress_pa(const struct wall_state *state)
{
    const int pairs = state->n_walls / 2;
    double sum_pa = 0;
    for (int pair = 0; pair < pairs; pair++)
        sum_pa += walls_stress_pa(state, pair);
    return sum_pa / pairs;
}

double walls_deviator_pa(const struct wall_state *state)
{
    const int axial = state->n_walls / 2 - 1;
    double lateral_pa = 0;
    for (int pair = 0; pair < axial; pair++)
        lateral_pa += walls_stress_pa(state, pair);
    return walls_stress_pa(state, axial) - lateral_pa / axial;
}

bool axis_keeps_volume(const struct scene_axis *axis)
{
    return axis->mode == WALL_COUPLED && axis->keep == KEEP_VOLUME;
}

bool axis_has_loop(const struct scene_axis *axis)
{
    return axis->mode == WALL_STRESS || (axis->mode == WALL_COUPLED && axis->keep != KEEP_VOLUME);
}

/* Linear equations in the stresses of the pairs. */
struct equations {
    int n;
    double row[SCENE_AXES][SCENE_AXES + 1]; /* coefficients and right side */
};

/* What is kept, as an equation; of two axes that keep the same the second one's is that they have equal stresses. */
static void kept_equation(const struct scene_axis *axis, double t_s, int pairs, int pair, int first_alike, double *row)
{
    const int axial = pairs - 1;
    if (first_alike >= 0) {
        row[pair] = 1;
        row[first_alike] = -1;
        return;
    }
    switch (axis->keep) {
    case KEEP_P:
        for (int k = 0; k < pairs; k++)
            row[k] = 1.0 / pairs;
        row[pairs] = pressure_target_pa(axis, t_s);
        break;
    case KEEP_Q:
        for (int k = 0; k < pairs; k++)
            row[k] = k == axial ? 1.0 : -1.0 / axial;
        row[pairs] = pressure_target_pa(axis, t_s);
        break;
    case KEEP_PATH:
        for (int k = 0; k < pairs; k++)
            row[k] = (k == axial ? 1.0 : -1.0 / axial) - axis->dq_dp / pairs;
        row[pairs] = axis->deviator_pa - axis->dq_dp * axis->pressure_pa;
        break;
    default: /* KEEP_B: the axis is y */
        row[0] = axis->b - 1;
        row[1] = 1;
        row[2] = -axis->b;
    }
}

static void rows_swap(struct equations *e, int a, int b)
{
    double row[SCENE_AXES + 1];
    memcpy(row, e->row[a], sizeof row);
    memcpy(e->row[a], e->row[b], sizeof row);
    memcpy(e->row[b], row, sizeof row);
}

/* Gauss-Jordan with row pivots; false if there is no one solution. */
static bool solve(struct equations *e, double *x)
{
    for (int c = 0; c < e->n; c++) {
        int pivot = c;
        for (int r = c + 1; r < e->n; r++)
            if (fabs(e->row[r][c]) > fabs(e->row[pivot][c]))
                pivot = r;
        if (!(fabs(e->row[pivot][c]) > 1e-9)) /* coefficients are of size 1 */
            return false;
        rows_swap(e, c, pivot);
        for (int r = 0; r < e->n; r++) {
            const double factor = e->row[r][c] / e->row[c][c];
            for (int k = c; r != c && k <= e->n; k++)
                e->row[r][k] -= factor * e->row[c][k];
        }
    }
    for (int c = 0; c < e->n; c++)
        x[c] = e->row[c][e->n] / e->row[c][c];
    return true;
}

enum status coupled_targets(const struct scene *scene, const struct scene_stage *stage, const struct wall_state *state,
                            double t_s, double target_pa[SCENE_AXES])
{
    const int pairs = state->n_walls / 2;
    struct equations equations = {.n = pairs};
    int p_or_path = -1, coupled = 0;
    for (int pair = 0; pair < pairs; pair++) {
        const struct scene_axis *axis = &stage->axis[scene_pair_axis(scene, pair)];
        double *row = equations.row[pair];
        if (axis->mode == WALL_COUPLED && axis_has_loop(axis)) {
            const bool alike = axis->keep == KEEP_P || axis->keep == KEEP_PATH;
            kept_equation(axis, t_s, pairs, pair, alike ? p_or_path : -1, row);
            p_or_path = alike && p_or_path < 0 ? pair : p_or_path;
            coupled++;
        } else {
            row[pair] = 1;
            row[pairs] = walls_stress_pa(state, pair);
        }
    }
    if (coupled > 0 && !solve(&equations, target_pa))
        return status_fail(STATUS_CONFIG, "stage \"%s\": what its coupled axes keep does not say their stresses",
                           stage->name);
    for (int pair = 0; pair < pairs; pair++) {
        const struct scene_axis *axis = &stage->axis[scene_pair_axis(scene, pair)];
        if (axis->mode == WALL_STRESS)
            target_pa[pair] = pressure_target_pa(axis, t_s);
        else if (coupled == 0)
            target_pa[pair] = walls_stress_pa(state, pair);
    }
    return STATUS_OK;
}

struct coupled_length coupled_length(const bool *keeps_volume, int pairs, int pair, const double *start_m,
                                     const double *length_m, const double *rate_m_per_s)
{
    double shrink = 1, rate_per_s = 0; /* of the others together */
    int alike = 0;
    for (int k = 0; k < pairs; k++) {
        alike += keeps_volume[k];
        if (keeps_volume[k])
            continue;
        shrink *= start_m[k] / length_m[k];
        rate_per_s += rate_m_per_s[k] / length_m[k];
    }
    const double length = start_m[pair] * (alike == 2 ? sqrt(shrink) : shrink);
    return (struct coupled_length){length, -length * rate_per_s / alike};
}
