# Checkpoints: the file and the state (unit), and runs that are killed and go on (fault, real processes).
add_executable(test_checkpoint ${CMAKE_CURRENT_LIST_DIR}/test_checkpoint.c)
target_link_libraries(test_checkpoint PRIVATE shakedown_sim PkgConfig::CMOCKA)
add_test(NAME checkpoint COMMAND test_checkpoint)
set_tests_properties(checkpoint PROPERTIES LABELS unit TIMEOUT 120)

foreach(case kill_sim kill_all interrupt first_stage no_checkpoint kill_after_end in_process schemes series refused)
  add_test(NAME checkpoint_${case} COMMAND ${CMAKE_CURRENT_LIST_DIR}/test_checkpoint.sh ${case})
  set_tests_properties(checkpoint_${case} PROPERTIES LABELS fault TIMEOUT 120 SKIP_RETURN_CODE 125
                       ENVIRONMENT "SHAKEDOWN_BIN=${PROJECT_BINARY_DIR}")
endforeach()
