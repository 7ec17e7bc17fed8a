# Whole flights in memory: safety, in which the radio falls silent, a robot dies, or the operator calls everyone home; skew, in
# which clocks are wrong; lost_journals, in which disks die with their robots.
foreach(name safety skew lost_journals)
  add_executable(test_${name} ${name}_test.cpp)
  target_compile_options(test_${name} PRIVATE ${MUSTER_WARNINGS})
  target_compile_definitions(test_${name} PRIVATE MUSTER_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
  target_link_libraries(test_${name} PRIVATE muster_command muster_test_main)
  set_target_properties(test_${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  catch_discover_tests(test_${name} TEST_PREFIX "${name}: " PROPERTIES LABELS fleet TIMEOUT 600)
endforeach()
