// Benchmarks the work of an adaptive driver between two rounds: statistics, error map and plan of a
// frame.
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "bench/parts.h"
#include "renderer/drivers/adaptive/allocation.h"
#include "renderer/drivers/adaptive/error_estimator.h"
#include "renderer/drivers/adaptive/frame_error.h"
#include "renderer/drivers/adaptive/missed_light.h"
#include "renderer/drivers/adaptive/round_planner.h"
#include "renderer/film/channels.h"
#include "renderer/film/film.h"
#include "renderer/film/film_extras.h"
#include "renderer/film/sample_value.h"

namespace emberline::bench {
namespace {

constexpr int kWidth = 1280, kHeight = 720;

// Returns a film of radiances between black and white, with noise of a tenth of the radiance, in
// two streams.
std::shared_ptr<const FilmTile> noisy_film() {
  auto film = std::make_shared<FilmTile>(AovSet{}, FilmExtras{.squares = true, .rays = true});
  film->reset({0, 0, kWidth, kHeight});
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const auto pixel = uint32_t(y * kWidth + x);
      const float mean = random_unit(1, pixel / 64);
      for (uint32_t k = 0; k < 16; ++k) {
        SampleValue value;
        value.radiance = Rgb(mean * (0.9f + 0.2f * random_unit(2, 16 * pixel + k)));
        film->add(x, y, {value, 1.0f, int(k >> 3)});
      }
    }
  }
  return film;
}

// Allocates a budget of twice the current samples, with rates that differ a thousandfold.
void add_share_samples() {
  constexpr size_t kPixels = size_t(kWidth) * kHeight;
  std::vector<float> rates(kPixels);
  std::vector<SampleBounds> bounds(kPixels);
  for (size_t i = 0; i < kPixels; ++i) {
    const float u = random_unit(3, uint32_t(i));
    rates[i] = 1e-3f + u * u * u;
    bounds[i] = {float(8 * (1 + i % 4)), 1024.0f};
  }
  add_benchmark(
      "error_map/allocate_samples",
      [rates, bounds, counts = std::vector<float>()]() mutable {
        allocate_samples(rates, bounds, 40.0 * double(kPixels), &counts);
        return counts[0];
      },
      double(kPixels));
}

// Benchmarks the complete step. The first plan touches the frame's memory, and the second plan is
// timed.
void add_plan(const std::string& name, const AdaptiveSettings& settings,
              const std::shared_ptr<const FilmTile>& film) {
  benchmark::RegisterBenchmark(name.c_str(), [settings, film](benchmark::State& state) {
    for (auto _ : state) {
      state.PauseTiming();
      RoundPlanner planner(settings, kWidth, kHeight, 1);
      planner.plan(*film);
      state.ResumeTiming();
      benchmark::DoNotOptimize(planner.plan(*film));
    }
  });
}

}  // namespace

void add_error_map_benchmarks() {
  const std::shared_ptr<const FilmTile> film = noisy_film();
  const auto pixels = std::make_shared<PixelStatistics>();
  gather_statistics(*film, pixels.get());
  constexpr double kPixels = double(kWidth) * kHeight;
  add_benchmark(
      "error_map/statistics",
      [film, statistics = PixelStatistics()]() mutable {
        gather_statistics(*film, &statistics);
        return statistics.mean[0][0];
      },
      kPixels);
  for (const EstimatorEntry& entry : estimator_table()) {
    // Without a threshold, `dammertz` splits to the end, which is its slowest case.
    add_benchmark(
        "error_map/" + std::string(entry.name),
        [&entry, pixels, map = ErrorMap()]() mutable {
          entry.estimate(*pixels, {}, &map);
          return map.error[0];
        },
        kPixels);
  }
  add_benchmark(
      "error_map/frame_error",
      [pixels] { return float(frame_error(*pixels, missed_light_error(*pixels))); }, kPixels);
  add_share_samples();
  for (const std::string_view estimator : {"nested", "two-stream"}) {
    const std::string name = "error_map/look_and_plan/" + std::string(estimator);
    add_plan(name + "/budget", {.estimator = estimator, .budget = 256}, film);
    add_plan(name + "/threshold", {.estimator = estimator, .threshold = 0.005f}, film);
  }
}

}  // namespace emberline::bench
