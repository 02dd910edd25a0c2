#include "analyzer/stage_controls.h"

#include <math.h>

static const double kept_share = 0.02;
static const double changed_share = 0.1;

/* What an axis does, as the configuration has it. */
enum role { ROLE_REST, ROLE_STRAIN, ROLE_HELD, ROLE_STRESS, ROLE_FOLLOWS, ROLE_CYCLED };

/* The leading wall of a strain course that goes nowhere rests. */
static bool is_strained(const struct scene_axis *axis)
{
    if (axis->course == COURSE_RATE)
        return axis->rate_per_s != 0;
    return axis->course == COURSE_TABLE || axis->strain != 0;
}

static enum role role_of(const struct scene_axis *axis)
{
    if (scene_axis_period_s(axis) > 0)
        return ROLE_CYCLED;
    if (axis->mode == WALL_FIXED)
        return ROLE_REST;
    if (axis->mode == WALL_STRAIN)
        return is_strained(axis) ? ROLE_STRAIN : ROLE_REST;
    if (axis->mode == WALL_STRESS)
        return axis->target == TARGET_CONSTANT ? ROLE_HELD : ROLE_STRESS;
    /* q itself leads; an axis that keeps anything else goes where the others let it */
    return axis->keep == KEEP_Q && axis->target != TARGET_CONSTANT ? ROLE_STRESS : ROLE_FOLLOWS;
}

static bool axis_exists(int dimension, int axis)
{
    return dimension == 3 || axis != AXIS_Y;
}

int stage_controls_slot(int dimension, int axis)
{
    return dimension == 3 ? axis : (axis == AXIS_Z ? 1 : 0);
}

void stage_controls_split(const struct stage_controls *controls, int dimension, const double *vector, double *axial,
                          double *lateral)
{
    const int a = stage_controls_slot(dimension, (int)controls->axial);
    double sum = 0;
    for (int k = 0; k < dimension; k++)
        if (k != a)
            sum += vector[k];
    *axial = vector[a];
    *lateral = sum / (dimension - 1);
}

/* Axes of a role, and the one of them that leads: z if it is among them, else the last. */
static int count_role(const struct scene_stage *stage, int dimension, enum role role, int *axis)
{
    int count = 0;
    for (int k = 0; k < SCENE_AXES; k++)
        if (axis_exists(dimension, k) && role_of(&stage->axis[k]) == role) {
            count++;
            *axis = k;
        }
    return count;
}

/* All axes have one and the same stress target. */
static bool targets_alike(const struct scene_stage *stage, int dimension)
{
    const struct scene_axis *z = &stage->axis[AXIS_Z];
    for (int k = 0; k < SCENE_AXES; k++) {
        const struct scene_axis *axis = &stage->axis[k];
        if (axis_exists(dimension, k) && (axis->target != z->target || axis->pressure_pa != z->pressure_pa ||
                                          axis->pressure_end_pa != z->pressure_end_pa || axis->ramp_s != z->ramp_s))
            return false;
    }
    return true;
}

static bool strains_alike(const struct scene_stage *stage, int dimension)
{
    for (int k = 0; k < SCENE_AXES; k++)
        if (axis_exists(dimension, k) && stage->axis[k].strain != stage->axis[AXIS_Z].strain)
            return false;
    return true;
}

static double lateral_pressure(const struct stage_controls *controls, const struct scene_stage *stage, int dimension)
{
    double sum = 0;
    for (int k = 0; k < SCENE_AXES; k++) {
        const struct scene_axis *axis = &stage->axis[k];
        if (!axis_exists(dimension, k) || k == (int)controls->axial)
            continue;
        if (role_of(axis) != ROLE_HELD)
            return NAN;
        sum += axis->pressure_pa;
    }
    return sum / (dimension - 1);
}

/* Extremes over the samples of a stage. */
struct extremes {
    double volume, axial; /* largest |logarithmic strain| */
    double axial_last;    /* signed, the largest one */
    double p_low, p_high, q_low, q_high;
};

