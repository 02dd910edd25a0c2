# The driver script and the progress display.
add_executable(test_progress test_progress.c)
target_link_libraries(test_progress PRIVATE shakedown_progress PkgConfig::CMOCKA)
add_test(NAME progress COMMAND test_progress)
set_tests_properties(progress PROPERTIES LABELS unit TIMEOUT 30)

add_executable(test_launcher test_launcher.c)
target_link_libraries(test_launcher PRIVATE shakedown_launcher PkgConfig::CMOCKA)
add_test(NAME launcher COMMAND test_launcher)
set_tests_properties(launcher PROPERTIES LABELS unit TIMEOUT 30)

# It listens: what a folder names as its bus is not opened for writing.
add_test(NAME watch_writes_nothing
         COMMAND sh -c "rm -f watched.lcm; \"$0\" --run-id 1 --lcm 'file://watched.lcm?mode=w' 2>said.txt; [ $? = 2 ] && grep -q 'no bus to listen to' said.txt && [ ! -e watched.lcm ]"
                 $<TARGET_FILE:shakedown-watch>)
set_tests_properties(watch_writes_nothing PROPERTIES LABELS unit TIMEOUT 30)

# Cases with fakes in place of the processes: quick, and every way in which one may end.
foreach(case usage run broken_scene ports interrupt hang failure restart signals orphans controller url private)
  add_test(NAME driver_fake_${case} COMMAND ${CMAKE_CURRENT_LIST_DIR}/test_driver.sh fake_${case})
  set_tests_properties(driver_fake_${case} PROPERTIES LABELS unit TIMEOUT 60 ENVIRONMENT "LAUNCHER=$<TARGET_FILE:launcher>")
endforeach()

# The real processes on scenes/quick.cfg.
foreach(case run in_process broken_scene two_runs interrupt kill_sim kill_evaluation private odd_names repair copied_scene)
  add_test(NAME driver_${case} COMMAND ${CMAKE_CURRENT_LIST_DIR}/test_driver.sh ${case})
  set_tests_properties(driver_${case} PROPERTIES LABELS pipeline TIMEOUT 120 ENVIRONMENT "SHAKEDOWN_BIN=${PROJECT_BINARY_DIR}")
endforeach()

# Who listens to an open run without its key.
add_test(NAME open_readers COMMAND ${CMAKE_CURRENT_LIST_DIR}/test_open_readers.sh ${PROJECT_SOURCE_DIR}/scenes/quick.cfg
         ${PROJECT_SOURCE_DIR}/lcmtypes)
set_tests_properties(open_readers PROPERTIES LABELS pipeline TIMEOUT 120 SKIP_RETURN_CODE 125
                     ENVIRONMENT "SHAKEDOWN_BIN=${PROJECT_BINARY_DIR}")

# A few of the faults of `./shakedown bench faults`, at random moments.
add_test(NAME faults_kills COMMAND ${PROJECT_SOURCE_DIR}/bench/faults.sh --n 1
         --kinds "kill_sim kill_wallctl kill_recorder kill_launcher kill_all")
add_test(NAME faults_signals COMMAND ${PROJECT_SOURCE_DIR}/bench/faults.sh --n 3 --kinds "term_all signal_any")
add_test(NAME faults_disk COMMAND ${PROJECT_SOURCE_DIR}/bench/faults.sh --n 1 --kinds "full_disk read_only folder_removed")
add_test(NAME faults_net COMMAND ${PROJECT_SOURCE_DIR}/bench/faults.sh --n 1 --kinds "loss_20 deaf_20 all_of_it")
add_test(NAME faults_signal_matrix COMMAND ${PROJECT_SOURCE_DIR}/bench/faults.sh --signals
         --kinds "TERM:all:* HUP:wallctl:mid INT:sim:last_flush KILL:recorder:last_flush TERM:all_in_one:last_flush")
set_tests_properties(faults_kills faults_signals faults_disk faults_net faults_signal_matrix PROPERTIES LABELS fault TIMEOUT 300 SKIP_RETURN_CODE 125
                     ENVIRONMENT "SHAKEDOWN_BIN=${PROJECT_BINARY_DIR}")
