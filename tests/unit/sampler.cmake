emberline_test(sampler_test OPTIMISED
  SOURCES sampler_test.cpp coverage_key_test.cpp owen_sobol_test.cpp sampler_convergence_test.cpp
          stratified_sampler_test.cpp poisson_disk_sampler_test.cpp blue_noise_sampler_test.cpp
          hierarchical_sampler_test.cpp
  LINK emberline_statistics)
