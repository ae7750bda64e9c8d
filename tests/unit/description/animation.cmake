emberline_test(animation_test
  SOURCES description/animation_test.cpp
  LINK emberline_description)
