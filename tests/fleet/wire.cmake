# Processes of both vendors over real sockets, and the barrier alone, to measure the middleware.
muster_program(wire_peer SOURCES wire_peer.cpp LIBS muster_dds)
muster_program(lockstep_peer SOURCES lockstep_peer.cpp LIBS muster_dds)

add_executable(test_wire wire_test.cpp)
target_compile_options(test_wire PRIVATE ${MUSTER_WARNINGS})
target_compile_definitions(test_wire PRIVATE MUSTER_BIN_DIR="${CMAKE_BINARY_DIR}/bin")
target_link_libraries(test_wire PRIVATE muster_test_main)
add_dependencies(test_wire wire_peer)
set_target_properties(test_wire PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
catch_discover_tests(test_wire TEST_PREFIX "wire: " PROPERTIES LABELS fleet TIMEOUT 900 RUN_SERIAL ON)
