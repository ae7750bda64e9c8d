emberline_test(pages_test
  SOURCES statistics/chart_axis_test.cpp statistics/html_page_test.cpp statistics/svg_chart_test.cpp
  LINK emberline_statistics)
emberline_test(app_pages_test
  SOURCES output/report_page_test.cpp app/shell_quote_test.cpp statistics/study/study_page_test.cpp
  LINK emberline_app nlohmann_json::nlohmann_json)
