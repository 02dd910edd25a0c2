# The simulator: parts, kernels, physics, and the real processes with each other.
add_library(sim_fixture STATIC ${CMAKE_CURRENT_LIST_DIR}/sim_fixture.c)
target_link_libraries(sim_fixture PUBLIC shakedown_sim PkgConfig::CMOCKA)
target_include_directories(sim_fixture PUBLIC ${CMAKE_CURRENT_LIST_DIR})

foreach(part_label contact:physics sample:physics kernels:kernel coupling:physics)
  string(REPLACE ":" ";" part_label ${part_label})
  list(GET part_label 0 part)
  list(GET part_label 1 label)
  add_executable(test_sim_${part} ${CMAKE_CURRENT_LIST_DIR}/test_sim_${part}.c)
  target_link_libraries(test_sim_${part} PRIVATE sim_fixture)
  add_test(NAME sim_${part} COMMAND test_sim_${part})
  set_tests_properties(sim_${part} PROPERTIES LABELS ${label} TIMEOUT 300)
endforeach()

# The real processes. 125: no private network namespace to be had here; in_namespace.sh says why.
add_executable(test_sim_pipeline ${CMAKE_CURRENT_LIST_DIR}/test_sim_pipeline.c)
target_link_libraries(test_sim_pipeline PRIVATE shakedown_common PkgConfig::CMOCKA)
target_compile_definitions(test_sim_pipeline PRIVATE SAME_DATA_SCRIPT="${CMAKE_CURRENT_LIST_DIR}/same_data.sh")
add_test(NAME sim_pipeline
         COMMAND ${CMAKE_CURRENT_LIST_DIR}/in_namespace.sh $<TARGET_FILE:test_sim_pipeline> $<TARGET_FILE:sim>
                 $<TARGET_FILE:wallctl> $<TARGET_FILE:recorder> ${CMAKE_CURRENT_LIST_DIR}/scenes/small.cfg)
set_tests_properties(sim_pipeline PROPERTIES LABELS "pipeline;replay;fault" TIMEOUT 180 SKIP_RETURN_CODE 125)

# Broken scene files.
add_test(NAME sim_bad_scenes
         COMMAND ${CMAKE_CURRENT_LIST_DIR}/test_bad_scenes.sh $<TARGET_FILE:sim> ${CMAKE_CURRENT_LIST_DIR}/bad_scenes
                 ${CMAKE_CURRENT_LIST_DIR}/scenes/small.cfg)
set_tests_properties(sim_bad_scenes PROPERTIES LABELS unit TIMEOUT 60)

# Parts of the simulator, and every scene that is shipped.
file(GLOB SHIPPED_SCENES CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/scenes/*.cfg
     ${PROJECT_SOURCE_DIR}/scenes/benchmarks/*.cfg ${PROJECT_SOURCE_DIR}/bench/*.cfg)
add_executable(test_sim_unit ${CMAKE_CURRENT_LIST_DIR}/test_sim_unit.c)
target_link_libraries(test_sim_unit PRIVATE sim_fixture)
add_test(NAME sim_unit COMMAND test_sim_unit ${CMAKE_CURRENT_LIST_DIR}/scenes/small.cfg ${SHIPPED_SCENES})
set_tests_properties(sim_unit PROPERTIES LABELS unit TIMEOUT 120)

# The arrows between our files.
add_test(NAME includes COMMAND ${CMAKE_CURRENT_LIST_DIR}/test_includes.sh ${PROJECT_SOURCE_DIR})
set_tests_properties(includes PROPERTIES LABELS unit TIMEOUT 60)

# Contact laws beyond the two papers, and walls of a material of their own, against closed forms.
foreach(law hertz elastoplastic wall_material rolling)
  add_executable(test_${law} ${CMAKE_CURRENT_LIST_DIR}/test_${law}.c)
  target_link_libraries(test_${law} PRIVATE sim_fixture)
  add_test(NAME ${law} COMMAND test_${law})
  set_tests_properties(${law} PROPERTIES LABELS physics TIMEOUT 120)
endforeach()

# Scenes that look sound and are not.
add_test(NAME verdict COMMAND ${CMAKE_CURRENT_LIST_DIR}/test_verdict.sh $<TARGET_FILE:sim>
                              ${CMAKE_CURRENT_LIST_DIR}/verdict)
set_tests_properties(verdict PROPERTIES LABELS physics TIMEOUT 120)
add_test(NAME odd_scenes COMMAND bench_odd_scenes $<TARGET_FILE:sim> ${CMAKE_CURRENT_BINARY_DIR}/odd 25 7 60)
set_tests_properties(odd_scenes PROPERTIES LABELS physics TIMEOUT 300)
add_executable(test_judge ${CMAKE_CURRENT_LIST_DIR}/test_judge.c)
target_link_libraries(test_judge PRIVATE sim_fixture)
add_test(NAME judge COMMAND test_judge)
set_tests_properties(judge PROPERTIES LABELS physics TIMEOUT 60)

# Samples from a table of grains.
add_executable(test_grain_file ${CMAKE_CURRENT_LIST_DIR}/test_grain_file.c)
target_link_libraries(test_grain_file PRIVATE sim_fixture)
add_test(NAME grain_file COMMAND test_grain_file)
set_tests_properties(grain_file PROPERTIES LABELS unit TIMEOUT 30)
add_test(NAME grains_kept COMMAND ${CMAKE_CURRENT_LIST_DIR}/test_grains_kept.sh $<TARGET_FILE:launcher> $<TARGET_FILE:sim>)
set_tests_properties(grains_kept PROPERTIES LABELS replay TIMEOUT 60)
add_executable(test_size_distribution ${CMAKE_CURRENT_LIST_DIR}/test_size_distribution.c)
target_link_libraries(test_size_distribution PRIVATE sim_fixture)
add_test(NAME size_distribution COMMAND test_size_distribution)
set_tests_properties(size_distribution PROPERTIES LABELS unit TIMEOUT 60)
add_executable(test_prepare ${CMAKE_CURRENT_LIST_DIR}/test_prepare.c)
target_link_libraries(test_prepare PRIVATE sim_fixture)
add_test(NAME prepare COMMAND test_prepare)
set_tests_properties(prepare PROPERTIES LABELS physics TIMEOUT 120)

# What explain computes.
add_test(NAME explain COMMAND ${CMAKE_CURRENT_LIST_DIR}/test_explain.sh $<TARGET_FILE:sim> ${PROJECT_SOURCE_DIR}/scenes)
set_tests_properties(explain PROPERTIES LABELS unit TIMEOUT 60)
