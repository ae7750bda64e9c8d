// What an adaptive driver pays between two rounds: a whole frame's statistics and error map.
#include <memory>
#include <string>
#include <vector>

#include "bench/parts.h"
#include "renderer/drivers/adaptive/error_estimator.h"

namespace emberline::bench {
namespace {

constexpr int kWidth = 1280, kHeight = 720;

// Noise of a tenth of the radiance, which is anywhere between black and white; two streams.
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
        film->add(x, y, int(k >> 3), 1.0f, value);
      }
    }
  }
  return film;
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
    // Without a threshold `dammertz` splits to the end: its slowest case.
    const std::shared_ptr<const ErrorEstimator> estimator = entry.create({.threshold = 0.0f});
    add_benchmark(
        "error_map/" + std::string(entry.name),
        [estimator, pixels, map = ErrorMap()]() mutable {
          estimator->estimate(*pixels, ErrorMetric::kDisplay, &map);
          return map.error[0];
        },
        kPixels);
  }
}

}  // namespace emberline::bench
