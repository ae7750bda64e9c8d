emberline_test(setting_rules_test
  SOURCES setting_rules_test.cpp
  LINK emberline_output)
