emberline_test(compare_command_test
  SOURCES compare_command_test.cpp
  LINK emberline_app nlohmann_json::nlohmann_json)
