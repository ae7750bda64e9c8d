emberline_test(refinement_tree_test
  SOURCES
    drivers/adaptive/refinement_tree_test.cpp
    drivers/adaptive/refinement_priority_test.cpp
    drivers/adaptive/refinement_error_test.cpp
    drivers/adaptive/smooth_reconstruction_test.cpp
    output/refinement_output_test.cpp
  LINK emberline_output nlohmann_json::nlohmann_json TBB::tbb)
