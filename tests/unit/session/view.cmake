emberline_test(view_arithmetic_test
  SOURCES session/view_camera_test.cpp session/edit_history_test.cpp session/grading_test.cpp
  LINK emberline_session)
emberline_test(render_session_test TIMED TIMEOUT 300
  SOURCES session/render_session_test.cpp session/session_storm_test.cpp session/session_edits_test.cpp session/session_files_test.cpp
          session/session_overlay_test.cpp session/session_comparison_test.cpp session/session_bucket_test.cpp
          session/session_time_test.cpp session/session_denoise_test.cpp
  LINK emberline_app emberline_session)
target_compile_definitions(render_session_test
  PRIVATE EMBERLINE_SCENES="${CMAKE_SOURCE_DIR}/scenes")
