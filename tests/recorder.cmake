# The recorder: without a bus (unit), with its real process on logs, on full disks and when killed, and over UDP in a
# network namespace of its own.
add_library(test_recorder_support STATIC test_recorder_synthetic.c test_recorder_read.c)
target_link_libraries(test_recorder_support PUBLIC shakedown_recorder PkgConfig::CMOCKA)

foreach(name test_recorder)
  add_executable(${name} ${name}.c)
  target_link_libraries(${name} PRIVATE test_recorder_support)
endforeach()

add_test(NAME recorder COMMAND test_recorder)
set_tests_properties(recorder PROPERTIES LABELS unit TIMEOUT 120)
