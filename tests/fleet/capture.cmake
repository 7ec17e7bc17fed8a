# Packets of both vendors as tshark shows them with muster.lua.
add_executable(test_capture capture_test.cpp)
add_dependencies(test_capture muster_lua)
target_compile_options(test_capture PRIVATE ${MUSTER_WARNINGS})
target_compile_definitions(test_capture PRIVATE MUSTER_LUA="${CMAKE_BINARY_DIR}/deploy/wireshark/muster.lua")
target_link_libraries(test_capture PRIVATE muster_command muster_test_main)
set_target_properties(test_capture PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
catch_discover_tests(test_capture TEST_PREFIX "capture: " PROPERTIES LABELS fleet TIMEOUT 300 RUN_SERIAL ON)
