# The radio of a lab, real time, with a replayed log of poses.
muster_program(lab_peer SOURCES lab_peer.cpp LIBS muster_dds)
add_executable(test_lab lab_test.cpp)
add_dependencies(test_lab lab_peer muster muster-commsim)
target_compile_options(test_lab PRIVATE ${MUSTER_WARNINGS})
target_compile_definitions(test_lab PRIVATE MUSTER_SOURCE_DIR="${CMAKE_SOURCE_DIR}" MUSTER_BIN_DIR="${CMAKE_BINARY_DIR}/bin")
target_link_libraries(test_lab PRIVATE nlohmann_json::nlohmann_json fmt::fmt muster_test_main)
set_target_properties(test_lab PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
catch_discover_tests(test_lab TEST_PREFIX "lab: " PROPERTIES LABELS fleet TIMEOUT 300 RUN_SERIAL TRUE)
