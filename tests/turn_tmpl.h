/* MODEL_TEXT of test_friction_scheme.c: a spring that turns with a pair, in the law's own text and in either precision.
 * Parameters as of contact_law_tmpl.h. */
#include "sim/law/contact_law_tmpl.h"

#if DIM == 3 && FRICTION == 1
/* Turns `spring` n times by `angle` about `axis` with the normal, which starts as x; spheres turn along. */
static void NAME(turn_often)(const double *axis, double angle, int n, double *spring)
{
    const struct contact_law_constants constants = {.kt = 1, .springs = true};
    const struct law_units si = {1, 1, 1};
    const struct NAME(law) law = NAME(law_of)(&constants, 1, 1, &si);
    real s[3], rest[3] = {0};
    for (int c = 0; c < 3; c++)
        s[c] = (scalar)spring[c];
    for (int k = 1; k <= n; k++) {
        struct NAME(meeting) at;
        struct NAME(sides) of;
        double normal[3], side[3];
        const double x[3] = {1, 0, 0};
        turn_about(axis, angle * k, x, normal);
        cross_of(axis, normal, side);
        real gt[3], change[3] = {0};
        of.inverse = 1;
        for (int c = 0; c < 3; c++) {
            at.n[c] = (scalar)normal[c];
            gt[c] = (scalar)(angle * side[c]); /* at distance 1 in a step of 1 s */
            of.spin[c] = (scalar)(2 * angle * axis[c]);
        }
        NAME(turning)(&law, &of, gt, &at);
        NAME(turn)(&at, s, change);
        for (int c = 0; c < 3; c++) {
            real more = SINGLE ? rest[c] + change[c] : change[c], after = s[c] + more;
            rest[c] = more - (after - s[c]);
            s[c] = after;
        }
    }
    for (int c = 0; c < 3; c++)
        spring[c] = (double)s[c] + (SINGLE ? (double)rest[c] : 0);
}
#endif
