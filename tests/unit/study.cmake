emberline_test(study_test
  SOURCES study_summary_test.cpp reference_error_test.cpp
  LINK emberline_statistics)
