# The recorder: without a bus (unit), with its real process on logs, on full disks and when killed, and over UDP in a
# network namespace of its own.
add_library(test_recorder_support STATIC test_recorder_synthetic.c test_recorder_read.c)
target_link_libraries(test_recorder_support PUBLIC shakedown_recorder PkgConfig::CMOCKA)

foreach(name test_recorder test_recorder_log test_recorder_fault test_recorder_bus test_record_proof)
  add_executable(${name} ${name}.c)
  target_link_libraries(${name} PRIVATE test_recorder_support)
endforeach()

add_test(NAME recorder COMMAND test_recorder)
set_tests_properties(recorder PROPERTIES LABELS unit TIMEOUT 120)

add_test(NAME record_proof COMMAND test_record_proof)
set_tests_properties(record_proof PROPERTIES LABELS unit TIMEOUT 30)

add_test(NAME recorder_log COMMAND test_recorder_log)
set_tests_properties(recorder_log PROPERTIES LABELS replay TIMEOUT 120)

add_test(NAME recorder_fault COMMAND test_recorder_fault $<TARGET_FILE:recorder>)
set_tests_properties(recorder_fault PROPERTIES LABELS fault TIMEOUT 120)

# 125: no private network namespace to be had here; in_namespace.sh says why.
add_test(NAME recorder_bus COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/in_namespace.sh $<TARGET_FILE:test_recorder_bus>
                                    $<TARGET_FILE:recorder>)
set_tests_properties(recorder_bus PROPERTIES LABELS pipeline TIMEOUT 120 SKIP_RETURN_CODE 125)

add_test(NAME recorder_full
         COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/in_namespace.sh ${CMAKE_CURRENT_SOURCE_DIR}/test_recorder_full.sh
                 $<TARGET_FILE:sim> $<TARGET_FILE:wallctl> $<TARGET_FILE:recorder> ${PROJECT_SOURCE_DIR}/scenes/quick.cfg)
set_tests_properties(recorder_full PROPERTIES LABELS fault TIMEOUT 120 SKIP_RETURN_CODE 125)

add_test(NAME readers COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/test_readers.sh $<TARGET_FILE:sim> $<TARGET_FILE:recorder>
                              ${PROJECT_SOURCE_DIR}/scenes/quick.cfg ${PROJECT_SOURCE_DIR}/docs/reading.md)
set_tests_properties(readers PROPERTIES LABELS pipeline TIMEOUT 120 SKIP_RETURN_CODE 125)

foreach(name recorder_fault recorder_bus)
  set_property(TEST ${name} PROPERTY ENVIRONMENT
               "LSAN_OPTIONS=print_suppressions=0:suppressions=${CMAKE_CURRENT_SOURCE_DIR}/recorder_leaks.supp")
endforeach()

add_test(NAME export COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/test_export.sh $<TARGET_FILE:sim> $<TARGET_FILE:recorder>
                             $<TARGET_FILE:shakedown-export> ${PROJECT_SOURCE_DIR}/scenes/triaxial_quick.cfg)
set_tests_properties(export PROPERTIES LABELS pipeline TIMEOUT 120 SKIP_RETURN_CODE 125)

# Simulator and recorder in one program: what frames say of the contacts' history.
add_executable(test_frames test_frames.c)
target_link_libraries(test_frames PRIVATE sim_fixture test_recorder_support)
add_test(NAME frames COMMAND test_frames)
set_tests_properties(frames PROPERTIES LABELS unit TIMEOUT 120)
