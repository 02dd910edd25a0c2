/* Tests whose three principal stresses differ (constant b, plane strain): what the mean of the lateral ones hides. */
#ifndef SHAKEDOWN_ANALYZER_TRUE_TRIAXIAL_H
#define SHAKEDOWN_ANALYZER_TRUE_TRIAXIAL_H

#include "analyzer/curves.h"
#include "analyzer/quantity.h"

/* Sets true_triaxial.* of a 3D shear test from the wall stresses of its samples; absent where the lateral stresses are
 * alike (to 5 % of sigma_zz - sigma_xx). STATUS_NO_MEMORY. */
enum status true_triaxial_evaluate(const struct run *run, const struct curves *curves,
                                   struct quantity *quantities) MUST_USE;

#endif
