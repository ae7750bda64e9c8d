emberline_test(load_progress_test TIMED SOURCES core/load_progress_test.cpp engine/run_limits_test.cpp
  LINK emberline_app OpenImageIO::OpenImageIO nlohmann_json::nlohmann_json TBB::tbb)
