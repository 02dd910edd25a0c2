/* The numbers an analysis gives, from one list: it drives analysis.json, the table and the ensemble. */
#ifndef SHAKEDOWN_ANALYZER_QUANTITY_H
#define SHAKEDOWN_ANALYZER_QUANTITY_H

#include <stdbool.h>

#include "analyzer/statistics.h"
#include "common/status.h"

/* id, key in analysis.json (a dot opens an object), unit. Definitions: docs/analysis.md. */
#define QUANTITY_LIST(X)                                                                                               \
    X(E_INITIAL, "E_initial_pa", "Pa")                                                                                 \
    X(E50, "E50_pa", "Pa")                                                                                             \
    X(EPS_V_SLOPE_INITIAL, "eps_v_slope_initial", "1")                                                                 \
    X(NU, "nu", "1")                                                                                                   \
    X(DILATANCY_SLOPE, "dilatancy_slope", "1")                                                                         \
    X(DILATANCY_ANGLE, "dilatancy_angle_deg", "deg")                                                                   \
    X(PEAK_SIGMA_CORR, "peak.sigma_corr_pa", "Pa")                                                                     \
    X(PEAK_SIGMA_ZZ, "peak.sigma_zz_pa", "Pa")                                                                         \
    X(PEAK_SIGMA_XX, "peak.sigma_xx_pa", "Pa")                                                                         \
    X(PEAK_EPS_ZZ, "peak.eps_zz", "1")                                                                                 \
    X(PEAK_STRESS_RATIO, "peak.stress_ratio", "1")                                                                     \
    X(PEAK_SIN_PHI, "peak.sin_phi", "1")                                                                               \
    X(PEAK_TAN_PHI, "peak.tan_phi", "1")                                                                               \
    X(PEAK_FRICTION_ANGLE, "peak.friction_angle_deg", "deg")                                                           \
    X(PEAK_Q_OVER_P, "peak.q_over_p", "1")                                                                             \
    X(RESIDUAL_SIGMA_CORR, "residual.sigma_corr_pa", "Pa")                                                             \
    X(RESIDUAL_STRESS_RATIO, "residual.stress_ratio", "1")                                                             \
    X(CRITICAL_SIN_PHI, "critical.sin_phi", "1")                                                                       \
    X(CRITICAL_FRICTION_ANGLE, "critical.friction_angle_deg", "deg")                                                   \
    X(CRITICAL_Q_OVER_P, "critical.q_over_p", "1")                                                                     \
    X(ENERGY_RESIDUAL, "energy_residual", "1")                                                                         \
    X(INTERFACE_RESIDUAL, "interface_residual", "1")                                                                   \
    X(CONTROLLER_RESIDUAL, "controller_residual", "1")                                                                 \
    X(STRESS_DIFFERENCE, "stress_wall_contact_difference", "1")                                                        \
    X(INITIAL_PHI, "initial.phi", "1")                                                                                 \
    X(INITIAL_COORDINATION, "initial.coordination", "1")                                                               \
    X(INITIAL_COORDINATION_NO_RATTLERS, "initial.coordination_no_rattlers", "1")                                       \
    X(CYCLES_FIRST, "cycles.first_cycle_eps_d", "1")                                                                   \
    X(CYCLES_EPS_D, "cycles.eps_d_end", "1")                                                                           \
    X(CYCLES_EPS_V, "cycles.eps_v_end", "1")                                                                           \
    X(CYCLES_RATE, "cycles.rate_per_cycle", "1")                                                                       \
    X(CYCLES_EPS_V_RATE, "cycles.eps_v_rate_per_cycle", "1")                                                           \
    X(CYCLES_RATE_EXPONENT, "cycles.rate_exponent", "1")                                                               \
    X(CYCLES_ACCUMULATION_FACTOR, "cycles.accumulation_factor", "1")                                                   \
    X(CYCLES_ACCUMULATION_EXPONENT, "cycles.accumulation_exponent", "1")                                               \
    X(CYCLES_LOOP_AREA, "cycles.loop_area_j_per_m3", "J/m^3")                                                          \
    X(CYCLES_RESILIENT_MODULUS, "cycles.resilient_modulus_pa", "Pa")                                                   \
    X(CYCLES_DAMPING_RATIO, "cycles.damping_ratio", "1")

enum quantity_id {
#define QUANTITY_ENUM(id, key, unit) QUANTITY_##id,
    QUANTITY_LIST(QUANTITY_ENUM)
#undef QUANTITY_ENUM
        QUANTITIES
};

struct quantity {
    double value;       /* NaN: undefined, `text` says why */
    double uncertainty; /* standard uncertainty; NaN: none can be told */
    bool has_window;
    double window[2]; /* of axial strain, or of cycles */
    char text[160];   /* reason if undefined, else a note; "" if there is nothing to say */
};

/* Key and unit of a quantity. */
const char *quantity_key(enum quantity_id id);
const char *quantity_unit(enum quantity_id id);

/* True for the keys that begin with "cycles.". */
bool quantity_is_cyclic(enum quantity_id id);

/* Marks as undefined, for a reason. */
void quantity_undefined(struct quantity *quantity, const char *format, ...) PRINTF_LIKE(2, 3);

/* Sets value and uncertainty, without a window; a value that is not finite becomes undefined ("not a finite number").
 */
void quantity_set(struct quantity *quantity, struct estimate estimate);

/* Adds the window [a, b]. */
void quantity_window(struct quantity *quantity, double a, double b);

/* Adds a note. */
void quantity_note(struct quantity *quantity, const char *format, ...) PRINTF_LIKE(2, 3);

#endif
