emberline_test(panorama_test SOURCES panorama_test.cpp LINK emberline_drivers TBB::tbb)
