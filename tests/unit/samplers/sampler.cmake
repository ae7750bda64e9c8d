emberline_test(sampler_test OPTIMISED
  SOURCES samplers/sampler_test.cpp samplers/coverage_key_test.cpp samplers/owen_sobol_test.cpp samplers/sampler_convergence_test.cpp
          samplers/stratified_sampler_test.cpp samplers/poisson_disk_sampler_test.cpp samplers/blue_noise_sampler_test.cpp
          samplers/hierarchical_sampler_test.cpp
  LINK emberline_statistics)
