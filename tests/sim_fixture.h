/* What the tests of the simulator share: a sample made from a scene text, with particles placed by hand or compressed
 * by the control law in this process. */
#ifndef SHAKEDOWN_TESTS_SIM_FIXTURE_H
#define SHAKEDOWN_TESTS_SIM_FIXTURE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "common/scene.h"
#include "sim/sample/sample.h"

struct fixture {
    struct scene *scene;
    struct sample *sample;
};

/* Scene of one stage with fixed walls. `material` goes into its group; `more` (may be "") stands at the end and may
 * hold whole groups other than sample, material and stages. Particles of radius 1 mm and 2000 kg/m^3, far apart. */
struct fixture_options {
    int dimension, count;
    double dt_s;
    const char *material, *more;
};

/* Fails the test with the message unless `status` is OK. */
void must(enum status status);

/* The scene of a text; must be released with fixture_scene_free. */
struct scene *fixture_scene_of(const char *text);
void fixture_scene_free(struct scene *scene);

/* Scene and sample; fixture_close releases both. */
struct fixture fixture_from_text(const char *text);
struct fixture fixture_open(const struct fixture_options *options);
void fixture_close(struct fixture *fixture);

/* After particles, their radii or the walls were set by hand: masses, lists, and the start of stage 0 with walls at
 * rest where they are, for as many steps as wanted. */
void fixture_start(struct fixture *fixture);

/* n steps; fails the test if one fails. */
void fixture_steps(struct fixture *fixture, int n);

/* The loop of a run without bus and records: asks the law, takes the command, until `n_steps` steps are done or the
 * protocol is. */
void fixture_run(struct fixture *fixture, int64_t n_steps);

/* The same; returns what goes wrong instead of failing the test. */
enum status fixture_try(struct fixture *fixture, int64_t n_steps) MUST_USE;

/* One contact along x: two particles (of radius 1 mm) that overlap by overlap_m and approach at speed_m_per_s. */
struct fixture fixture_pair(const struct fixture_options *options, double overlap_m, double speed_m_per_s);
double fixture_overlap(const struct fixture *fixture);  /* of particles 0 and 1 */
double fixture_approach(const struct fixture *fixture); /* speed at which their overlap grows, along x [m/s] */

/* Relative error. */
double relative(double value, double expected);

/* Fails the test, naming `what`, unless |value - expected| <= tolerance. */
void assert_close(const char *what, double value, double expected, double tolerance);

#endif
