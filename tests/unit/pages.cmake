emberline_test(pages_test
  SOURCES chart_axis_test.cpp html_page_test.cpp readable_test.cpp svg_chart_test.cpp
  LINK emberline_statistics)
