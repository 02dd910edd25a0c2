/* The numbers an analysis gives, from one list: it drives analysis.json, the table and the ensemble. */
#ifndef SHAKEDOWN_ANALYZER_QUANTITY_H
#define SHAKEDOWN_ANALYZER_QUANTITY_H

#include <stdbool.h>

#include "analyzer/stage_controls.h"
#include "analyzer/statistics.h"
#include "common/status.h"

/* Kinds of tests that have a quantity, as a set. */
#define TESTS(kind)       (1u << TEST_##kind)
#define TESTS_ANY         (~0u)
#define TESTS_SHEAR       (TESTS(SHEAR) | TESTS(CONSTANT_VOLUME))
#define TESTS_UNDRAINED   TESTS(CONSTANT_VOLUME)
#define TESTS_ISOTROPIC   TESTS(ISOTROPIC)
#define TESTS_OEDOMETER   TESTS(OEDOMETER)
#define TESTS_COMPRESSION (TESTS(ISOTROPIC) | TESTS(OEDOMETER))
#define TESTS_CREEP       TESTS(CREEP)
#define TESTS_RELAXATION  TESTS(RELAXATION)
#define TESTS_CYCLIC      TESTS(CYCLIC)

/* id, key in analysis.json (a dot opens an object), unit, tests. Definitions: docs/analysis.md. */
#define QUANTITY_LIST(X)                                                                                               \
    X(E_INITIAL, "E_initial_pa", "Pa", SHEAR)                                                                          \
    X(G_INITIAL, "G_initial_pa", "Pa", SHEAR)                                                                          \
    X(E50, "E50_pa", "Pa", SHEAR)                                                                                      \
    X(HALF_STIFFNESS, "eps_zz_at_half_E", "1", SHEAR)                                                                  \
    X(EPS_V_SLOPE_INITIAL, "eps_v_slope_initial", "1", SHEAR)                                                          \
    X(NU, "nu", "1", SHEAR)                                                                                            \
    X(WINDOW_E, "window.E_pa", "Pa", SHEAR)                                                                            \
    X(WINDOW_NU, "window.nu", "1", SHEAR)                                                                              \
    X(VISCOUS_ZZ, "viscous.sigma_zz_pa", "Pa", SHEAR)                                                                  \
    X(VISCOUS_XX, "viscous.sigma_xx_pa", "Pa", SHEAR)                                                                  \
    X(ZERO_RATE_ZZ, "zero_rate.sigma_zz_pa", "Pa", SHEAR)                                                              \
    X(ZERO_RATE_XX, "zero_rate.sigma_xx_pa", "Pa", SHEAR)                                                              \
    X(DILATANCY_SLOPE, "dilatancy_slope", "1", SHEAR)                                                                  \
    X(DILATANCY_ANGLE, "dilatancy_angle_deg", "deg", SHEAR)                                                            \
    X(ROWE_K, "rowe.K", "1", SHEAR)                                                                                    \
    X(ROWE_ANGLE, "rowe.friction_angle_deg", "deg", SHEAR)                                                             \
    X(PEAK_SIGMA_CORR, "peak.sigma_corr_pa", "Pa", SHEAR)                                                              \
    X(PEAK_SIGMA_ZZ, "peak.sigma_zz_pa", "Pa", SHEAR)                                                                  \
    X(PEAK_SIGMA_XX, "peak.sigma_xx_pa", "Pa", SHEAR)                                                                  \
    X(PEAK_EPS_ZZ, "peak.eps_zz", "1", SHEAR)                                                                          \
    X(PEAK_STRESS_RATIO, "peak.stress_ratio", "1", SHEAR)                                                              \
    X(PEAK_SIN_PHI, "peak.sin_phi", "1", SHEAR)                                                                        \
    X(PEAK_TAN_PHI, "peak.tan_phi", "1", SHEAR)                                                                        \
    X(PEAK_FRICTION_ANGLE, "peak.friction_angle_deg", "deg", SHEAR)                                                    \
    X(PEAK_Q_OVER_P, "peak.q_over_p", "1", SHEAR)                                                                      \
    X(RESIDUAL_SIGMA_CORR, "residual.sigma_corr_pa", "Pa", SHEAR)                                                      \
    X(RESIDUAL_STRESS_RATIO, "residual.stress_ratio", "1", SHEAR)                                                      \
    X(CRITICAL_SIN_PHI, "critical.sin_phi", "1", SHEAR)                                                                \
    X(CRITICAL_FRICTION_ANGLE, "critical.friction_angle_deg", "deg", SHEAR)                                            \
    X(CRITICAL_Q_OVER_P, "critical.q_over_p", "1", SHEAR)                                                              \
    X(PATH_DIRECTION, "path.direction_deg", "deg", SHEAR)                                                              \
    X(PATH_STIFFNESS, "path.stiffness_initial_pa", "Pa", SHEAR)                                                        \
    X(PATH_K, "path.K_initial_pa", "Pa", SHEAR)                                                                        \
    X(YIELD_P, "yield.p_pa", "Pa", SHEAR)                                                                              \
    X(YIELD_Q, "yield.q_pa", "Pa", SHEAR)                                                                              \
    X(YIELD_EPS, "yield.eps_zz", "1", SHEAR)                                                                           \
    X(YIELD_STIFFNESS_RATIO, "yield.stiffness_ratio", "1", SHEAR)                                                      \
    X(TRUE_EPS, "true_triaxial.peak_eps_zz", "1", SHEAR)                                                               \
    X(TRUE_B, "true_triaxial.b", "1", SHEAR)                                                                           \
    X(TRUE_SIN_PHI, "true_triaxial.sin_phi", "1", SHEAR)                                                               \
    X(TRUE_ANGLE, "true_triaxial.friction_angle_deg", "deg", SHEAR)                                                    \
    X(TRUE_Q_OVER_P, "true_triaxial.q_over_p", "1", SHEAR)                                                             \
    X(TRUE_LODE, "true_triaxial.lode_angle_deg", "deg", SHEAR)                                                         \
    X(TRUE_LADE, "true_triaxial.lade_duncan", "1", SHEAR)                                                              \
    X(TRUE_MATSUOKA, "true_triaxial.matsuoka_nakai", "1", SHEAR)                                                       \
    X(P0, "undrained.p0_pa", "Pa", UNDRAINED)                                                                          \
    X(U_MAX, "undrained.u_max_pa", "Pa", UNDRAINED)                                                                    \
    X(U_END, "undrained.u_end_pa", "Pa", UNDRAINED)                                                                    \
    X(R_U_MAX, "undrained.r_u_max", "1", UNDRAINED)                                                                    \
    X(PT_EPS, "phase_transformation.eps_zz", "1", UNDRAINED)                                                           \
    X(PT_P, "phase_transformation.p_pa", "Pa", UNDRAINED)                                                              \
    X(PT_Q, "phase_transformation.q_pa", "Pa", UNDRAINED)                                                              \
    X(PT_Q_OVER_P, "phase_transformation.q_over_p", "1", UNDRAINED)                                                    \
    X(LIQUEFACTION_EPS, "liquefaction.eps_zz", "1", UNDRAINED)                                                         \
    X(VOLUME_KEPT, "undrained.volume_change_max", "1", UNDRAINED)                                                      \
    X(K_LOADING, "bulk.K_loading_pa", "Pa", ISOTROPIC)                                                                 \
    X(K_TANGENT, "bulk.K_loading_end_pa", "Pa", ISOTROPIC)                                                             \
    X(K_UNLOADING, "bulk.K_unloading_pa", "Pa", ISOTROPIC)                                                             \
    X(JAMMING_FRACTION, "jamming_fraction", "1", ISOTROPIC)                                                            \
    X(COORDINATION_END, "coordination_end", "1", ISOTROPIC)                                                            \
    X(M_LOADING, "oedometer.M_loading_pa", "Pa", OEDOMETER)                                                            \
    X(M_TANGENT, "oedometer.M_loading_end_pa", "Pa", OEDOMETER)                                                        \
    X(M_UNLOADING, "oedometer.M_unloading_pa", "Pa", OEDOMETER)                                                        \
    X(K0_LOADING, "oedometer.K0_loading", "1", OEDOMETER)                                                              \
    X(K0_UNLOADING, "oedometer.K0_unloading", "1", OEDOMETER)                                                          \
    X(CC, "compression.Cc", "1", COMPRESSION)                                                                          \
    X(CS, "compression.Cs", "1", COMPRESSION)                                                                          \
    X(HELD_STRAIN, "creep.eps_zz_end", "1", CREEP)                                                                     \
    X(HELD_RATE, "creep.rate_end_per_s", "1/s", CREEP)                                                                 \
    X(HELD_TIME, "creep.time_s", "s", CREEP)                                                                           \
    X(RELAXATION_DROP, "relaxation.drop", "1", RELAXATION)                                                             \
    X(RELAXATION_TIME, "relaxation.time_s", "s", RELAXATION)                                                           \
    X(INERTIAL_MEAN, "inertial_number.mean", "1", ANY)                                                                 \
    X(INERTIAL_MAX, "inertial_number.max", "1", ANY)                                                                   \
    X(STRESS_ERROR_MEAN, "stress_error.mean", "1", ANY)                                                                \
    X(STRESS_ERROR_MAX, "stress_error.max", "1", ANY)                                                                  \
    X(KEPT_STRESS, "kept.stress", "1", ANY)                                                                            \
    X(KEPT_VOLUME, "kept.volume", "1", ANY)                                                                            \
    X(KEPT_P, "kept.p", "1", ANY)                                                                                      \
    X(KEPT_Q, "kept.q", "1", ANY)                                                                                      \
    X(KEPT_PATH, "kept.path", "1", ANY)                                                                                \
    X(KEPT_B, "kept.b", "1", ANY)                                                                                      \
    X(ENERGY_RESIDUAL, "energy_residual", "1", ANY)                                                                    \
    X(INTERFACE_RESIDUAL, "interface_residual", "1", ANY)                                                              \
    X(CONTROLLER_RESIDUAL, "controller_residual", "1", ANY)                                                            \
    X(STRESS_DIFFERENCE, "stress_wall_contact_difference", "1", ANY)                                                   \
    X(INITIAL_PHI, "initial.phi", "1", ANY)                                                                            \
    X(INITIAL_COORDINATION, "initial.coordination", "1", ANY)                                                          \
    X(INITIAL_COORDINATION_NO_RATTLERS, "initial.coordination_no_rattlers", "1", ANY)                                  \
    X(CYCLES_FIRST, "cycles.first_cycle_eps_d", "1", CYCLIC)                                                           \
    X(CYCLES_EPS_D, "cycles.eps_d_end", "1", CYCLIC)                                                                   \
    X(CYCLES_EPS_V, "cycles.eps_v_end", "1", CYCLIC)                                                                   \
    X(CYCLES_RATE, "cycles.rate_per_cycle", "1", CYCLIC)                                                               \
    X(CYCLES_EPS_V_RATE, "cycles.eps_v_rate_per_cycle", "1", CYCLIC)                                                   \
    X(CYCLES_RATE_EXPONENT, "cycles.rate_exponent", "1", CYCLIC)                                                       \
    X(CYCLES_ACCUMULATION_FACTOR, "cycles.accumulation_factor", "1", CYCLIC)                                           \
    X(CYCLES_ACCUMULATION_EXPONENT, "cycles.accumulation_exponent", "1", CYCLIC)                                       \
    X(CYCLES_LOOP_AREA, "cycles.loop_area_j_per_m3", "J/m^3", CYCLIC)                                                  \
    X(CYCLES_RESILIENT_MODULUS, "cycles.resilient_modulus_pa", "Pa", CYCLIC)                                           \
    X(CYCLES_SECANT_E, "cycles.secant_E_pa", "Pa", CYCLIC)                                                             \
    X(CYCLES_SECANT_G, "cycles.secant_G_pa", "Pa", CYCLIC)                                                             \
    X(CYCLES_DAMPING_RATIO, "cycles.damping_ratio", "1", CYCLIC)                                                       \
    X(CYCLES_R_U, "cycles.r_u_max", "1", CYCLIC)                                                                       \
    X(CYCLES_LIQUEFACTION, "cycles.to_liquefaction", "1", CYCLIC)                                                      \
    X(CYCLES_STRESS_RATIO, "cycles.stress_ratio", "1", CYCLIC)

