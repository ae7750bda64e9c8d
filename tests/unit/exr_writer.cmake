emberline_test(exr_writer_test
  SOURCES exr_writer_test.cpp
  LINK emberline_io OpenEXR::OpenEXR)
