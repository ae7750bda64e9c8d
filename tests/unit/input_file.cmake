emberline_test(input_file_test
  SOURCES input_file_test.cpp
  LINK emberline_io nlohmann_json::nlohmann_json)