enum quantity_id {
#define QUANTITY_ENUM(id, key, unit, tests) QUANTITY_##id,
    QUANTITY_LIST(QUANTITY_ENUM)
#undef QUANTITY_ENUM
        QUANTITIES
};

struct quantity {
    double value;       /* NaN: undefined, `text` says why */
    double uncertainty; /* standard uncertainty; NaN: none can be told */
    bool absent;        /* undefined, as the stage has nothing of that sort: not reported */
    bool has_window;
    double window[2]; /* of axial strain, or of cycles */
    char text[160];   /* reason if undefined, else a note; "" if there is nothing to say */
};

/* Key and unit of a quantity. */
const char *quantity_key(enum quantity_id id);
const char *quantity_unit(enum quantity_id id);

/* True if tests of that kind have the quantity. */
bool quantity_belongs(enum quantity_id id, enum test_kind kind);

/* True if a test of that kind reports the quantity as it is. */
bool quantity_is_reported(enum quantity_id id, enum test_kind kind, const struct quantity *quantity);

/* Marks as undefined, for a reason; as absent, too. */
void quantity_undefined(struct quantity *quantity, const char *format, ...) PRINTF_LIKE(2, 3);
void quantity_absent(struct quantity *quantity, const char *reason);

/* Sets value and uncertainty, without a window; a value that is not finite becomes undefined ("not a finite number").
 */
void quantity_set(struct quantity *quantity, struct estimate estimate);

/* Adds the window [a, b]. */
void quantity_window(struct quantity *quantity, double a, double b);

/* Adds a note. */
void quantity_note(struct quantity *quantity, const char *format, ...) PRINTF_LIKE(2, 3);

#endif
