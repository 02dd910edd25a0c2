/* The models of one normal law and dimension (for_each_model.h). */
#define FRICTION   0
#define FRICTIONAL 0
#define ROLLING    0
#define TORSION    0
#include "sim/law/for_each_precision.h"
#undef FRICTION
#undef FRICTIONAL

#define FRICTION   1
#define FRICTIONAL 1
#include "sim/law/for_each_precision.h"
#undef FRICTION
#undef ROLLING

#define FRICTION 2
#define ROLLING  1
#include "sim/law/for_each_precision.h"
#undef FRICTION
#undef TORSION

#if DIM == 3
#define FRICTION 3
#define TORSION  1
#include "sim/law/for_each_precision.h"
#undef FRICTION
#undef TORSION
#endif
#undef FRICTIONAL
#undef ROLLING