static void extremes_find(struct extremes *e, const struct stage_controls *controls, const struct run *run,
                          size_t begin, size_t end)
{
    const int d = run->dimension;
    *e = (struct extremes){0, 0, 0, INFINITY, -INFINITY, INFINITY, -INFINITY};
    for (size_t s = begin; s < end; s++) {
        const double *length = run_record(run, OBSERVABLE_BOX_LENGTH, s);
        const double *first = run_record(run, OBSERVABLE_BOX_LENGTH, begin);
        double axial, lateral, volume = 0;
        for (int k = 0; k < d; k++)
            volume -= log(length[k] / first[k]);
        const int a = stage_controls_slot(d, (int)controls->axial);
        const double strain = -log(length[a] / first[a]);
        stage_controls_split(controls, d, run_record(run, OBSERVABLE_STRESS_WALL, s), &axial, &lateral);
        e->volume = fmax(e->volume, fabs(volume));
        if (fabs(strain) > e->axial)
            e->axial_last = strain;
        e->axial = fmax(e->axial, fabs(strain));
        const double p = (axial + (d - 1) * lateral) / d, q = axial - lateral;
        e->p_low = fmin(e->p_low, p);
        e->p_high = fmax(e->p_high, p);
        e->q_low = fmin(e->q_low, q);
        e->q_high = fmax(e->q_high, q);
    }
}

static void record_read(struct stage_controls *controls, const struct scene_stage *stage, const struct run *run,
                        size_t begin, size_t end)
{
    struct extremes e;
    extremes_find(&e, controls, run, begin, end);
    const double span_p = e.p_high - e.p_low, span_q = e.q_high - e.q_low;
    controls->volume_kept = e.axial > 1e-6 && e.volume < kept_share * e.axial;
    controls->pressure_kept = e.p_high > 0 && span_p < kept_share * e.p_high && span_q > changed_share * e.p_high;
    controls->extension = begin < end ? e.axial_last < 0 : stage->axis[controls->axial].strain < 0;
    if (controls->kind == TEST_SHEAR && controls->volume_kept)
        controls->kind = TEST_CONSTANT_VOLUME;
    /* one held pressure that the sample already had */
    if (controls->kind == TEST_ISOTROPIC && e.p_high > 0 && span_p < changed_share * e.p_high)
        controls->kind = TEST_CREEP;
}

/* All axes are under stress control. */
static void stresses_read(struct stage_controls *controls, const struct scene_stage *stage, int dimension, int varying,
                          int axis)
{
    controls->stress_led = true;
    if (targets_alike(stage, dimension)) {
        controls->kind = TEST_ISOTROPIC;
    } else if (varying == 0) {
        controls->kind = TEST_CREEP;
    } else {
        controls->kind = TEST_SHEAR;
        controls->axial = (enum axis)axis;
    }
}

static void configuration_read(struct stage_controls *controls, const struct scene_stage *stage, int dimension)
{
    int axis = AXIS_Z, other = AXIS_Z;
    const int rest = count_role(stage, dimension, ROLE_REST, &other),
              held = count_role(stage, dimension, ROLE_HELD, &other);
    const int varying = count_role(stage, dimension, ROLE_STRESS, &axis);
    if (count_role(stage, dimension, ROLE_CYCLED, &axis) > 0) {
        controls->kind = TEST_CYCLIC;
        controls->axial = (enum axis)axis;
        controls->period_s = scene_axis_period_s(&stage->axis[axis]);
        controls->stress_led = stage->axis[axis].mode == WALL_STRESS;
    } else if (rest == dimension) {
        controls->kind = TEST_RELAXATION;
    } else if (varying + held == dimension) {
        stresses_read(controls, stage, dimension, varying, axis);
    } else if (count_role(stage, dimension, ROLE_STRAIN, &axis) > 0) {
        controls->axial = (enum axis)axis;
        controls->kind = rest == dimension - 1 ? TEST_OEDOMETER : TEST_SHEAR;
        if (count_role(stage, dimension, ROLE_STRAIN, &other) == dimension && strains_alike(stage, dimension))
            controls->kind = TEST_ISOTROPIC;
    } else if (varying > 0) {
        controls->axial = (enum axis)axis;
        controls->stress_led = true;
        controls->kind = rest == dimension - 1 ? TEST_OEDOMETER : TEST_SHEAR;
    } else if (held + rest == dimension) {
        const bool axial_rests = role_of(&stage->axis[AXIS_Z]) == ROLE_REST;
        controls->kind = axial_rests ? TEST_RELAXATION : TEST_CREEP;
        controls->stress_led = !axial_rests;
    }
}

/* What the pairs of walls did, as the record has it. */
struct course {
    double moved;                   /* largest |logarithmic strain| */
    double low_pa, high_pa, sum_pa; /* of the stress */
};

