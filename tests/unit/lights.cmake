emberline_test(triangle_sampling_test SOURCES triangle_sampling_test.cpp LINK emberline_lights)
emberline_test(environment_light_test SOURCES environment_light_test.cpp fixed_cdf_test.cpp
               LINK emberline_lights TBB::tbb)
emberline_test(light_sampler_test SOURCES light_sampler_test.cpp light_density_test.cpp light_bvh_test.cpp
               LINK emberline_lights)
emberline_test(sampling_routines_test SOURCES sampling_routines_test.cpp
               LINK emberline_lights emberline_samplers emberline_shading)

# Not part of "all": timings, run by hand.
add_executable(lights_bench EXCLUDE_FROM_ALL ${CMAKE_SOURCE_DIR}/tests/bench/lights_bench.cpp)
target_link_libraries(lights_bench PRIVATE emberline_lights GTest::gtest)
target_include_directories(lights_bench PRIVATE ${CMAKE_SOURCE_DIR}/tests)
