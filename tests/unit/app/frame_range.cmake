emberline_test(frame_range_test
  SOURCES
    app/frame_range_test.cpp
    io/image/picture_mark_test.cpp
    io/image/whole_picture_test.cpp
  LINK emberline_app OpenEXR::OpenEXR)
