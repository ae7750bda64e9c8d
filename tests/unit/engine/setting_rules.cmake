emberline_test(setting_rules_test
  SOURCES engine/setting_rules_test.cpp
  LINK emberline_output)
