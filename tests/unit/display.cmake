emberline_test(display_test
  SOURCES display_image_writer_test.cpp display_test.cpp
  LINK emberline_io OpenImageIO::OpenImageIO)
