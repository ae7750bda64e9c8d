// `--allocation denoised`: the error of the picture after denoising.
//
// The filter estimates the error that it leaves in each pixel (renderer/reconstruction/denoise.h).
// As in Rousselle, Knaus & Zwicker 2012, "Adaptive Rendering with Non-Local Means Filtering", e^2
// is assumed to fall as 1 / n. Then one sample in addition to n removes e^2 / (n + 1), so the
// planner uses e sqrt(n) instead of a sample's deviation to distribute samples.
//
// Filtering takes as long as several samples of every pixel, so it is repeated only when the number
// of samples has grown by a factor of kFilterGrowth. In between, the last errors are scaled by 1 /
// sqrt(n).
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "renderer/drivers/adaptive/error_estimator.h"

namespace emberline {

class Archive;
class FilmTile;

// Our choice, not tuned. One pass of the filter takes 5 to 8 % of the time of a frame of 64 samples
// (tests/bench/results).
inline constexpr double kFilterGrowth = 4.0;

class DenoisedError {
 public:
  // Replaces the map's errors by those of the denoised picture, and its deviations by e sqrt(n);
  // does nothing while there are too few samples to filter. Filters if due and if `may_filter`. The
  // film must have the channels of `denoising`; `counts` are the sample counts of its pixels.
  // Returns false if a stop was requested meanwhile. The bits are the same for any number of
  // threads.
  bool update(const FilmTile& film, std::span<const float> counts, bool may_filter, ErrorMap* map,
              const std::stop_token& stop);
  // Like update(), but always filters.
  bool filter(const FilmTile& film, std::span<const float> counts, ErrorMap* map,
              const std::stop_token& stop);
  // Whether the film has been filtered.
  bool is_known() const { return filtered_at_ > 0.0; }
  // Whether samples were added between the last filtering and the last update.
  bool is_stale() const { return filtered_at_ > 0.0 && samples_ != filtered_at_; }

  void archive(Archive& archive, size_t pixels);
  uint64_t bytes() const { return square_.capacity() * sizeof(float); }

 private:
  void write_errors(std::span<const float> counts, ErrorMap* map) const;

  double samples_ = 0.0;       // mean samples per pixel at the last update
  double filtered_at_ = 0.0;   // samples_ at the last filtering; 0: never
  std::vector<float> square_;  // squared error of a pixel at that time, times its samples
};

// Returns 0 if `values` is empty. The result is the same for any number of threads.
double root_mean_square(std::span<const float> values);

}  // namespace emberline
