# The driver script and the progress display.
add_executable(test_progress test_progress.c)
target_link_libraries(test_progress PRIVATE shakedown_progress PkgConfig::CMOCKA)
add_test(NAME progress COMMAND test_progress)
set_tests_properties(progress PROPERTIES LABELS unit TIMEOUT 30)
