emberline_test(core_values_test OPTIMISED
  SOURCES core/hash_test.cpp core/moments_test.cpp core/vector_test.cpp core/names_test.cpp
          core/memory_budget_test.cpp core/readable_test.cpp core/setting_names_test.cpp core/zeroed_array_test.cpp
  LINK emberline_core)
