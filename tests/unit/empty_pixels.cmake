emberline_test(empty_pixels_test SOURCES empty_pixels_test.cpp LINK emberline_engine TBB::tbb)