static void courses_find(struct course course[SCENE_AXES], const struct run *run, size_t begin, size_t end)
{
    for (int k = 0; k < run->dimension; k++) {
        course[k] = (struct course){.low_pa = INFINITY, .high_pa = -INFINITY};
        for (size_t s = begin; s < end; s++) {
            const double length = run_record(run, OBSERVABLE_BOX_LENGTH, s)[k],
                         first = run_record(run, OBSERVABLE_BOX_LENGTH, begin)[k],
                         stress_pa = run_record(run, OBSERVABLE_STRESS_WALL, s)[k];
            course[k].moved = fmax(course[k].moved, fabs(log(length / first)));
            course[k].low_pa = fmin(course[k].low_pa, stress_pa);
            course[k].high_pa = fmax(course[k].high_pa, stress_pa);
            course[k].sum_pa += stress_pa;
        }
    }
}

/* All pairs bear the same stress at each sample. */
static bool stresses_alike(const struct run *run, size_t begin, size_t end)
{
    for (size_t s = begin; s < end; s++) {
        const double *stress_pa = run_record(run, OBSERVABLE_STRESS_WALL, s);
        for (int k = 1; k < run->dimension; k++)
            if (fabs(stress_pa[k] - stress_pa[0]) > kept_share * fabs(stress_pa[0]))
                return false;
    }
    return true;
}

/* A controller of the user's own moved the walls: what the test is, the record says; the scene's targets count for
 * nothing. Cycles are not looked for. */
static void commanded_read(struct stage_controls *controls, const struct run *run, size_t begin, size_t end)
{
    struct course course[SCENE_AXES];
    const int d = run->dimension;
    int resting = 0, held = 0, held_lateral = 0, leads = d - 1;
    double lateral_pa = 0;
    if (begin == end)
        return;
    courses_find(course, run, begin, end);
    bool rests[SCENE_AXES], holds[SCENE_AXES];
    for (int k = 0; k < d; k++) {
        rests[k] = course[k].moved < 1e-9;
        holds[k] = !rests[k] && course[k].high_pa - course[k].low_pa < kept_share * course[k].high_pa;
        resting += rests[k];
        held += holds[k];
    }
    for (int k = d - 2; k >= 0 && rests[leads]; k--)
        leads = k;
    for (int k = 0; k < d; k++) {
        held_lateral += k != leads && holds[k];
        lateral_pa += k != leads ? course[k].sum_pa / (double)(end - begin) / (d - 1) : 0;
    }
    controls->axial = d == 2 && leads == 1 ? AXIS_Z : (enum axis)leads;
    controls->lateral_pressure_pa = held_lateral == d - 1 ? lateral_pa : NAN;
    if (resting == d)
        controls->kind = TEST_RELAXATION;
    else if (held + resting == d)
        controls->kind = TEST_CREEP;
    else if (stresses_alike(run, begin, end))
        controls->kind = TEST_ISOTROPIC;
    else
        controls->kind = resting == d - 1 ? TEST_OEDOMETER : TEST_SHEAR;
}

void stage_controls_find(struct stage_controls *controls, const struct run *run, int stage, size_t begin, size_t end)
{
    const struct scene_stage *protocol = &run->scene->stage[stage];
    *controls = (struct stage_controls){.kind = TEST_NONE, .axial = AXIS_Z};
    if (run->controller[0]) {
        commanded_read(controls, run, begin, end);
    } else {
        configuration_read(controls, protocol, run->dimension);
        controls->lateral_pressure_pa = lateral_pressure(controls, protocol, run->dimension);
    }
    record_read(controls, protocol, run, begin, end);
}

static const char *shear_name(const struct stage_controls *controls, bool triaxial)
{
    if (controls->pressure_kept)
        return controls->extension ? "extension at constant p" : "compression at constant p";
    if (isnan(controls->lateral_pressure_pa))
        return controls->extension ? "extension on a stress path" : "compression on a stress path";
    if (triaxial)
        return controls->extension ? "drained triaxial extension" : "drained triaxial compression";
    return controls->extension ? "drained biaxial extension" : "drained biaxial compression";
}

const char *stage_controls_name(const struct stage_controls *controls, int dimension)
{
    static const char *const names[TEST_KINDS] = {[TEST_NONE] = "no test with an evaluation",
                                                  [TEST_ISOTROPIC] = "isotropic compression",
                                                  [TEST_OEDOMETER] = "oedometer",
                                                  [TEST_CYCLIC] = "cyclic test",
                                                  [TEST_CREEP] = "creep",
                                                  [TEST_RELAXATION] = "relaxation"};
    if (controls->kind == TEST_SHEAR)
        return shear_name(controls, dimension == 3);
    if (controls->kind == TEST_CONSTANT_VOLUME)
        return controls->extension ? "extension at constant volume" : "compression at constant volume";
    if (controls->kind == TEST_CYCLIC && controls->volume_kept)
        return "cyclic test at constant volume";
    return names[controls->kind];
}
