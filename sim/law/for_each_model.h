/* Includes MODEL_TEXT once for every model of contacts, with these macros set:
 * NORMAL, NORMAL_TEXT: name of the normal law (CONTACT_LAWS, common/scene.h) and the file of its text; a new law is one
 * more block here; PER_PAIR: 1 if it differs from contact to contact; MINDLIN: 1 if friction does; TANGENTIAL_TEXT: the
 * file of its text; DIM: 2 or 3; FRICTION: 0 none, 1 of slip, 2 and of rolling, 3 (3D) and of torsion; FRICTIONAL,
 * ROLLING, TORSION: 1 if at least 1, 2, 3; SINGLE: 0 or 1. */
#define PER_PAIR        0
#define MINDLIN         0
#define TANGENTIAL_TEXT "sim/law/tangential_spring_tmpl.h"
#define NORMAL          linear
#define NORMAL_TEXT     "sim/law/normal_linear.h"
#include "sim/law/for_each_dimension.h"
#undef NORMAL
#undef NORMAL_TEXT

#define NORMAL      hysteretic
#define NORMAL_TEXT "sim/law/normal_hysteretic.h"
#include "sim/law/for_each_dimension.h"
#undef NORMAL
#undef NORMAL_TEXT

#undef PER_PAIR
#define PER_PAIR    1
#define NORMAL      linear_restitution
#define NORMAL_TEXT "sim/law/normal_linear_restitution.h"
#include "sim/law/for_each_dimension.h"
#undef NORMAL
#undef NORMAL_TEXT

#define NORMAL      elastoplastic
#define NORMAL_TEXT "sim/law/normal_elastoplastic.h"
#include "sim/law/for_each_dimension.h"
#undef NORMAL
#undef NORMAL_TEXT

#undef MINDLIN
#undef TANGENTIAL_TEXT
#define MINDLIN         1
#define TANGENTIAL_TEXT "sim/law/tangential_mindlin_tmpl.h"
#define NORMAL          hertz
#define NORMAL_TEXT     "sim/law/normal_hertz.h"
#include "sim/law/for_each_dimension.h"
#undef NORMAL
#undef NORMAL_TEXT

#undef PER_PAIR
#undef MINDLIN
#undef TANGENTIAL_TEXT

#undef MODEL_TEXT
