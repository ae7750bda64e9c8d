emberline_test(load_progress_test TIMED SOURCES load_progress_test.cpp run_limits_test.cpp
  LINK emberline_app OpenImageIO::OpenImageIO nlohmann_json::nlohmann_json TBB::tbb)
