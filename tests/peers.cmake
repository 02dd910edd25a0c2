# The benchmark against peers and the one of accuracy: what they write, read and compute. The peers are not needed.
add_executable(test_peers ${CMAKE_CURRENT_LIST_DIR}/test_peers.c ${PROJECT_SOURCE_DIR}/bench/peers_run.c)
target_link_libraries(test_peers PRIVATE sim_fixture shakedown_bench PkgConfig::JANSSON)
add_test(NAME bench_peers COMMAND test_peers)
set_tests_properties(bench_peers PROPERTIES LABELS unit TIMEOUT 30)

add_test(NAME bench_peers_missing COMMAND ${CMAKE_CURRENT_LIST_DIR}/test_peers.sh)
set_tests_properties(bench_peers_missing PROPERTIES LABELS unit TIMEOUT 30)

add_executable(test_accuracy ${CMAKE_CURRENT_LIST_DIR}/test_accuracy.c)
target_link_libraries(test_accuracy PRIVATE sim_fixture shakedown_bench)
add_test(NAME bench_accuracy COMMAND test_accuracy)
set_tests_properties(bench_accuracy PROPERTIES LABELS unit TIMEOUT 30)

# The impact tests of Chung & Ooi.
add_test(NAME bench_impacts COMMAND ${CMAKE_CURRENT_LIST_DIR}/test_impacts.sh $<TARGET_FILE:bench_impacts>
                                    ${PROJECT_SOURCE_DIR}/scenes/benchmarks $<TARGET_FILE:sim>)
set_tests_properties(bench_impacts PROPERTIES LABELS physics TIMEOUT 60)

# The model of a step on many cores.
add_executable(test_scaling_model ${CMAKE_CURRENT_LIST_DIR}/test_scaling_model.c ${PROJECT_SOURCE_DIR}/bench/scaling_model.c)
target_include_directories(test_scaling_model PRIVATE ${PROJECT_SOURCE_DIR})
target_link_libraries(test_scaling_model PRIVATE PkgConfig::CMOCKA m)
add_test(NAME bench_scaling_model COMMAND test_scaling_model)
set_tests_properties(bench_scaling_model PROPERTIES LABELS unit TIMEOUT 30)
