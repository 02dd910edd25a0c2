/* Synthetic runs for the tests of the analyzer: curves with known answers, in memory and as run.h5. */
#ifndef SHAKEDOWN_TESTS_TEST_ANALYZER_FIXTURE_H
#define SHAKEDOWN_TESTS_TEST_ANALYZER_FIXTURE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "analyzer/run_file.h"

/* Fails unless |value - expected| <= tolerance (cmocka's own comparison is in float). */
void assert_near(double value, double expected, double tolerance);

/* Same numbers for the same seed: splitmix64 and Box-Muller. */
struct random {
    uint64_t state;
};
double random_uniform(struct random *random); /* in (0, 1) */
double random_normal(struct random *random);

/* A run with the scene of `config` and n samples, every observable 0 but: box lengths 0.1 m, solid_fraction 0.88,
 * coordination 4, coordination_no_rattlers 4.2, fabric isotropic, step = sample number. Release with run_free. */
void fixture_run(struct run *run, const char *config, size_t n);

/* Sets component k of an observable of sample i. */
void fixture_set(struct run *run, enum observable observable, size_t i, size_t k, double value);

/* What to spoil in the file. */
struct flaw {
    const char *omit;      /* name of an observable that is left out */
    const char *misshape;  /* name of an observable that is written as [n][7] */
    const char *shorten;   /* name of an observable that has one record less */
    const char *attribute; /* of /parameters, left out */
    const char *huge;      /* name of an observable that claims 2^40 records and holds none */
};

/* Writes run.h5 as docs/file-format.md says (parameters and observables). `config` goes into effective_config. */
void fixture_write(const struct run *run, const char *config, const char *directory, const struct flaw *flaw);

/* A fresh directory below $TMPDIR or /tmp; removed with all its files by fixture_directory_remove. */
void fixture_directory_make(char *path, size_t size);
void fixture_directory_remove(const char *path);

/* The biaxial test with known answers. Pressure p = 500 Pa; strain 0 to 0.035 on a cosine path of `n` samples, then
 * `rest` samples at rest. Stress ratio R: 1 + 0.2 eps/0.001 up to 0.001 (E = 1e5 Pa); straight to the parabola 1.6 -
 * 2000 (eps - 0.012)^2 on [0.006, 0.018]; straight down to 1.4 at 0.028; 1.4 from there. eps_v: slope -0.31 up to
 * 0.002, then 0 to 0.008, then +0.19 (dilation positive). All strains are logarithmic. */
struct biaxial_model {
    size_t n, rest;
    double stress_noise_pa; /* s.d. of both stresses */
    double strain_noise;    /* s.d. of eps_v */
    double correlation;     /* of successive errors, 0 <= correlation < 1 (first-order autoregression) */
};

extern const char fixture_biaxial_config[];
double fixture_ratio(double eps);
double fixture_eps_v(double eps);
void fixture_biaxial(struct run *run, const struct biaxial_model *model, struct random *random);

/* The cyclic test with known answers, in 3D: period T = 10 s, p0 = 1000 Pa, Delta sigma = 200 Pa on x,
 * logarithmic eps_x = (e/2) [cos(delta) - cos(2 pi t/T - delta)] + accumulated(t/T), eps_y = eps_z = -0.3 eps_x, e =
 * 1e-3, delta = 2 pi 4/64, `per_cycle` samples per cycle. */
struct cyclic_model {
    size_t cycles, per_cycle;
    double (*accumulated)(double cycles, const void *context);
    const void *context;
};

extern const char fixture_cyclic_config[];
void fixture_cyclic(struct run *run, const struct cyclic_model *model);

#endif
