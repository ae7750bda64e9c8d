emberline_test(study_test
  SOURCES study_summary_test.cpp
  LINK emberline_statistics)
