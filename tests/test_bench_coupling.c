/* test_bench_coupling REPORT.json: the report of `bench coupling --quick` on a small scene. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>
#include <jansson.h>

static json_t *report;
enum { POINTS = 30, INTERVALS = 5 };
static const int interval[INTERVALS] = {1, 4, 16, 64, 256};

static json_t *only_case(void)
{
    const json_t *cases = json_object_get(report, "cases");
    assert_int_equal(json_array_size(cases), 1);
    return json_array_get(cases, 0);
}

static double number(const json_t *object, const char *key)
{
    const json_t *value = json_object_get(object, key);
    assert_true(json_is_number(value));
    return json_number_value(value);
}

/* The point of a scheme with that interval, or that tolerance if it is above 0. */
static const json_t *point_of(const char *scheme, int n, double tolerance)
{
    size_t k;
    json_t *point;
    json_array_foreach(json_object_get(only_case(), "points"), k, point)
    {
        if (strcmp(json_string_value(json_object_get(point, "scheme")), scheme) != 0)
            continue;
        if (tolerance > 0 ? fabs(number(point, "tolerance") / tolerance - 1) < 1e-9
                          : number(point, "interval_steps") == n)
            return point;
    }
    fail_msg("no point %s %d %g", scheme, n, tolerance);
    return NULL;
}

static void every_point_is_there(void **unused)
{
    size_t k;
    json_t *point;
    (void)unused;
    const json_t *points = json_object_get(only_case(), "points");
    assert_int_equal(json_array_size(points), POINTS);
    json_array_foreach(points, k, point)
    {
        assert_true(json_is_false(json_object_get(point, "failed")));
        if (!json_is_true(json_object_get(point, "ran"))) {
            assert_int_equal((int)number(point, "exit_code"), 10);
            assert_non_null(strstr(json_string_value(json_object_get(point, "message")), "step"));
            continue;
        }
        assert_true(number(point, "time_ratio") > 0);
        assert_int_equal(json_array_size(json_object_get(point, "time_ratios")), 1);
        const json_t *errors = json_object_get(point, "errors");
        static const char *const keys[] = {"stress", "early", "peak", "position", "strain", "gain", "residual"};
        for (size_t e = 0; e < sizeof keys / sizeof *keys; e++)
            assert_true(isfinite(number(errors, keys[e])));
        assert_true(number(errors, "stress") == number(point, "error"));
    }
    assert_true(number(only_case(), "in_process_s") > 0);
    assert_int_equal((int)number(only_case(), "steps"), 1000);
}

/* The same bits through the pipeline as in one process: one exchange per step, and one that ends the run. */
static void one_step_is_exact(void **unused)
{
    static const char *const schemes[] = {"hold", "jacobian", "impedance", "compensated"};
    (void)unused;
    for (int s = 0; s < 4; s++) {
        const json_t *point = point_of(schemes[s], 1, 0);
        assert_true(number(point, "error") == 0);
        assert_true(number(json_object_get(point, "errors"), "position") == 0);
        assert_int_equal((int)number(point, "exchanges"), 1001);
    }
}

/* The coarser, the worse; and clear of what a shifted particle does. */
static void errors_rise_with_the_interval(void **unused)
{
    static const char *const schemes[] = {"jacobian", "pipelined", "impedance", "compensated"};
    (void)unused;
    const double floor = number(only_case(), "floor");
    assert_true(floor > 0 && floor < 1e-9);
    for (int s = 0; s < 4; s++) {
        double before = floor;
        for (int k = 1; k < INTERVALS; k++) {
            const json_t *point = point_of(schemes[s], interval[k], 0);
            double error = number(point, "error");
            print_message("%s %d: %g\n", schemes[s], interval[k], error);
            assert_true(error > before);
            assert_int_equal((int)number(point, "exchanges"),
                             (1000 + interval[k] - 1) / interval[k] + 1 + (strcmp(schemes[s], "pipelined") == 0));
            before = error;
        }
    }
}

static void errors_follow_the_tolerance(void **unused)
{
    double before = INFINITY, exchanges = 0;
    (void)unused;
    for (double tolerance = 1e-2; tolerance > 0.5e-6; tolerance *= 1e-2) {
        const json_t *point = point_of("adaptive", 0, tolerance);
        assert_true(number(point, "error") < before);
        assert_true(number(point, "exchanges") > exchanges);
        before = number(point, "error");
        exchanges = number(point, "exchanges");
    }
}

int main(int argc, char **argv)
{
    json_error_t error;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_point_is_there),
        cmocka_unit_test(one_step_is_exact),
        cmocka_unit_test(errors_rise_with_the_interval),
        cmocka_unit_test(errors_follow_the_tolerance),
    };
    report = argc == 2 ? json_load_file(argv[1], 0, &error) : NULL;
    if (!report)
        return 2;
    int failures = cmocka_run_group_tests(tests, NULL, NULL);
    json_decref(report);
    return failures;
}
