emberline_test(adaptive_planning_test OPTIMISED
  SOURCES allocation_test.cpp denoised_error_test.cpp step_planner_test.cpp frame_error_test.cpp noiseless_window_test.cpp round_averages_test.cpp round_planner_test.cpp
  LINK emberline_engine TBB::tbb)
