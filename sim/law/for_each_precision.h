/* The models of one normal law, dimension and friction (for_each_model.h). */
#define SINGLE 0
#include MODEL_TEXT
#undef SINGLE

#define SINGLE 1
#include MODEL_TEXT
#undef SINGLE
