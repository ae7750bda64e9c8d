emberline_test(lens_test SOURCES scene/lens_test.cpp LINK emberline_engine TBB::tbb)
