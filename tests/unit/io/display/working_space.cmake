emberline_test(working_space_test SOURCES io/display/working_space_test.cpp
               LINK emberline_engine emberline_io TBB::tbb)
