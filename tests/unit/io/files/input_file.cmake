emberline_test(input_file_test
  SOURCES io/files/input_file_test.cpp
  LINK emberline_io nlohmann_json::nlohmann_json)
