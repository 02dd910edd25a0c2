/* The curves of one stage: what curves.csv holds, one value per sample. */
#ifndef SHAKEDOWN_ANALYZER_CURVES_H
#define SHAKEDOWN_ANALYZER_CURVES_H

#include <stddef.h>

#include "analyzer/run_file.h"
#include "analyzer/stage_controls.h"
#include "common/status.h"

/* id, column name. u is p0 - p, p0 of the first sample, and sin_phi that of the mobilised friction, |sigma_zz -
 * sigma_xx|/(sigma_zz + sigma_xx). zz is the axial direction and xx the mean over the lateral ones, whatever the axes
 * are called; compression is positive in stresses and in all strains, eps_v = 1 - V/V0 too. The engineering strains 1 -
 * L/L0 have logarithmic ones -ln(L/L0) beside them, which add up over any path: eps_v_log = -ln(V/V0) is their sum. */
#define CURVE_LIST(X)                                                                                                  \
    X(STEP, "step")                                                                                                    \
    X(TIME, "time_s")                                                                                                  \
    X(STAGE_TIME, "stage_time_s")                                                                                      \
    X(CYCLE, "cycle")                                                                                                  \
    X(EPS_ZZ, "eps_zz")                                                                                                \
    X(EPS_XX, "eps_xx")                                                                                                \
    X(EPS_V, "eps_v")                                                                                                  \
    X(EPS_D, "eps_d")                                                                                                  \
    X(EPS_ZZ_LOG, "eps_zz_log")                                                                                        \
    X(EPS_XX_LOG, "eps_xx_log")                                                                                        \
    X(EPS_V_LOG, "eps_v_log")                                                                                          \
    X(EPS_D_LOG, "eps_d_log")                                                                                          \
    X(SIGMA_ZZ, "sigma_zz_pa")                                                                                         \
    X(SIGMA_XX, "sigma_xx_pa")                                                                                         \
    X(SIGMA_D, "sigma_d_pa")                                                                                           \
    X(P, "p_pa")                                                                                                       \
    X(Q, "q_pa")                                                                                                       \
    X(U, "u_pa")                                                                                                       \
    X(SIGMA_CORR, "sigma_corr_pa")                                                                                     \
    X(STRESS_RATIO, "stress_ratio")                                                                                    \
    X(SIN_PHI, "sin_phi")                                                                                              \
    X(Q_OVER_P, "q_over_p")                                                                                            \
    X(CONTACT_ZZ, "sigma_zz_contact_pa")                                                                               \
    X(CONTACT_XX, "sigma_xx_contact_pa")                                                                               \
    X(SOLID_FRACTION, "solid_fraction")                                                                                \
    X(VOID_RATIO, "void_ratio")                                                                                        \
    X(COORDINATION, "coordination")                                                                                    \
    X(COORDINATION_NO_RATTLERS, "coordination_no_rattlers")                                                            \
    X(RATTLER_FRACTION, "rattler_fraction")                                                                            \
    X(SLIDING_FRACTION, "sliding_fraction")                                                                            \
    X(MAX_OVERLAP_RATIO, "max_overlap_ratio")                                                                          \
    X(INERTIAL_NUMBER, "inertial_number")                                                                              \
    X(FABRIC_MAJOR, "fabric_major")                                                                                    \
    X(FABRIC_MINOR, "fabric_minor")                                                                                    \
    X(FABRIC_ANISOTROPY, "fabric_anisotropy")                                                                          \
    X(FABRIC_ZZ, "fabric_zz")                                                                                          \
    X(KINETIC_ENERGY, "kinetic_energy_j")                                                                              \
    X(WORK, "work_j")                                                                                                  \
    X(ENERGY_RESIDUAL, "energy_residual_j")                                                                            \
    X(INTERFACE_RESIDUAL, "interface_residual_j")                                                                      \
    X(CONTROLLER_RESIDUAL, "controller_residual_j")

enum curve {
#define CURVE_ENUM(id, name) CURVE_##id,
    CURVE_LIST(CURVE_ENUM)
#undef CURVE_ENUM
        CURVES
};

struct curves {
    int dimension;
    int stage;                          /* index in the scene */
    const struct scene_stage *protocol; /* of the run's scene: must outlive the curves */
    struct stage_controls controls;
    size_t n;
    double *column[CURVES];   /* [n] each */
    double stress_difference; /* |sigma_wall - sigma_contact| over |sigma_wall|, rms over axes and samples; NaN */
};

/* The column of axial or volumetric strain in a measure (enum strain_measure). */
enum curve curve_axial_strain(int measure);
enum curve curve_volumetric_strain(int measure);

/* Name of a column, with its unit unless it is 1. */
const char *curve_name(enum curve curve);

/* Extracts the stage scene.analysis.stage of `run`, or stage number `stage`; strains count from its first sample. A
 * stage without samples gives n = 0, which is no error. Release with curves_free. Errors: STATUS_NO_MEMORY. */
enum status curves_extract(struct curves *curves, const struct run *run) MUST_USE;
enum status curves_extract_stage(struct curves *curves, const struct run *run, int stage) MUST_USE;

void curves_free(struct curves *curves);

/* Writes all columns as CSV with one line of names, and the name of the stage as the last column; a value that is not
 * finite is written as nan. STATUS_IO. */
enum status curves_write_csv(const struct curves *curves, const char *path) MUST_USE;

/* The same for all stages of a run, one after the other; strains count from the start of each. */
enum status curves_write_all_csv(const struct run *run, const char *path) MUST_USE;

/* Eigenvalues of a symmetric tensor[dimension][dimension], largest first (2D: closed form; 3D: trigonometric solution
 * of the characteristic equation, Smith 1961). NaN in, NaN out. */
void tensor_eigenvalues(const double *tensor, int dimension, double *eigenvalues);

#endif
