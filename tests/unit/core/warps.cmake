emberline_test(warps_test OPTIMISED SOURCES core/warps_test.cpp LINK emberline_core)
