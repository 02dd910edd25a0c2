# The analyzer: estimates against closed forms, the reader against damaged files, and what it writes.
add_library(test_analyzer_fixture STATIC test_analyzer_fixture.c)
target_link_libraries(test_analyzer_fixture PUBLIC shakedown_analyzer PkgConfig::CMOCKA)
foreach(part statistics coverage kinds control_quality judgement mohr shear paths cycles files series)
  add_executable(test_analyzer_${part} test_analyzer_${part}.c)
  target_link_libraries(test_analyzer_${part} PRIVATE test_analyzer_fixture)
  add_test(NAME analyzer_${part} COMMAND test_analyzer_${part} $<TARGET_FILE:analyzer>)
  set_tests_properties(analyzer_${part} PROPERTIES LABELS unit TIMEOUT 120)
endforeach()
