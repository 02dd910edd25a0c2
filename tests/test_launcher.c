/* Parts of the launcher: what stays of a process' words, how often it is started again, the copy of a scene. */
#include <fcntl.h>
#include <glib.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "launcher/child_log.h"
#include "launcher/report.h"
#include "launcher/restarts.h"
#include "launcher/run_folder.h"
#include "launcher/scene_copy.h"

static char folder[] = "/tmp/test_launcher.XXXXXX";

static char *in_folder(const char *name)
{
    return g_build_filename(folder, name, NULL);
}

static void write_file(const char *name, const char *text)
{
    char *path = in_folder(name);
    assert_true(g_file_set_contents(path, text, -1, NULL));
    g_free(path);
}

static void expect_file(const char *name, const char *text)
{
    char *path = in_folder(name), *found = NULL;
    assert_true(g_file_get_contents(path, &found, NULL, NULL));
    assert_string_equal(found, text);
    g_free(found);
    g_free(path);
}

/* --- Words of a process --- */

static void say_lines(struct child_log *log, const char *path, int lines)
{
    int write_end;
    assert_int_equal(child_log_open(log, path, &write_end), STATUS_OK);
    for (int k = 0; k < lines; k++) {
        assert_true(dprintf(write_end, "line %d\n", k) > 0);
        child_log_take(log);
    }
    close(write_end);
    child_log_close(log);
}

/* More than the memory holds: the file has all, the memory the end. */
static void the_last_lines_stay(void **state)
{
    struct child_log log = {0};
    char *path = in_folder("all.log");
    (void)state;
    say_lines(&log, path, 5000);
    assert_string_equal(child_log_last_lines(&log, 2), "line 4998\nline 4999\n");
    assert_true(log.n_tail < CHILD_LOG_TAIL_MAX && log.n_tail > CHILD_LOG_TAIL_MAX - 2);
    char *text = NULL;
    assert_true(g_file_get_contents(path, &text, NULL, NULL));
    assert_memory_equal(text, "line 0\nline 1\n", 14);
    assert_true(g_str_has_suffix(text, "line 4998\nline 4999\n"));
    g_free(text);
    g_free(path);
    g_free(log.path);
}

/* A file that cannot be written, and a disk that is full. */
static void a_reason_is_not_lost_with_the_log(void **state)
{
    static const char *const paths[] = {"/nonexistent/a.log", "/dev/full"};
    (void)state;
    for (size_t k = 0; k < sizeof paths / sizeof *paths; k++) {
        struct child_log log = {0};
        say_lines(&log, paths[k], 3);
        assert_string_equal(child_log_last_lines(&log, 15), "line 0\nline 1\nline 2\n");
        g_free(log.path);
    }
}

static void ends_are_told(void **state)
{
    char text[END_TEXT_MAX];
    (void)state;
    end_text(text, 137);
    assert_string_equal(text, "was ended by signal KILL");
    end_text(text, 10);
    assert_string_equal(text, "ended with exit code 10");
    end_text(text, 255); /* 127 is no signal */
    assert_string_equal(text, "ended with exit code 255");
    end_text(text, EXIT_CODE_TIMEOUT);
    assert_string_equal(text, "did not end in time");
}

/* --- Restarts --- */

static void restarts_are_counted_within_an_hour(void **state)
{
    struct restarts restarts = {0};
    (void)state;
    assert_false(restarts_allow(&restarts, 0, 0));
    assert_true(restarts_allow(&restarts, 2, 0));
    assert_true(restarts_allow(&restarts, 2, 1800));
    assert_false(restarts_allow(&restarts, 2, 3599));
    assert_true(restarts_allow(&restarts, 2, 3600)); /* the first is an hour ago */
    assert_false(restarts_allow(&restarts, 2, 5399));
    assert_int_equal(restarts.n, 2);
}

static void restarts_end_at_the_room_for_them(void **state)
{
    struct restarts restarts = {0};
    (void)state;
    for (int k = 0; k < RESTARTS_MAX; k++)
        assert_true(restarts_allow(&restarts, 2 * RESTARTS_MAX, k));
    assert_false(restarts_allow(&restarts, 2 * RESTARTS_MAX, RESTARTS_MAX));
}

/* --- Scenes --- */

