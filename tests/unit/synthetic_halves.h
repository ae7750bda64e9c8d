// Synthetic pictures for the tests of the denoiser: a known truth, and noisy samples of it in two
// halves.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include "renderer/reconstruction/denoise.h"

namespace emberline::test {

class SyntheticHalves {
 public:
  using Function = std::function<float(int x, int y)>;

  SyntheticHalves(int width, int height, float samples_per_half, uint32_t seed = 1)
      : width_(width),
        height_(height),
        count_(samples_per_half),
        random_(seed),
        counts_(size(), samples_per_half) {}

  // Sets grey samples, which are normally distributed with mean `truth` and standard deviation
  // `spread`.
  void set_colour(const Function& truth, const Function& spread) {
    truth_ = plane(truth);
    colour_ = noisy(truth, spread);
  }
  void add_feature(const Function& truth, const Function& spread) {
    features_.push_back(noisy(truth, spread));
  }
  void set_albedo(const Function& truth, const Function& spread) { albedo_ = noisy(truth, spread); }
  void add_part(float share) {
    Pair part = colour_;
    for (std::vector<float>& half : part) {
      for (float& value : half) value *= share;
    }
    parts_.push_back(part);
  }

  // Shares the samples of each pixel equally with its 3 x 3 neighbours. So the value of a pixel is
  // their mean, except at the border.
  void blur_with_neighbours() {
    shared_ = colour_;
    for (size_t s = 0; s < 2; ++s) {
      for (int y = 1; y + 1 < height_; ++y) {
        for (int x = 1; x + 1 < width_; ++x) {
          const int i = y * width_ + x;
          float sum = 0.0f;
          for (int k = 0; k < 9; ++k) {
            sum += colour_[s][size_t(i + (k / 3 - 1) * width_ + k % 3 - 1)];
          }
          shared_[s][size_t(i)] = sum / 9;
        }
      }
    }
  }

  void clear_shared() { shared_ = {}; }

  std::vector<float>& shared(size_t half) { return shared_[half]; }
  std::vector<float>& colour(size_t half) { return colour_[half]; }
  std::vector<float>& feature(size_t half) { return features_.back()[half]; }
  std::vector<float>& counts() { return counts_; }
  const std::vector<float>& truth() const { return truth_; }

  DenoiseInput input() const {
    DenoiseInput in;
    in.width = width_;
    in.height = height_;
    in.samples = {counts_, counts_};
    in.colour = grey(colour_);
    if (!albedo_[0].empty()) in.albedo = grey(albedo_);
    for (const Pair& feature : features_) in.features.push_back({feature[0], feature[1]});
    for (const Pair& part : parts_) in.parts.push_back(grey(part));
    if (!shared_[0].empty()) in.shared = grey(shared_);
    return in;
  }

  std::vector<float> raw() const {
    std::vector<float> mean(size());
    for (size_t i = 0; i < size(); ++i) mean[i] = 0.5f * (colour_[0][i] + colour_[1][i]);
    return mean;
  }
  double squared_error(const std::vector<float>& picture) const {
    double sum = 0.0;
    for (size_t i = 0; i < size(); ++i) {
      sum += double(picture[i] - truth_[i]) * double(picture[i] - truth_[i]);
    }
    return sum / double(size());
  }
  // The factor by which denoising reduces the squared error.
  double gain() const { return squared_error(raw()) / squared_error(denoise(input()).colour[0]); }

 private:
  using Pair = std::array<std::vector<float>, 2>;

  size_t size() const { return size_t(width_) * size_t(height_); }
  static HalfColour grey(const Pair& pair) {
    const HalfPlanes planes = {pair[0], pair[1]};
    return {planes, planes, planes};
  }
  std::vector<float> plane(const Function& function) const {
    std::vector<float> values;
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) values.push_back(function(x, y));
    }
    return values;
  }
  Pair noisy(const Function& truth, const Function& spread) {
    const std::vector<float> mean = plane(truth), deviation = plane(spread);
    std::normal_distribution<float> normal;
    Pair pair = {mean, mean};
    for (std::vector<float>& half : pair) {
      for (size_t i = 0; i < size(); ++i) {
        half[i] += deviation[i] * normal(random_) / std::sqrt(count_);
      }
    }
    return pair;
  }

  int width_, height_;
  float count_;
  std::mt19937 random_;
  std::vector<float> counts_, truth_;
  Pair colour_, albedo_, shared_;
  std::vector<Pair> features_, parts_;
};

inline SyntheticHalves::Function constant(float value) {
  return [value](int, int) { return value; };
}

}  // namespace emberline::test
