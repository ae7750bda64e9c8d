emberline_test(exr_writer_test
  SOURCES io/files/atomic_file_test.cpp io/exr/exr_writer_test.cpp
  LINK emberline_io OpenEXR::OpenEXR)
