emberline_test(refinement_tree_test
  SOURCES
    refinement_tree_test.cpp
    refinement_priority_test.cpp
    refinement_error_test.cpp
    refinement_views_test.cpp
  LINK emberline_engine nlohmann_json::nlohmann_json TBB::tbb)
