/* The lines of shakedown-watch. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "common/status.h"
#include "common/watch/progress.h"

static shakedown_status_t shear_at_45_percent(void)
{
    return (shakedown_status_t){
        .stage = 1,
        .n_stages = 3,
        .stage_name = "shear",
        .fraction_done = 0.45,
        .steps_per_second = 1e6 / 12.3,
        .time_left_s = 83,
        .energy_residual_ratio = 1e-5,
    };
}

static void test_full_line(void **state)
{
    (void)state;
    char text[PROGRESS_TEXT_MAX];
    shakedown_status_t status = shear_at_45_percent();
    progress_format(text, &status, 0);
    assert_string_equal(text, "stage 2/3 shear   45 %  12.3 µs/step  1:23 left  energy residual 1.0e-05");
    status.time_left_kind = 1;
    progress_format(text, &status, 0);
    assert_non_null(strstr(text, "  about 1:23 left  "));
    status.time_left_kind = 2;
    progress_format(text, &status, 0);
    assert_non_null(strstr(text, "  at most 1:23 left  "));
    status.records_repeated = 7;
    progress_format(text, &status, 0);
    assert_non_null(strstr(text, "sent again: 0 commands, 7 records"));
}

static void test_unknown_parts_are_left_out(void **state)
{
    (void)state;
    char text[PROGRESS_TEXT_MAX];
    shakedown_status_t status = shear_at_45_percent();
    status.steps_per_second = 0;
    status.time_left_s = -1;
    progress_format(text, &status, 0);
    assert_string_equal(text, "stage 2/3 shear   45 %  energy residual 1.0e-05");
}

/* "stage 2/3 shear   45 %  12.3 µs/step" has 36 columns (37 bytes): it just fits into 36, not into 35. */
static void test_narrow_terminal(void **state)
{
    (void)state;
    char text[PROGRESS_TEXT_MAX];
    shakedown_status_t status = shear_at_45_percent();
    progress_format(text, &status, 36);
    assert_string_equal(text, "stage 2/3 shear   45 %  12.3 µs/step");
    progress_format(text, &status, 35);
    assert_string_equal(text, "stage 2/3 shear   45 %");
    progress_format(text, &status, 1);
    assert_string_equal(text, "");
}

static void test_extreme_values(void **state)
{
    (void)state;
    char name[1000], text[PROGRESS_TEXT_MAX];
    shakedown_status_t status = shear_at_45_percent();
    memset(name, 'x', sizeof name - 1);
    name[sizeof name - 1] = '\0';
    status.stage_name = name;
    status.steps_per_second = 0.5;
    status.time_left_s = 1e300;
    progress_format(text, &status, 0);
    assert_non_null(strstr(text, "  2.0 s/step  277777:46:40 left  "));
}

static void test_end(void **state)
{
    (void)state;
    char text[PROGRESS_TEXT_MAX];
    shakedown_end_t end = {.step = 20000, .elapsed_s = 8, .status = STATUS_OK, .reason = ""};
    progress_format_end(text, &end);
    assert_string_equal(text, "done: 20000 steps in 0:08  400.0 µs/step");
    end.status = STATUS_UNSTABLE;
    end.reason = "particle 3 left the box";
    progress_format_end(text, &end);
    assert_string_equal(text, "stopped after 20000 steps in 0:08: particle 3 left the box  400.0 µs/step");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_full_line),
        cmocka_unit_test(test_unknown_parts_are_left_out),
        cmocka_unit_test(test_narrow_terminal),
        cmocka_unit_test(test_extreme_values),
        cmocka_unit_test(test_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
