emberline_test(adaptive_planning_test OPTIMISED
  SOURCES drivers/adaptive/allocation_test.cpp drivers/adaptive/denoised_error_test.cpp drivers/adaptive/step_planner_test.cpp drivers/adaptive/frame_error_test.cpp drivers/adaptive/noiseless_window_test.cpp drivers/adaptive/round_averages_test.cpp drivers/adaptive/round_planner_test.cpp
  LINK emberline_engine TBB::tbb)
