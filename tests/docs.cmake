# The documentation against the code, and against itself. `docs` makes again what is generated.
foreach(case reference channels links history commands guards)
  add_test(NAME docs_${case}
           COMMAND ${CMAKE_CURRENT_LIST_DIR}/test_docs.sh ${case} ${PROJECT_SOURCE_DIR} $<TARGET_FILE:sim>)
  set_tests_properties(docs_${case} PROPERTIES LABELS unit TIMEOUT 120)
endforeach()

add_custom_target(docs COMMAND sh -c "$<TARGET_FILE:sim> --reference >${PROJECT_SOURCE_DIR}/docs/scene-reference.md"
                  DEPENDS sim VERBATIM COMMENT "docs/scene-reference.md")
