# Lists of neighbours, their histories, renumbering; threads.
foreach(part neighbor slot_assignment threads thread_team)
  add_executable(test_${part} ${CMAKE_CURRENT_LIST_DIR}/test_${part}.c)
  target_link_libraries(test_${part} PRIVATE sim_fixture)
  add_test(NAME ${part} COMMAND test_${part})
  set_tests_properties(${part} PROPERTIES LABELS unit TIMEOUT 120)
endforeach()
