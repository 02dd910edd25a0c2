/* Deterministic random numbers: xoshiro256** (Blackman & Vigna 2018), seeded by splitmix64. */
#ifndef SHAKEDOWN_SIM_BASE_RANDOM_H
#define SHAKEDOWN_SIM_BASE_RANDOM_H

#include <stdint.h>

struct random {
    uint64_t state[4];
};

void random_init(struct random *random, uint64_t seed);
double random_uniform(struct random *random); /* in [0, 1) */
double random_normal(struct random *random);  /* mean 0, s.d. 1 (Marsaglia's polar method) */

#endif
