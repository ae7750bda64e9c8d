// Benchmarks of single parts of the renderer, in nanoseconds; see README.md.
#include "bench/parts.h"

int main(int argc, char** argv) {
  emberline::bench::add_sampling_benchmarks();
  emberline::bench::add_shading_benchmarks();
  emberline::bench::add_lights_and_scene_benchmarks();
  emberline::bench::add_refinement_benchmarks();
  emberline::bench::add_error_map_benchmarks();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
}
