// `--allocation denoised`: the error of the picture after denoising.
//
// The filter estimates the error that it leaves in each pixel (renderer/reconstruction/denoise.h).
// As in Rousselle, Knaus & Zwicker 2012, "Adaptive Rendering with Non-Local Means Filtering", e^2
// is assumed to fall as 1 / n: one more sample than n removes e^2 / (n + 1), so e sqrt(n) takes the
// place of a sample's deviation when the planner shares samples.
//
// Filtering takes as long as several samples of every pixel, so it is repeated only when the number
// of samples has grown kFilterGrowth times. In between, the last errors are scaled by 1 / sqrt(n).
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "renderer/drivers/adaptive/error_estimator.h"

namespace emberline {

class Archive;
class FilmTile;

// Our choice, not tuned: one pass takes 5 to 8 % of a frame of 64 samples (tests/bench/results).
inline constexpr double kFilterGrowth = 4.0;

class DenoisedError {
 public:
  // Replaces the map's errors by those of the denoised picture, and its deviations by those that
  // decide the shares of samples; does nothing while there are too few samples to filter. The film
  // must have the channels of `denoising`; `counts` are the samples of its pixels. Filters if due
  // and allowed. False if a stop was requested meanwhile. The same bits for any number of threads.
  bool update(const FilmTile& film, std::span<const float> counts, bool may_filter, ErrorMap* map,
              const std::stop_token& stop);
  // The same, but always filters.
  bool filter(const FilmTile& film, std::span<const float> counts, ErrorMap* map,
              const std::stop_token& stop);
  // Whether the film has been filtered.
  bool is_known() const { return filtered_at_ > 0.0; }
  // Whether the film had other samples at the last update than when it was filtered.
  bool is_stale() const { return filtered_at_ > 0.0 && samples_ != filtered_at_; }

  void archive(Archive& archive, size_t pixels);
  uint64_t bytes() const { return square_.capacity() * sizeof(float); }

 private:
  void write_errors(std::span<const float> counts, ErrorMap* map) const;

  double samples_ = 0.0;       // per pixel, at the last update
  double filtered_at_ = 0.0;   // samples_ at the last filtering; 0: never
  std::vector<float> square_;  // squared error of a pixel at that time, times its samples
};

// 0 if empty. The same for any number of threads.
double root_mean_square(std::span<const float> values);

}  // namespace emberline
