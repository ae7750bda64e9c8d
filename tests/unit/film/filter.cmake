emberline_test(filter_test OPTIMISED SOURCES film/filter_test.cpp LINK emberline_film emberline_samplers)
