emberline_test(exr_writer_test
  SOURCES atomic_file_test.cpp exr_writer_test.cpp
  LINK emberline_io OpenEXR::OpenEXR)
