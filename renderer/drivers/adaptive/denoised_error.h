// `--allocation denoised`: what is wrong with the picture once it is denoised.
//
// The filter says what error it leaves in each pixel (renderer/reconstruction/denoise.h). As
// Rousselle, Knaus & Zwicker 2012, "Adaptive Rendering with Non-Local Means Filtering", share
// samples by such an estimate, e^2 is taken to fall as 1 / n: one sample more than n takes
// e^2 / (n + 1) away, so that e sqrt(n) stands for the deviation of a sample in the planner's
// shares.
//
// Filtering takes as long as some samples of every pixel. So it is done when there are
// kFilterGrowth times the samples of the last time, and in between the last errors have fallen so.
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "renderer/drivers/adaptive/error_estimator.h"

namespace emberline {

class Archive;
class FilmTile;

// Ours, not tuned: one pass is then 5 to 8 % of a frame of 64 samples.
inline constexpr double kFilterGrowth = 4.0;

class DenoisedError {
 public:
  // Of a film with the channels of `denoising`, whose pixels have so many samples: puts the errors
  // of the denoised picture, and the deviations by which samples are to be shared, into the place
  // of the map's; leaves it alone before there are samples enough to be filtered. Filters if that
  // is due, and allowed. False if a stop was requested meanwhile. The same bits for any number of
  // threads.
  bool look(const FilmTile& film, std::span<const float> counts, bool may_filter, ErrorMap* map,
            const std::stop_token& stop);
  // The same, but filters in any case.
  bool filter(const FilmTile& film, std::span<const float> counts, ErrorMap* map,
              const std::stop_token& stop);
  // The film has been filtered.
  bool known() const { return filtered_at_ > 0.0; }
  // At the last look the film had other samples than when it was filtered.
  bool stale() const { return filtered_at_ > 0.0 && samples_ != filtered_at_; }

  void archive(Archive& archive, size_t pixels);
  uint64_t bytes() const { return square_.capacity() * sizeof(float); }

 private:
  void put(std::span<const float> counts, ErrorMap* map) const;

  double samples_ = 0.0;       // a pixel, at the last look
  double filtered_at_ = 0.0;   // when it was filtered; 0: never
  std::vector<float> square_;  // of a pixel's error then, times its samples
};

// 0 of none. The same for any number of threads.
double root_mean_square(std::span<const float> values);

}  // namespace emberline
