# Whole flights in memory in which the radio falls silent, a robot dies, or the operator calls everyone home.
add_executable(test_safety safety_test.cpp)
target_compile_options(test_safety PRIVATE ${MUSTER_WARNINGS})
target_compile_definitions(test_safety PRIVATE MUSTER_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
target_link_libraries(test_safety PRIVATE muster_command muster_test_main)
set_target_properties(test_safety PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
catch_discover_tests(test_safety TEST_PREFIX "safety: " PROPERTIES LABELS fleet TIMEOUT 600)

# Clocks that are wrong.
add_executable(test_skew skew_test.cpp)
target_compile_options(test_skew PRIVATE ${MUSTER_WARNINGS})
target_compile_definitions(test_skew PRIVATE MUSTER_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
target_link_libraries(test_skew PRIVATE muster_command muster_test_main)
set_target_properties(test_skew PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
catch_discover_tests(test_skew TEST_PREFIX "skew: " PROPERTIES LABELS fleet TIMEOUT 600)
