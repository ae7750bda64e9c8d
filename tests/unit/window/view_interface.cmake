emberline_test(view_interface_test
  SOURCES
    window/panels/edit_entries_test.cpp
    window/input/edit_latency_test.cpp
    window/picture/histogram_test.cpp
    window/panels/material_rows_test.cpp
    window/picture/picture_placement_test.cpp
    window/panels/time_line_test.cpp
    window/window_state_test.cpp
  LINK emberline_window_parts)

if(EMBERLINE_HAS_WINDOW)
  emberline_test(input_test SOURCES window/input/input_test.cpp LINK emberline_window glfw)
endif()

emberline_test(workbench_test TIMED TIMEOUT 300 SOURCES window/workbench/workbench_test.cpp LINK emberline_window_parts)
target_compile_definitions(workbench_test PRIVATE EMBERLINE_SCENES="${CMAKE_SOURCE_DIR}/scenes")
