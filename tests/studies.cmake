# Studies: what is planned, evaluated and drawn; and whole small ones with the real programs.
add_executable(test_studies test_studies.c)
target_link_libraries(test_studies PRIVATE shakedown_studies PkgConfig::CMOCKA)
add_test(NAME studies COMMAND test_studies ${PROJECT_SOURCE_DIR})
set_tests_properties(studies PROPERTIES LABELS unit TIMEOUT 60)

foreach(case shipped report score pictures browser)
  add_test(NAME studies_${case} COMMAND ${CMAKE_CURRENT_LIST_DIR}/test_studies.sh ${case})
  set_tests_properties(studies_${case} PROPERTIES LABELS pipeline TIMEOUT 120 SKIP_RETURN_CODE 125 ENVIRONMENT "SHAKEDOWN_BIN=${PROJECT_BINARY_DIR}")
endforeach()
foreach(case killed changed failing)
  add_test(NAME studies_${case} COMMAND ${CMAKE_CURRENT_LIST_DIR}/test_studies.sh ${case})
  set_tests_properties(studies_${case} PROPERTIES LABELS fault TIMEOUT 120 ENVIRONMENT "SHAKEDOWN_BIN=${PROJECT_BINARY_DIR}")
endforeach()

# On a real Slurm; skipped where it is not installed.
foreach(case array failing killed)
  add_test(NAME studies_slurm_${case} COMMAND ${CMAKE_CURRENT_LIST_DIR}/test_studies_slurm.sh ${case})
  set_tests_properties(studies_slurm_${case} PROPERTIES LABELS fault TIMEOUT 240 SKIP_RETURN_CODE 125
                       ENVIRONMENT "SHAKEDOWN_BIN=${PROJECT_BINARY_DIR}")
endforeach()
