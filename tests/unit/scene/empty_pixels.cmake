emberline_test(empty_pixels_test SOURCES scene/empty_pixels_test.cpp LINK emberline_engine TBB::tbb)
