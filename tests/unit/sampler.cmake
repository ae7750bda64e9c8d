emberline_test(sampler_test
  SOURCES sampler_test.cpp owen_sobol_test.cpp sampler_convergence_test.cpp
  LINK emberline_samplers)
