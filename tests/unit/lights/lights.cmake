emberline_test(triangle_sampling_test OPTIMISED SOURCES lights/triangle_sampling_test.cpp LINK emberline_lights)
emberline_test(environment_light_test SOURCES lights/environment_light_test.cpp lights/fixed_cdf_test.cpp
               LINK emberline_lights TBB::tbb)
emberline_test(light_sampler_test OPTIMISED SOURCES lights/light_sampler_test.cpp lights/light_density_test.cpp lights/light_bvh_test.cpp
               LINK emberline_lights)
emberline_test(sampling_routines_test OPTIMISED SOURCES lights/sampling_routines_test.cpp
               LINK emberline_lights emberline_samplers emberline_shading)
emberline_test(environment_guide_test OPTIMISED SOURCES lights/environment_guide_test.cpp LINK emberline_lights fmt::fmt)
