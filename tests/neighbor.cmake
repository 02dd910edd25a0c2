# Lists of neighbours, their histories, and renumbering.
add_executable(test_neighbor ${CMAKE_CURRENT_LIST_DIR}/test_neighbor.c)
target_link_libraries(test_neighbor PRIVATE sim_fixture)
add_test(NAME neighbor COMMAND test_neighbor)
set_tests_properties(neighbor PROPERTIES LABELS unit TIMEOUT 120)
