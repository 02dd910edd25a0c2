/* The kernels one contact at a time: the reference of the vector ones. */
#include "sim/contacts.h"
#include "sim/lanes_reference.h"

#define ISA reference
#include "sim/contact_models.h"
