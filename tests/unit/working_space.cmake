emberline_test(working_space_test SOURCES working_space_test.cpp
               LINK emberline_engine emberline_io TBB::tbb)
