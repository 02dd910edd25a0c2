# The simulator: parts, kernels, physics, and the real processes with each other.
add_library(sim_fixture STATIC ${CMAKE_CURRENT_LIST_DIR}/sim_fixture.c)
target_link_libraries(sim_fixture PUBLIC shakedown_sim PkgConfig::CMOCKA)
target_include_directories(sim_fixture PUBLIC ${CMAKE_CURRENT_LIST_DIR})

foreach(part contact sample)
  add_executable(test_sim_${part} ${CMAKE_CURRENT_LIST_DIR}/test_sim_${part}.c)
  target_link_libraries(test_sim_${part} PRIVATE sim_fixture)
endforeach()

foreach(part contact sample)
  add_test(NAME sim_${part} COMMAND test_sim_${part})
  set_tests_properties(sim_${part} PROPERTIES LABELS physics TIMEOUT 120)
endforeach()
