emberline_test(error_metrics_test
  SOURCES error_metrics_test.cpp flip_test.cpp
  LINK emberline_statistics)
