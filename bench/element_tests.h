/* The shipped scenes as rows of a table: which kind of test each is, what it is to keep, and a short form of it. */
#ifndef SHAKEDOWN_BENCH_ELEMENT_TESTS_H
#define SHAKEDOWN_BENCH_ELEMENT_TESTS_H

#include <stdbool.h>

enum { ELEMENT_TEST_SETTINGS = 12 };

struct element_test {
    const char *scene; /* scenes/SCENE.cfg */
    const char *test;  /* what it is */
    bool published;    /* rate and walls are a paper's: what is kept is shown, not judged; no short form */
    const char *quick[ELEMENT_TEST_SETTINGS]; /* KEY=VALUE that make it short; the rates stay */
};

extern const struct element_test element_tests[];
extern const int element_tests_count;

/* NULL if there is none of that name. */
const struct element_test *element_test_find(const char *scene);

#endif
