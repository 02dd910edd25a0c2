/* Scalar kernels: the reference of the vector ones. */
#define ISA reference
#include "sim/contact_models.h"
