emberline_test(error_estimators_test
  SOURCES drivers/adaptive/error_estimators_test.cpp drivers/adaptive/error_estimator_statistics_test.cpp drivers/adaptive/error_metric_test.cpp
          drivers/adaptive/pixel_statistics_test.cpp drivers/adaptive/planning_order_test.cpp drivers/adaptive/sample_halves_test.cpp drivers/adaptive/two_stream_estimator_test.cpp
  LINK emberline_engine TBB::tbb)