/* The path may stand in a comment too, and hold what libconfig escapes; the rest of the text stays. */
static void a_path_of_a_copied_scene_is_absolute(void **state)
{
    (void)state;
    char *words[] = {"--set", "a.b=c", "--set", "sample.checkpoint=\"x/c.h5\"", "--set", "sample.checkpoint=y.h5",
                     NULL};
    write_file("original.cfg", "// from \"old/a\\\"b.h5\"\nsample = { count = 3; // \"old/a\\\"b.h5\"\n"
                               "  checkpoint = \"old/a\\\"b.h5\"; };\n");
    char *scene = in_folder("original.cfg"), *copy = in_folder("copy");
    assert_int_equal(g_mkdir_with_parents(copy, 0700), 0);
    assert_int_equal(scene_copy(scene, copy, words), STATUS_OK);
    char *expected = g_strdup_printf("// from \"old/a\\\"b.h5\"\nsample = { count = 3; // \"old/a\\\"b.h5\"\n"
                                     "  checkpoint = \"%s/old/a\\\"b.h5\"; };\n",
                                     folder);
    expect_file("copy/scene.cfg", expected);
    g_free(expected);
    expected = g_strdup_printf("--set\na.b=c\n--set\nsample.checkpoint=\"%s/x/c.h5\"\n--set\n"
                               "sample.checkpoint=\"%s/y.h5\"\n",
                               folder, folder);
    expect_file("copy/overrides", expected);
    g_free(expected);
    g_free(scene);
    g_free(copy);
}

static void what_cannot_be_copied_is_refused(void **state)
{
    (void)state;
    char *none[] = {NULL}, *odd[] = {"--set", "name=\"a\nb\"", NULL};
    char *scene = in_folder("pieces.cfg"), *copy = in_folder("copy");
    write_file("pieces.cfg", "sample = { checkpoint = \"old/\" \"a.h5\"; };\n");
    assert_int_equal(g_mkdir_with_parents(copy, 0700), 0);
    assert_int_equal(scene_copy(scene, copy, none), STATUS_CONFIG);
    assert_int_equal(scene_copy(scene, copy, odd), STATUS_USAGE);
    assert_int_equal(scene_copy("/nonexistent.cfg", copy, none), STATUS_IO);
    g_free(scene);
    g_free(copy);
}

/* --- The folder of a run --- */

static void a_folder_says_what_to_start(void **state)
{
    struct run_folder run;
    (void)state;
    write_file("run-id", "17\n");
    write_file("overrides", "--set\na=b c\n");
    write_file("controller", "'./my controller' --say \"$HOME `date`\" x\\ y\n");
    assert_int_equal(run_folder_read(&run, folder), STATUS_OK);
    assert_string_equal(run.run_id, "17");
    assert_null(run.url);
    assert_string_equal(run.overrides[1], "a=b c");
    assert_null(run.overrides[2]);
    assert_string_equal(run.controller[0], "./my controller");
    assert_string_equal(run.controller[2], "$HOME `date`"); /* nothing is expanded or run */
    assert_string_equal(run.controller[3], "x y");
    run_folder_free(&run);
    write_file("controller", "'open\n");
    assert_int_equal(run_folder_read(&run, folder), STATUS_USAGE);
    run_folder_free(&run);
    write_file("run-id", "17; reboot\n");
    assert_int_equal(run_folder_read(&run, folder), STATUS_FORMAT);
    run_folder_free(&run);
}

static int make_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
    static const char *const names[] = {"all.log", "original.cfg", "pieces.cfg", "copy/scene.cfg", "copy/overrides",
                                        "copy",    "run-id",       "overrides",  "controller",     ""};
    (void)state;
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        char *path = in_folder(names[k]);
        (void)remove(path);
        g_free(path);
    }
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_last_lines_stay),
        cmocka_unit_test(a_reason_is_not_lost_with_the_log),
        cmocka_unit_test(ends_are_told),
        cmocka_unit_test(restarts_are_counted_within_an_hour),
        cmocka_unit_test(restarts_end_at_the_room_for_them),
        cmocka_unit_test(a_path_of_a_copied_scene_is_absolute),
        cmocka_unit_test(what_cannot_be_copied_is_refused),
        cmocka_unit_test(a_folder_says_what_to_start),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
