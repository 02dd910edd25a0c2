/* MODEL_TEXT of contact_law.c: the constants of the normal law alone. */
#include NORMAL_TEXT
