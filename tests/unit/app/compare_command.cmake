emberline_test(compare_command_test
  SOURCES app/compare_command_test.cpp
  LINK emberline_app nlohmann_json::nlohmann_json)
