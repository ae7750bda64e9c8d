emberline_test(core_values_test OPTIMISED
  SOURCES hash_test.cpp moments_test.cpp vector_test.cpp names_test.cpp
          memory_budget_test.cpp readable_test.cpp setting_names_test.cpp zeroed_array_test.cpp
  LINK emberline_core)
