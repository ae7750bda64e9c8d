emberline_test(triangle_sampling_test OPTIMISED SOURCES triangle_sampling_test.cpp LINK emberline_lights)
emberline_test(environment_light_test SOURCES environment_light_test.cpp fixed_cdf_test.cpp
               LINK emberline_lights TBB::tbb)
emberline_test(light_sampler_test OPTIMISED SOURCES light_sampler_test.cpp light_density_test.cpp light_bvh_test.cpp
               LINK emberline_lights)
emberline_test(sampling_routines_test OPTIMISED SOURCES sampling_routines_test.cpp
               LINK emberline_lights emberline_samplers emberline_shading)
emberline_test(environment_guide_test OPTIMISED SOURCES environment_guide_test.cpp LINK emberline_lights fmt::fmt)
