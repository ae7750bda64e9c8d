// Decides, between two rounds, how many samples each pixel of a crop gets next. Everything is a
// function of the film and the settings: neither threads nor the clock have a say.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "renderer/drivers/adaptive/adaptive_settings.h"
#include "renderer/drivers/adaptive/allocation.h"
#include "renderer/drivers/adaptive/denoised_error.h"
#include "renderer/drivers/adaptive/error_estimator.h"
#include "renderer/drivers/adaptive/round_averages.h"
#include "renderer/drivers/adaptive/sample_halves.h"
#include "renderer/film/pixel_stop.h"

namespace emberline {

class Archive;
class FilmTile;

// What was thought of one pixel when a round was planned.
struct RoundRecord {
  int round = 0;
  uint32_t samples = 0;  // it had
  float error = 0.0f;    // ErrorMap's
  float deviation = 0.0f;
  float cost = 0.0f;    // rays a sample
  uint32_t target = 0;  // samples it was to have after the round
};

class RoundPlanner {
 public:
  // For a crop of width x height pixels; `seed` decides the roundings.
  RoundPlanner(const AdaptiveSettings& settings, int width, int height, uint32_t seed);

  // What the picture shows, from its first round on, instead of the plain means of all samples:
  // what is told of errors is then told of this. Outlives the planner.
  void set_averages(const RoundAverages* averages) { averages_ = averages; }

  // How many samples each pixel is to have after the coming round; the same for all before the
  // first plan().
  std::span<const uint32_t> targets() const { return targets_; }
  // Looks at a film that holds the targets' samples and sets the next. False if nothing is to come,
  // or if a stop was requested meanwhile: the targets are then as before.
  bool plan(const FilmTile& film, const std::stop_token& stop = {});
  // A stop request cut the last plan() short.
  bool interrupted() const { return interrupted_; }
  // The part of each pixel's squared error that going from `have` samples to `targets` is expected
  // to take away, by the last look; all 0 before it.
  void expected_gains(std::span<const uint32_t> have, std::span<const uint32_t> targets,
                      std::vector<float>* gains) const;
  // Looks only, for the error estimate of what there is.
  void look(const FilmTile& film);

  // Whether write_variances() has something to write that a film does not know.
  static bool knows_variances(const AdaptiveSettings& settings) {
    return find_estimator(settings.estimator).halves || settings.unbiased;
  }
  // Writes into the film, pixel by pixel, the variances behind error_estimate(), as of the last
  // look; nothing of pixels of which the film itself knows as much. Not while samples are added.
  void write_variances(FilmTile* film) const;

  // Of the whole crop (frame_error.h), as of the last look; NaN before it and for estimators
  // whose error is no RMS error.
  double error_estimate() const { return error_estimate_; }
  // Why the pixel would get no more if the frame ended now.
  PixelStop stop_of(size_t i) const;
  // The same for a frame that goes on, of a pixel that has `have` samples by now: the limit that it
  // had met at the last look, or kGoingOn. What a round brings everywhere it may get all the same.
  PixelStop stop_so_far(size_t i, uint32_t have) const;
  // What the round under way counts for in a mean over rounds (RoundAverages), if `unbiased`: a
  // number that the settings alone decide.
  double round_weight() const { return round_weight_; }
  // The seed of that round's samples: fresh ones for each round with `unbiased`.
  uint32_t round_seed() const;
  int round() const { return round_; }
  const ErrorMap& errors() const { return errors_; }

  // Keeps records of one pixel, by index, from here on; those of another are dropped.
  void record(size_t pixel);
  size_t recorded() const { return recorded_; }
  std::span<const RoundRecord> records() const { return records_; }
  // The state that is going to be loaded has its pilot, which may be smaller than these settings'.
  void skip_pilot() { pilot_done_ = true; }
  // All but what the next look finds anew.
  void archive(Archive& archive);
  uint64_t bytes() const;

 private:
  bool look(const FilmTile& film, bool to_plan, const std::stop_token& stop);
  bool look_denoised(const FilmTile& film, bool to_plan, const std::stop_token& stop);
  bool for_denoised() const { return settings_.allocation == ErrorMetric::kDenoised; }
  // The budget has not enough left for a round.
  bool spent() const;
  bool grow_pilot();
  bool share_by_deviation();
  void share_whole_budget(double total);
  bool share_evenly();
  bool resample_noise_free_pixels();
  float keep_to_budget(float everywhere);
  bool unfinished(size_t i) const;
  // Those that may get more in the coming round.
  struct OpenPixels {
    size_t count = 0;
    float largest_rate = 0.0f;
    OpenPixels& operator+=(const OpenPixels& other) {
      count += other.count;
      largest_rate = std::max(largest_rate, other.largest_rate);
      return *this;
    }
  };
  OpenPixels limit_pixels(size_t begin, size_t end);
  template <typename CountOf>
  void set_targets(const CountOf& count_of);
  void round_to_counts(float everywhere);
  void round_to_steps(float everywhere);
  bool averaged() const { return averages_ && !averages_->empty(); }
  bool doubles() const { return entry_.halves && !settings_.unbiased; }

  AdaptiveSettings settings_;
  const EstimatorEntry& entry_;
  uint32_t seed_;
  double spent_ = 0.0;  // samples of the crop
  int round_ = 0;
  bool interrupted_ = false;
  uint32_t pilot_ = 0;
  bool pilot_done_ = false;
  double round_weight_ = 0.0;
  double planned_mean_ = 0.0;  // samples of a pixel up to the round under way, if unbiased
  double error_estimate_;
  std::vector<uint32_t> targets_;
  const RoundAverages* averages_ = nullptr;
  PixelStatistics statistics_;
  SampleHalves halves_;     // if the estimator goes by them
  DenoisedError denoised_;  // if samples are shared by it
  ErrorMap errors_;
  std::vector<float> rates_, shares_;
  std::vector<SampleBounds> bounds_;
  size_t recorded_;
  std::vector<RoundRecord> records_;
};

}  // namespace emberline
