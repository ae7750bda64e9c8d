emberline_test(error_estimators_test
  SOURCES error_estimators_test.cpp error_estimator_statistics_test.cpp error_metric_test.cpp
          pixel_statistics_test.cpp planning_order_test.cpp sample_halves_test.cpp two_stream_estimator_test.cpp
  LINK emberline_engine TBB::tbb)
