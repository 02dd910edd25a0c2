#include "recorder/message_columns.h"

#include "common/message.h"

#define FIELD(struct_, name, type, width, unit)                                                                        \
    {                                                                                                                  \
#name, unit, offsetof(shakedown_##struct_##_t, name), FIELD_##type, WIDTH_##width                              \
    }
#define SAMPLE(name, type, width, unit)  FIELD(sample, name, type, width, unit)
#define STATE(name, type, width, unit)   FIELD(wall_state, name, type, width, unit)
#define COMMAND(name, type, width, unit) FIELD(wall_command, name, type, width, unit)

const struct field sample_fields[] = {
    SAMPLE(step, I64, ONE, "1"),
    SAMPLE(time_s, F64, ONE, "s"),
    SAMPLE(stage, I32, ONE, "1"),
    SAMPLE(stage_end_before, I32, ONE, "1"),
    SAMPLE(stage_time_s, F64, ONE, "s"),
    SAMPLE(box_length_m, F64, AXES, "m"),
    SAMPLE(strain, F64, AXES, "1"),
    SAMPLE(stress_wall_pa, F64, AXES, "N/m^2"),
    SAMPLE(stress_contact_pa, F64, TENSOR, "N/m^2"),
    SAMPLE(fabric, F64, TENSOR, "1"),
    SAMPLE(wall_position_m, F64, WALLS, "m"),
    SAMPLE(wall_velocity_m_per_s, F64, WALLS, "m/s"),
    SAMPLE(wall_force_n, F64, WALLS, "N"),
    SAMPLE(solid_fraction, F64, ONE, "1"),
    SAMPLE(coordination, F64, ONE, "1"),
    SAMPLE(coordination_no_rattlers, F64, ONE, "1"),
    SAMPLE(rattler_fraction, F64, ONE, "1"),
    SAMPLE(n_contacts, I32, ONE, "1"),
    SAMPLE(n_wall_contacts, I32, ONE, "1"),
    SAMPLE(sliding_fraction, F64, ONE, "1"),
    SAMPLE(max_overlap_ratio, F64, ONE, "1"),
    SAMPLE(inertial_number, F64, ONE, "1"),
    SAMPLE(kinetic_energy_j, F64, ONE, "J"),
    SAMPLE(elastic_energy_normal_j, F64, ONE, "J"),
    SAMPLE(elastic_energy_tangential_j, F64, ONE, "J"),
    SAMPLE(work_walls_j, F64, ONE, "J"),
    SAMPLE(work_gravity_j, F64, ONE, "J"),
    SAMPLE(work_material_j, F64, ONE, "J"),
    SAMPLE(dissipated_hysteresis_j, F64, ONE, "J"),
    SAMPLE(dissipated_viscous_normal_j, F64, ONE, "J"),
    SAMPLE(dissipated_viscous_tangential_j, F64, ONE, "J"),
    SAMPLE(dissipated_friction_j, F64, ONE, "J"),
    SAMPLE(dissipated_stiffness_j, F64, ONE, "J"),
    SAMPLE(dissipated_rolling_j, F64, ONE, "J"),
    SAMPLE(dissipated_viscous_rolling_j, F64, ONE, "J"),
    SAMPLE(dissipated_background_j, F64, ONE, "J"),
    SAMPLE(energy_residual_j, F64, ONE, "J"),
    SAMPLE(interface_residual_j, F64, ONE, "J"),
    SAMPLE(controller_residual_j, F64, ONE, "J"),
    {NULL, NULL, 0, FIELD_I8, WIDTH_ONE},
};

const struct field wall_state_fields[] = {
    STATE(seq, I64, ONE, "1"),
    STATE(step, I64, ONE, "1"),
    STATE(time_s, F64, ONE, "s"),
    STATE(stage, I32, ONE, "1"),
    STATE(stage_step, I64, ONE, "1"),
    STATE(stage_time_s, F64, ONE, "s"),
    STATE(interval_s, F64, ONE, "s"),
    STATE(kinetic_energy_j, F64, ONE, "J"),
    STATE(elastic_energy_j, F64, ONE, "J"),
    STATE(energy_step, I64, ONE, "1"),
    STATE(command_step, I64, ONE, "1"),
    STATE(interface_residual_j, F64, ONE, "J"),
    STATE(interface_error, F64, ONE, "1"),
    STATE(interface_error_before, F64, ONE, "1"),
    STATE(position_m, F64, WALLS, "m"),
    STATE(velocity_m_per_s, F64, WALLS, "m/s"),
    STATE(acceleration_m_per_s2, F64, WALLS, "m/s^2"),
    STATE(force_n, F64, WALLS, "N"),
    STATE(stiffness_n_per_m, F64, WALLS, "N/m"),
    STATE(damping_kg_per_s, F64, WALLS, "kg/s"),
    STATE(stage_position_m, F64, WALLS, "m"),
    STATE(force_before_n, F64, WALLS, "N"),
    STATE(ahead_position_m, F64, WALLS, "m"),
    STATE(ahead_velocity_m_per_s, F64, WALLS, "m/s"),
    {NULL, NULL, 0, FIELD_I8, WIDTH_ONE},
};

const struct field wall_command_fields[] = {
    COMMAND(seq, I64, ONE, "1"),
    COMMAND(step, I64, ONE, "1"),
    COMMAND(time_s, F64, ONE, "s"),
    COMMAND(stage, I32, ONE, "1"),
    COMMAND(finished, I8, ONE, "1"),
    COMMAND(ended, I32, ONE, "1"),
    COMMAND(measure, I8, ONE, "1"),
    COMMAND(n_steps, I32, ONE, "1"),
    COMMAND(fraction_done, F64, ONE, "1"),
    COMMAND(drive, I32, WALLS, "1"),
    COMMAND(position_m, F64, WALLS, "m"),
    COMMAND(velocity_m_per_s, F64, WALLS, "m/s"),
    COMMAND(acceleration_m_per_s2, F64, WALLS, "m/s^2"),
    COMMAND(force_n, F64, WALLS, "N"),
    COMMAND(force_rate_n_per_s, F64, WALLS, "N/s"),
    COMMAND(force_rate2_n_per_s2, F64, WALLS, "N/s^2"),
    COMMAND(mass_kg, F64, WALLS, "kg"),
    COMMAND(damping_kg_per_s, F64, WALLS, "kg/s"),
    {NULL, NULL, 0, FIELD_I8, WIDTH_ONE},
};
