# The control law, the bus and the record stream, and the process wallctl.
set(IN_NAMESPACE ${CMAKE_CURRENT_LIST_DIR}/in_namespace.sh)

add_library(wall_fixture STATIC ${CMAKE_CURRENT_LIST_DIR}/wall_fixture.c)
target_link_libraries(wall_fixture PUBLIC shakedown_law PkgConfig::CMOCKA)
target_include_directories(wall_fixture PUBLIC ${CMAKE_CURRENT_LIST_DIR})

add_executable(test_law ${CMAKE_CURRENT_LIST_DIR}/test_law.c)
target_link_libraries(test_law PRIVATE wall_fixture)
add_test(NAME law COMMAND test_law)
set_tests_properties(law PROPERTIES LABELS "unit;physics" TIMEOUT 30)

add_executable(test_wall_command ${CMAKE_CURRENT_LIST_DIR}/test_wall_command.c)
target_link_libraries(test_wall_command PRIVATE wall_fixture)
add_test(NAME wall_command COMMAND test_wall_command)
set_tests_properties(wall_command PROPERTIES LABELS "unit;physics" TIMEOUT 30)

add_executable(test_scene ${CMAKE_CURRENT_LIST_DIR}/test_scene.c)
target_link_libraries(test_scene PRIVATE shakedown_common PkgConfig::CMOCKA)
add_test(NAME scene COMMAND test_scene)
set_tests_properties(scene PROPERTIES LABELS unit TIMEOUT 30)

add_executable(test_bus ${CMAKE_CURRENT_LIST_DIR}/test_bus.c)
target_link_libraries(test_bus PRIVATE shakedown_common PkgConfig::CMOCKA)
add_test(NAME bus COMMAND ${IN_NAMESPACE} $<TARGET_FILE:test_bus>)
set_tests_properties(bus PROPERTIES LABELS unit TIMEOUT 60)

add_executable(test_wallctl ${CMAKE_CURRENT_LIST_DIR}/test_wallctl.c)
target_link_libraries(test_wallctl PRIVATE wall_fixture shakedown_wallctl)
add_test(NAME wallctl COMMAND ${IN_NAMESPACE} $<TARGET_FILE:test_wallctl> $<TARGET_FILE:wallctl>)
set_tests_properties(wallctl PROPERTIES LABELS "pipeline;replay;fault" TIMEOUT 120)

if(SHAKEDOWN_SANITIZE MATCHES thread)
  set_tests_properties(bus wallctl PROPERTIES ENVIRONMENT
                       TSAN_OPTIONS=suppressions=${CMAKE_CURRENT_LIST_DIR}/tsan.supp)
endif()

add_executable(test_command_check ${CMAKE_CURRENT_LIST_DIR}/test_command_check.c)
target_link_libraries(test_command_check PRIVATE wall_fixture shakedown_sim)
add_test(NAME command_check COMMAND test_command_check)
set_tests_properties(command_check PROPERTIES LABELS unit TIMEOUT 30)

# A controller of one's own in place of wallctl, through the whole pipeline.
add_test(NAME example_controller COMMAND ${CMAKE_CURRENT_LIST_DIR}/test_example_controller.sh
         $<TARGET_FILE:example-controller>)
set_tests_properties(example_controller PROPERTIES LABELS pipeline TIMEOUT 120
                     ENVIRONMENT "SHAKEDOWN_BIN=${PROJECT_BINARY_DIR}")
add_test(NAME example_controller_java COMMAND ${CMAKE_CURRENT_LIST_DIR}/test_example_java.sh)
set_tests_properties(example_controller_java PROPERTIES LABELS pipeline TIMEOUT 120 SKIP_RETURN_CODE 125
                     ENVIRONMENT "SHAKEDOWN_BIN=${PROJECT_BINARY_DIR}")
