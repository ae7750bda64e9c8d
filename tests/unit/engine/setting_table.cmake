emberline_test(setting_table_test
  SOURCES engine/setting_table_test.cpp
  LINK emberline_engine nlohmann_json::nlohmann_json)
