emberline_test(setting_table_test
  SOURCES setting_table_test.cpp
  LINK emberline_drivers nlohmann_json::nlohmann_json)
