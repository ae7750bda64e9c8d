emberline_test(frame_range_test
  SOURCES
    frame_range_test.cpp
    picture_mark_test.cpp
    whole_picture_test.cpp
  LINK emberline_app OpenEXR::OpenEXR)
