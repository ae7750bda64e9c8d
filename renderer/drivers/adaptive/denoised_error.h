// `--allocation denoised`: the error of the picture after denoising.
//
// The filter estimates the error e that it leaves in each pixel
// (renderer/reconstruction/denoise.h). As in Rousselle, Knaus & Zwicker 2012, "Adaptive Rendering
// with Non-Local Means Filtering", e^2 is assumed to fall as 1 / n. Then one more sample after the
// first n removes e^2 / (n + 1) from the squared error. So the planner distributes samples by e
// sqrt(n) instead of a sample's deviation.
//
// Filtering takes as long as several samples of every pixel, so it is repeated only when the number
// of samples has grown by a factor of kFilterGrowth. Between two filterings, the last errors are
// assumed to fall as 1 / sqrt(n).
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "renderer/drivers/adaptive/error_estimator.h"

namespace emberline {

class Archive;
class FilmTile;

// This factor is our choice and has not been tuned. Filtering once takes 5 to 8 % as long as
// rendering a frame with 64 samples (tests/bench/results).
inline constexpr double kFilterGrowth = 4.0;

class DenoisedError {
 public:
  // Replaces the map's errors by the errors of the denoised picture, and its deviations by e
  // sqrt(n). Does nothing while there are too few samples to filter. Filters only if `may_filter`
  // is set and enough samples were added since the last filtering. The film must have the channels
  // of `denoising`; `counts` are the sample counts of the film's pixels. Returns false if a stop
  // was requested during the call. The results are bit-identical for any number of threads.
  bool update(const FilmTile& film, std::span<const float> counts, bool may_filter, ErrorMap* map,
              const std::stop_token& stop);
  // Like update(), but always filters.
  bool filter(const FilmTile& film, std::span<const float> counts, ErrorMap* map,
              const std::stop_token& stop);
  // Returns whether the film has been filtered.
  bool is_known() const { return filtered_at_ > 0.0; }
  // Returns whether samples were added between the last filtering and the last update.
  bool is_stale() const { return filtered_at_ > 0.0 && samples_ != filtered_at_; }

  void archive(Archive& archive, size_t pixels);
  uint64_t bytes() const { return square_.capacity() * sizeof(float); }

 private:
  void write_errors(std::span<const float> counts, ErrorMap* map) const;

  double samples_ = 0.0;       // mean samples per pixel at the last update
  double filtered_at_ = 0.0;   // samples_ at the last filtering; 0: never
  std::vector<float> square_;  // squared error times sample count, at the last filtering
};

// Returns 0 if `values` is empty. The result is the same for any number of threads.
double root_mean_square(std::span<const float> values);

}  // namespace emberline
