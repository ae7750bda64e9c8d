emberline_test(study_command_test
  SOURCES study_plan_test.cpp study_files_test.cpp
  LINK emberline_app nlohmann_json::nlohmann_json)
