emberline_test(study_command_test
  SOURCES statistics/study/study_plan_test.cpp statistics/study/study_files_test.cpp
  LINK emberline_app nlohmann_json::nlohmann_json)
