/* The benchmark of accuracy: its error measures, and what it reads from the log of a run. */
#include <lcm/eventlog.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bench/accuracy_curve.h"
#include "common/bus.h"
#include "shakedown_end_t.h"
#include "shakedown_sample_t.h"
#include "sim_fixture.h"

static double times[] = {0, 1, 2, 3}, strains[] = {0, 0.1, 0.2, 0.3};

static struct curve curve_of(double *value)
{
    return (struct curve){.count = 4, .time_s = times, .strain = strains, .value = value};
}

/* Differences 0, 0, 3, 4 against values 0, 3, 4, 12 (squares: 169): 5/13; up to 20 % strain 3/5. */
static void error_is_relative(void **state)
{
    (void)state;
    double of_a[] = {0, 3, 7, 8}, of_b[] = {0, 3, 4, 12}, error;
    struct curve a = curve_of(of_a), b = curve_of(of_b);
    must(curve_error(&a, &b, INFINITY, &error));
    assert_close("error", error, 5.0 / 13, 1e-15);
    must(curve_error(&a, &b, 0.2, &error));
    assert_close("error in a window", error, 3.0 / 5, 1e-15);
    must(curve_error(&b, &b, INFINITY, &error));
    assert_true(error == 0);
}

static void only_like_curves_are_compared(void **state)
{
    (void)state;
    double value[] = {0, 3, 4, 12}, zero[4] = {0}, late[] = {0, 1, 2.001, 3}, error;
    struct curve a = curve_of(value), b = curve_of(value);
    b.count = 3;
    assert_int_equal(curve_error(&a, &b, INFINITY, &error), STATUS_FORMAT);
    b = curve_of(value);
    b.time_s = late;
    assert_int_equal(curve_error(&a, &b, INFINITY, &error), STATUS_FORMAT);
    b = curve_of(zero);
    assert_int_equal(curve_error(&a, &b, INFINITY, &error), STATUS_FORMAT);
    b = curve_of(value);
    assert_int_equal(curve_error(&a, &b, -1, &error), STATUS_FORMAT); /* no sample in the window */
}

/* error = 7 step^2 */
static void order_of_two_points(void **state)
{
    (void)state;
    assert_close("order", convergence_order(1e-6, 7e-12, 4e-7, 7 * 1.6e-13), 2, 1e-12);
    assert_false(isfinite(convergence_order(1e-6, 7e-12, 4e-7, 0)));
}

static void add_event(lcm_eventlog_t *log, const char *channel, uint8_t *data, int size)
{
    char name[16];
    snprintf(name, sizeof name, "%s", channel);
    lcm_eventlog_event_t event = {
        .channellen = (int32_t)strlen(name), .datalen = size, .channel = name, .data = data, .timestamp = 1};
    assert_true(size > 0);
    assert_int_equal(lcm_eventlog_write_event(log, &event), 0);
}

static void add_sample(lcm_eventlog_t *log, double time_s)
{
    uint8_t data[2048];
    double length[2] = {1, 1}, strain[2] = {0.5, time_s}, stress[2] = {7, 10 * time_s}, tensor[4] = {0}, wall[4] = {0};
    shakedown_sample_t sample = {.time_s = time_s,
                                 .dimension = 2,
                                 .box_length_m = length,
                                 .strain = strain,
                                 .stress_wall_pa = stress,
                                 .n_stress = 4,
                                 .stress_contact_pa = tensor,
                                 .fabric = tensor,
                                 .n_walls = 4,
                                 .wall_position_m = wall,
                                 .wall_velocity_m_per_s = wall,
                                 .wall_force_n = wall,
                                 .work_walls_j = 3,
                                 .work_gravity_j = 1,
                                 .energy_residual_j = -0.5 * time_s};
    add_event(log, "SAMPLE", data, shakedown_sample_t_encode(data, 0, sizeof data, &sample));
}

static void add_end(lcm_eventlog_t *log, int status)
{
    uint8_t data[512];
    int64_t numbers[RECORD_CHANNELS] = {0};
    char *channels[RECORD_CHANNELS];
    for (int c = 0; c < RECORD_CHANNELS; c++)
        channels[c] = (char *)record_channel_name[c];
    shakedown_end_t end = {.status = status,
                           .reason = (char *)"",
                           .state_hash = 42,
                           .n_channels = RECORD_CHANNELS,
                           .channel = channels,
                           .total = numbers,
                           .hash = numbers};
    add_event(log, "END", data, shakedown_end_t_encode(data, 0, sizeof data, &end));
}

/* A log of n samples at 0, 1, ... s, and of END unless its status is negative; `path` is a template. */
static void write_log(char *path, int n, int end_status)
{
    int file = mkstemp(path);
    assert_true(file >= 0);
    close(file);
    lcm_eventlog_t *log = lcm_eventlog_create(path, "w");
    assert_non_null(log);
    for (int k = 0; k < n; k++)
        add_sample(log, k);
    if (end_status >= 0)
        add_end(log, end_status);
    lcm_eventlog_destroy(log);
}

static enum status read_log(struct curve *curve, int n, int end_status, enum curve_quantity quantity, int component)
{
    char path[] = "/tmp/shakedown-log-XXXXXX";
    write_log(path, n, end_status);
    enum status status = curve_read(curve, path, quantity, component);
    assert_int_equal(remove(path), 0);
    return status;
}

static void curve_comes_from_the_log(void **state)
{
    (void)state;
    struct curve curve;
    must(read_log(&curve, 5, 0, CURVE_STRESS_WALL, 1));
    assert_int_equal(curve.count, 5);
    for (int k = 0; k < 5; k++)
        assert_true(curve.time_s[k] == k && curve.strain[k] == k && curve.value[k] == 10 * k);
    assert_close("residual over work", curve.residual_ratio, 0.5 * 4 / (3 + 1), 1e-15);
    assert_int_equal(curve.hash, 42);
    curve_free(&curve);
    must(read_log(&curve, 1, 0, CURVE_STRAIN, 0));
    assert_true(curve.count == 1 && curve.value[0] == 0.5);
    curve_free(&curve);
}

static void runs_that_did_not_end_well_are_refused(void **state)
{
    (void)state;
    struct curve curve;
    assert_int_equal(read_log(&curve, 3, -1, CURVE_STRAIN, 0), STATUS_FORMAT); /* no END */
    assert_int_equal(read_log(&curve, 3, 10, CURVE_STRAIN, 0), STATUS_FORMAT); /* unstable */
    assert_int_equal(read_log(&curve, 0, 0, CURVE_STRAIN, 0), STATUS_FORMAT);  /* no samples */
    assert_int_equal(read_log(&curve, 3, 0, CURVE_STRAIN, 2), STATUS_FORMAT);  /* no such component */
    assert_int_equal(curve_read(&curve, "/nowhere/run.lcm", CURVE_STRAIN, 0), STATUS_IO);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(error_is_relative),
        cmocka_unit_test(only_like_curves_are_compared),
        cmocka_unit_test(order_of_two_points),
        cmocka_unit_test(curve_comes_from_the_log),
        cmocka_unit_test(runs_that_did_not_end_well_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
