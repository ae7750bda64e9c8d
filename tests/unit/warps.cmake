emberline_test(warps_test SOURCES warps_test.cpp LINK emberline_core)
