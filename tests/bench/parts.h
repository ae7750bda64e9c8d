// The part benchmarks share this code for precomputed inputs and for a figure per item.
#pragma once

#include <benchmark/benchmark.h>

#include <array>
#include <string>

#include "renderer/core/hash.h"
#include "renderer/core/vector.h"
#include "renderer/core/warps.h"

namespace emberline::bench {

// Inputs are read cyclically. There are enough of them to defeat branch prediction, and few enough
// to stay in the cache.
inline constexpr size_t kInputs = 4096;

template <typename T>
struct Inputs {
  std::array<T, kInputs> values;
  size_t next = 0;
  const T& operator()() { return values[next++ % kInputs]; }
};

inline float random_unit(uint32_t stream, uint32_t i) {
  return to_unit_float(hash_combine(hash32(stream), i));
}
inline Vec2f random_point(uint32_t stream, uint32_t i) {
  return {random_unit(2 * stream, i), random_unit(2 * stream + 1, i)};
}

// Returns the inputs make(i) for i = 0, 1, ...
template <typename Make>
auto inputs(const Make& make) {
  Inputs<decltype(make(uint32_t{}))> made;
  for (uint32_t i = 0; i < kInputs; ++i) made.values[i] = make(i);
  return made;
}

// Times body(). One call processes `items` items, and "each" is the time per item.
template <typename Body>
void add_benchmark(const std::string& name, const Body& body, double items = 1) {
  benchmark::RegisterBenchmark(name.c_str(), [body, items](benchmark::State& state) {
    auto own = body;
    for (auto _ : state) benchmark::DoNotOptimize(own());
    state.counters["each"] = benchmark::Counter(
        items, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  });
}

// Each of these functions is defined in one file and called by parts_bench.cpp.
void add_sampling_benchmarks();
void add_shading_benchmarks();
void add_lights_and_scene_benchmarks();
void add_refinement_benchmarks();
void add_error_map_benchmarks();

}  // namespace emberline::bench
