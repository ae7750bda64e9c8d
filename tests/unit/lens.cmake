emberline_test(lens_test SOURCES lens_test.cpp LINK emberline_engine TBB::tbb)
