emberline_test(panorama_test SOURCES scene/panorama_test.cpp LINK emberline_engine TBB::tbb)
