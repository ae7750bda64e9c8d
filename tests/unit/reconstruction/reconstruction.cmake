emberline_test(denoise_test SOURCES reconstruction/denoise_test.cpp reconstruction/fast_filter_test.cpp LINK emberline_reconstruction TBB::tbb)
