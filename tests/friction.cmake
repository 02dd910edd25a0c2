# Friction: single contacts against closed forms; packed samples, cycles and hard cases.
foreach(part contact sample scheme)
  add_executable(test_friction_${part} ${CMAKE_CURRENT_LIST_DIR}/test_friction_${part}.c)
  target_link_libraries(test_friction_${part} PRIVATE sim_fixture)
  target_compile_definitions(test_friction_${part} PRIVATE SCENES="${PROJECT_SOURCE_DIR}/scenes")
  add_test(NAME friction_${part} COMMAND test_friction_${part})
  set_tests_properties(friction_${part} PROPERTIES LABELS physics TIMEOUT 240)
endforeach()

# No hidden scales, and friction that is switched on; what the dashpot may do; particles that nothing touches.
foreach(part scales dashpot free_flight)
  add_executable(test_${part} ${CMAKE_CURRENT_LIST_DIR}/test_${part}.c)
  target_link_libraries(test_${part} PRIVATE sim_fixture)
  add_test(NAME ${part} COMMAND test_${part})
  set_tests_properties(${part} PROPERTIES LABELS physics TIMEOUT 240)
endforeach()
