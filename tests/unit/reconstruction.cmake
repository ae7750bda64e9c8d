emberline_test(denoise_test SOURCES denoise_test.cpp fast_filter_test.cpp LINK emberline_reconstruction TBB::tbb)
