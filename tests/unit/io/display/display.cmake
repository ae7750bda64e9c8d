emberline_test(display_test
  SOURCES io/display/display_image_writer_test.cpp io/display/display_test.cpp
  LINK emberline_io OpenImageIO::OpenImageIO)
