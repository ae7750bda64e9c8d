emberline_test(view_interface_test
  SOURCES
    edit_entries_test.cpp
    edit_latency_test.cpp
    histogram_test.cpp
    material_rows_test.cpp
    picture_placement_test.cpp
    time_line_test.cpp
    window_state_test.cpp
  LINK emberline_window_parts)

if(EMBERLINE_HAS_WINDOW)
  emberline_test(input_test SOURCES input_test.cpp LINK emberline_window glfw)
endif()

emberline_test(workbench_test TIMED TIMEOUT 300 SOURCES workbench_test.cpp LINK emberline_window_parts)
target_compile_definitions(workbench_test PRIVATE EMBERLINE_SCENES="${CMAKE_SOURCE_DIR}/scenes")
