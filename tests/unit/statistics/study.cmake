emberline_test(study_test
  SOURCES statistics/study_summary_test.cpp statistics/reference_error_test.cpp
  LINK emberline_statistics)
