// Decides, between two rounds, how many samples each pixel of a crop gets next. Decisions depend
// only on the film and the settings, not on threads or the clock.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "renderer/drivers/adaptive/adaptive_settings.h"
#include "renderer/drivers/adaptive/allocation.h"
#include "renderer/drivers/adaptive/error_estimator.h"
#include "renderer/drivers/adaptive/frame_allocation.h"
#include "renderer/drivers/adaptive/judged_channels.h"
#include "renderer/drivers/adaptive/round_averages.h"
#include "renderer/drivers/adaptive/sample_halves.h"
#include "renderer/drivers/work_forecast.h"
#include "renderer/film/pixel_stop.h"

namespace emberline {

class Archive;
class FilmTile;

// The state of one pixel when a round was planned.
struct RoundRecord {
  int round = 0;
  uint32_t samples = 0;  // before the round
  float error = 0.0f;    // error and deviation are from ErrorMap
  float deviation = 0.0f;
  float cost = 0.0f;    // of a sample, as in PixelStatistics
  uint32_t target = 0;  // samples after the round
  uint32_t judged = 0;  // JudgedChannels::recorded_channel()
};

class RoundPlanner {
 public:
  // Plans a crop of width x height pixels; `seed` is used for random rounding. `light_groups` is
  // the number of groups in the film.
  RoundPlanner(const AdaptiveSettings& settings, int width, int height, uint32_t seed,
               int light_groups = 0);

  // Makes the error estimates apply to `averages`, which must outlive the planner. From the first
  // round on, the picture shows these averages instead of the plain means of all samples.
  void set_averages(const RoundAverages* averages) { averages_ = averages; }

  // The sample count of each pixel after the coming round. Before the first plan(), all pixels have
  // the same count.
  std::span<const uint32_t> targets() const { return targets_; }
  // Reads a film in which every pixel has its target number of samples, and sets the next targets.
  // Returns false if no more samples are needed or a stop was requested; the targets then do not
  // change.
  bool plan(const FilmTile& film, const std::stop_token& stop = {});
  // Returns whether a stop request interrupted the last plan().
  bool interrupted() const { return interrupted_; }
  // Computes by how much each pixel's squared error is expected to fall between `current` and
  // `targets` samples, according to the last update. The gains are 0 before the first update.
  void expected_gains(std::span<const uint32_t> current, std::span<const uint32_t> targets,
                      std::vector<float>* gains) const;
  // Returns the result of allocate_frame() for the error estimates of the last update. The list is
  // empty before the first update, and for estimators with a batch size, which do not estimate
  // deviations.
  std::vector<uint32_t> planned_counts(const AdaptiveSettings& limits) const;
  // Raises the budget so that the work of the whole frame is about `factor` times the work so far.
  // This also enlarges the pilot if all pixels still have the same count. Call after plan() has
  // returned false because the budget was spent.
  void extend_work(double factor);
  // Predicts the work of the whole frame. Call when every pixel has its target number of samples.
  // Returns nullopt as long as the samples are too few. Takes as long as planning a round.
  std::optional<WorkForecast> forecast() const;
  // Updates only the error estimates. Returns false if a stop was requested.
  bool update(const FilmTile& film, const std::stop_token& stop = {});

  // Returns whether write_variances() writes variances that the film cannot compute itself.
  static bool has_variances(const AdaptiveSettings& settings) {
    return find_estimator(settings.estimator).halves || settings.unbiased;
  }
  // Writes into the film the pixel variances on which the last error_estimate() is based. Skips
  // pixels whose variance the film can compute itself. Must not be called while samples are added.
  void write_variances(FilmTile* film) const;

  // Returns the error of the whole crop (frame_error.h) at the last update. Returns NaN before the
  // first update, and for estimators whose error is not an RMS error.
  double error_estimate() const { return error_estimate_; }
  // Returns why the pixel would get no more samples if the frame ended now.
  PixelStop stop_of(size_t i) const;
  // For a frame that continues: returns the limit that a pixel with `current` samples had met at
  // the last update, or kUnfinished if it had met none. A pixel that met its limit may still get
  // samples that a round gives to all pixels.
  PixelStop current_stop(size_t i, uint32_t current) const;
  // With `unbiased`, returns the weight of the current round in a mean over rounds (RoundAverages).
  // The weight depends only on the settings, as RoundAverages requires.
  double round_weight() const { return round_weight_; }
  // Returns the seed of the current round's samples. With `unbiased`, each round has a new seed.
  uint32_t round_seed() const;
  int round() const { return round_; }
  const ErrorMap& errors() const { return errors_; }
  const JudgedChannels& judged() const { return judged_; }

  // From now on, records the state of the pixel with this index in every round, and drops the
  // records of any other pixel.
  void record(size_t pixel);
  size_t recorded() const { return recorded_; }
  std::span<const RoundRecord> records() const { return records_; }
  // Must be called before loading a state whose pilot is done, since the loaded pilot may be
  // smaller than these settings require.
  void skip_pilot() { pilot_done_ = true; }
  // Saves or loads the state, except for values that the next update recomputes.
  void archive(Archive& archive);
  uint64_t bytes() const;

 private:
  // Returns whether the rest of the budget is too small for a round.
  bool is_budget_spent() const;
  bool grow_pilot();
  bool allocate_by_deviation();
  void allocate_budget(double total);
  bool allocate_evenly();
  bool resample_noise_free_pixels();
  float scale_to_budget(float uniform_samples);
  bool unfinished(size_t i) const;
  FrameEstimates frame_estimates() const;
  std::optional<WorkForecast> predict() const;
  // Pixels that may get more samples in the coming round.
  struct OpenPixels {
    size_t count = 0;
    float largest_rate = 0.0f;
    OpenPixels& operator+=(const OpenPixels& other) {
      count += other.count;
      largest_rate = std::max(largest_rate, other.largest_rate);
      return *this;
    }
  };
  OpenPixels set_rates_and_bounds(size_t begin, size_t end);
  template <typename CountOf>
  void set_targets(const CountOf& count_of);
  void round_to_counts(float uniform_samples);
  void round_to_steps(float uniform_samples);
  bool averaged() const { return averages_ && !averages_->empty(); }
  bool doubles_counts() const { return entry_.halves && !settings_.unbiased; }

  AdaptiveSettings settings_;
  const EstimatorEntry& entry_;
  uint32_t seed_;
  double spent_ = 0.0;  // samples of the whole crop after the current round
  int round_ = 0;
  bool interrupted_ = false;
  uint32_t pilot_ = 0;
  bool pilot_done_ = false;
  double round_weight_ = 0.0;
  double planned_mean_ = 0.0;  // samples per pixel planned up to the current round, if unbiased
  double error_estimate_;
  std::vector<uint32_t> targets_;
  const RoundAverages* averages_ = nullptr;
  PixelStatistics statistics_;
  JudgedChannels judged_;
  SampleHalves halves_;  // used if the estimator needs halves
  ErrorMap errors_;
  std::vector<float> rates_, allocated_;
  std::vector<SampleBounds> bounds_;
  size_t recorded_;
  std::vector<RoundRecord> records_;
};

}  // namespace emberline
