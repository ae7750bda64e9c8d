emberline_test(refinement_tree_test
  SOURCES
    drivers/adaptive/refinement_tree_test.cpp
    drivers/adaptive/refinement_priority_test.cpp
    drivers/adaptive/refinement_error_test.cpp
    drivers/adaptive/refinement_views_test.cpp
  LINK emberline_engine nlohmann_json::nlohmann_json TBB::tbb)
