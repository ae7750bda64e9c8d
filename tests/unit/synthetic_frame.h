// A frame with made-up samples that replaces the renderer in tests of sample planning.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "renderer/drivers/adaptive/round_planner.h"
#include "renderer/film/film.h"
#include "support/chi_square.h"

namespace emberline::test {

class SyntheticFrame {
 public:
  // Sample k of pixel (x, y) is a pure function of k, x, y and its own random numbers.
  struct Sample {
    float radiance = 0.0f;
    uint32_t rays = 2;
  };
  using Draw = std::function<Sample(int x, int y, TestRandom& random)>;

  SyntheticFrame(int width, int height, uint64_t seed, Draw draw)
      : film_(AovSet::parse("denoising"), {.squares = true, .rays = true}),
        width_(width),
        seed_(seed),
        draw_(std::move(draw)),
        sample_counts_(size_t(width) * size_t(height), 0) {
    film_.reset({0, 0, width, height});
  }

  // All samples have the same features, so that they tell a filter nothing.
  static constexpr float kAlbedo = 0.5f, kNearness = 1.0f;

  // Adds samples in index order. The streams alternate in blocks of eight (samplers/sampler.h).
  void add_samples_until(std::span<const uint32_t> targets) {
    const DenoiserFeatures seen = {Rgb(kAlbedo), Vec3f(0.0f, 0.0f, 1.0f), kNearness, 1.0f};
    for (size_t i = 0; i < sample_counts_.size(); ++i) {
      const int x = int(i % size_t(width_)), y = int(i / size_t(width_));
      for (; sample_counts_[i] < targets[i]; ++sample_counts_[i]) {
        TestRandom random(seed_, (uint64_t(i) << 32) + sample_counts_[i]);
        const Sample sample = draw_(x, y, random);
        const SampleValue value = {
            .radiance = Rgb(sample.radiance), .alpha = 1.0f, .rays = {.scatter = sample.rays - 1}};
        film_.add(x, y, {value, 1.0f, int((sample_counts_[i] >> 3) & 1u), &seen});
      }
    }
  }

  // Renders the pilot and all rounds until the planner ends. `on_round` is called before each
  // round, when its targets are known.
  template <typename OnRound>
  void render(RoundPlanner& planner, const OnRound& on_round) {
    add_samples_until(planner.targets());
    while (planner.plan(film_)) {
      on_round();
      add_samples_until(planner.targets());
    }
  }
  void render(RoundPlanner& planner) {
    render(planner, [] {});
  }

  const FilmTile& film() const { return film_; }
  std::span<const uint32_t> counts() const { return sample_counts_; }
  uint32_t count(int x, int y) const {
    return sample_counts_[size_t(y) * size_t(width_) + size_t(x)];
  }
  double mean_count() const {
    double sum = 0;
    for (const uint32_t n : sample_counts_) sum += n;
    return sum / double(sample_counts_.size());
  }

 private:
  FilmTile film_;
  int width_;
  uint64_t seed_;
  Draw draw_;
  std::vector<uint32_t> sample_counts_;
};

}  // namespace emberline::test
