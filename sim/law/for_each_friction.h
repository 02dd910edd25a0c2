/* The models of one normal law and dimension (for_each_model.h). */
#define FRICTIONAL 0
#define SINGLE     0
#include MODEL_TEXT
#undef SINGLE
#define SINGLE 1
#include MODEL_TEXT
#undef SINGLE
#undef FRICTIONAL

#define FRICTIONAL 1
#define SINGLE     0
#include MODEL_TEXT
#undef SINGLE
#define SINGLE 1
#include MODEL_TEXT
#undef SINGLE
#undef FRICTIONAL
