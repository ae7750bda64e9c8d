emberline_test(animation_test
  SOURCES animation_test.cpp
  LINK emberline_description)
