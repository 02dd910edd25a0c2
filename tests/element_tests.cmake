# The shipped scenes in short forms: each keeps what it is to keep, slowly enough, and ends sound; and at an exchange in
# every step the bus and one process come to the same bits.
add_test(NAME element_tests COMMAND ${PROJECT_SOURCE_DIR}/bench/element-tests.sh --quick)
add_test(NAME element_tests_exact COMMAND ${PROJECT_SOURCE_DIR}/bench/element-tests.sh --exact)
# A scene that cannot keep to the bounds says so: walls a thousand times as heavy.
add_test(NAME element_tests_heavy COMMAND ${PROJECT_SOURCE_DIR}/bench/element-tests.sh --quick triaxial_extension
         --set stages.2.walls.x.mass_kg=1.0 --set stages.2.walls.y.mass_kg=1.0)
set_tests_properties(element_tests_heavy PROPERTIES PASS_REGULAR_EXPRESSION "stress [0-9.e-]+ \\(1e-03: BEYOND\\)")
foreach(test element_tests element_tests_exact element_tests_heavy)
  set_tests_properties(${test} PROPERTIES LABELS pipeline TIMEOUT 300 SKIP_RETURN_CODE 125
                       ENVIRONMENT "SHAKEDOWN_BIN=${PROJECT_BINARY_DIR}")
endforeach()

# What is evaluated against closed forms and by hand.
add_test(NAME fcc_strength COMMAND ${CMAKE_CURRENT_LIST_DIR}/test_fcc.sh)
set_tests_properties(fcc_strength PROPERTIES LABELS physics TIMEOUT 120 ENVIRONMENT "SHAKEDOWN_BIN=${PROJECT_BINARY_DIR}")
add_test(NAME bulk_modulus COMMAND ${CMAKE_CURRENT_LIST_DIR}/test_bulk_modulus.sh)
set_tests_properties(bulk_modulus PROPERTIES LABELS pipeline TIMEOUT 120 ENVIRONMENT "SHAKEDOWN_BIN=${PROJECT_BINARY_DIR}")

# Small scenes whose evaluation once said nothing, or something wrong.
add_test(NAME odd_evaluations COMMAND ${CMAKE_CURRENT_LIST_DIR}/test_odd_evaluations.sh)
set_tests_properties(odd_evaluations PROPERTIES LABELS pipeline TIMEOUT 120 ENVIRONMENT "SHAKEDOWN_BIN=${PROJECT_BINARY_DIR}")
