emberline_test(warps_test OPTIMISED SOURCES warps_test.cpp LINK emberline_core)
