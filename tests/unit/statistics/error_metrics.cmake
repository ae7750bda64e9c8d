emberline_test(error_metrics_test
  SOURCES statistics/error_metrics_test.cpp statistics/flip_test.cpp
  LINK emberline_statistics)
