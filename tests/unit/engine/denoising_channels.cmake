emberline_test(denoising_channels_test
  SOURCES engine/denoising_channels_test.cpp
  LINK emberline_engine TBB::tbb)
