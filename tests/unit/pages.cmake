emberline_test(pages_test
  SOURCES chart_axis_test.cpp html_page_test.cpp svg_chart_test.cpp
  LINK emberline_statistics)
emberline_test(app_pages_test
  SOURCES report_page_test.cpp shell_quote_test.cpp study_page_test.cpp
  LINK emberline_app nlohmann_json::nlohmann_json)
