#include "bench/element_tests.h"

#include <string.h>

const struct element_test element_tests[] = {
    {"isotropic",
     "isotropic compression",
     false,
     {"stages.2.walls.x.pressure_end_pa=1500.0", "stages.2.walls.y.pressure_end_pa=1500.0",
      "stages.2.walls.z.pressure_end_pa=1500.0", "stages.2.walls.x.ramp_s=0.2", "stages.2.walls.y.ramp_s=0.2",
      "stages.2.walls.z.ramp_s=0.2", "stages.3.walls.x.pressure_pa=1500.0", "stages.3.walls.y.pressure_pa=1500.0",
      "stages.3.walls.z.pressure_pa=1500.0", "stages.3.walls.x.ramp_s=0.2", "stages.3.walls.y.ramp_s=0.2",
      "stages.3.walls.z.ramp_s=0.2"}},
    {"oedometer",
     "oedometer",
     false,
     {"stages.2.walls.z.until_stress_pa=2000.0", "stages.3.walls.z.until_stress_pa=[1500.0, 1e5]",
      "stages.4.walls.z.until_stress_pa=2000.0"}},
    {"triaxial_compression",
     "drained compression",
     false,
     {"stages.2.walls.z.strain=0.005", "stages.2.duration_s=0.4", "stages.2.frame_strains=[0.0]"}},
    {"triaxial_extension", "drained extension", false, {"stages.2.walls.z.strain=-0.005"}},
    {"mohr_coulomb", "Mohr-Coulomb series", false, {"stages.2.walls.z.strain=0.005"}},
    {"constant_volume", "constant volume", false, {"stages.2.walls.z.strain=0.003"}},
    {"constant_p", "constant p", false, {"stages.2.walls.z.strain=0.003"}},
    {"constant_b", "true triaxial, b = 0.5", false, {"stages.2.walls.z.strain=0.003"}},
    {"stress_path", "straight path", false, {"stages.2.until_q_pa=80.0"}},
    {"cyclic_stress", "stress cycles", false, {"stages.2.until_cycles=1"}},
    {"cyclic_strain", "strain cycles", false, {"stages.2.until_cycles=1"}},
    {"cyclic_undrained",
     "stress cycles, constant V",
     false,
     {"stages.2.until_cycles=1", "stages.3.until_cycles=1", "stages.3.walls.z.strain=1e-4"}},
    {"cyclic_undrained_strain", "strain cycles, constant V", false, {"stages.2.until_cycles=1"}},
    {"creep",
     "creep",
     false,
     {"stages.2.walls.z.pressure_end_pa=1200.0", "stages.2.walls.z.ramp_s=0.2", "stages.3.walls.z.pressure_pa=1200.0",
      "stages.3.duration_s=0.2"}},
    {"relaxation", "relaxation", false, {"stages.2.walls.z.strain=0.005", "stages.3.duration_s=0.2"}},
    {"quick", "biaxial, fast", true, {NULL}},
    {"triaxial_quick", "stress cycles, fast", true, {NULL}},
    {"biaxial", "biaxial [LH]", true, {NULL}},
    {"biaxial_friction", "biaxial [D]", true, {NULL}},
    {"triaxial_cyclic", "stress cycles [D]", true, {NULL}},
};
const int element_tests_count = sizeof element_tests / sizeof element_tests[0];

const struct element_test *element_test_find(const char *scene)
{
    for (int k = 0; k < element_tests_count; k++)
        if (strcmp(element_tests[k].scene, scene) == 0)
            return &element_tests[k];
    return NULL;
}
