emberline_test(json_input_test
  SOURCES io/json/json_input_test.cpp
  LINK emberline_io nlohmann_json::nlohmann_json)
