# ./shakedown bench coupling, in a network namespace of its own, on a scene of a second. No time is judged.
add_executable(test_bench_coupling ${CMAKE_CURRENT_LIST_DIR}/test_bench_coupling.c)
target_link_libraries(test_bench_coupling PRIVATE PkgConfig::JANSSON PkgConfig::CMOCKA)
foreach(case report shipped failing_runs usage)
  add_test(NAME bench_coupling_${case} COMMAND ${CMAKE_CURRENT_LIST_DIR}/test_bench_coupling.sh ${case})
  set_tests_properties(bench_coupling_${case} PROPERTIES LABELS pipeline TIMEOUT 180 PROCESSORS 2 ENVIRONMENT "SHAKEDOWN_BIN=${PROJECT_BINARY_DIR}")
endforeach()
