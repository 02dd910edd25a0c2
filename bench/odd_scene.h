/* Random legal scenes: what people may write, and more. */
#ifndef SHAKEDOWN_BENCH_ODD_SCENE_H
#define SHAKEDOWN_BENCH_ODD_SCENE_H

#include <stdint.h>
#include <stdio.h>

/* Writes the scene number `index` of a seed. Particles of nm to km, 1 to 2000 of them, all laws, walls and schemes, 1
 * to 3 stages of a few thousand steps; loads, speeds and time steps from gentle to what no contact bears. */
void odd_scene_write(FILE *out, uint64_t seed, int index);

#endif
