emberline_test(panorama_test SOURCES panorama_test.cpp LINK emberline_engine TBB::tbb)
