emberline_test(display_test
  SOURCES display_test.cpp
  LINK emberline_io OpenImageIO::OpenImageIO)
