#include "renderer/drivers/adaptive/round_planner.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderer/core/hash.h"
#include "renderer/core/parallel.h"

namespace emberline {
namespace {

// In one round a pixel's samples grow at most so many times, from at least so many: its present
// ones may be lucky.
constexpr float kPixelGrowth = 4.0f, kLeastTrusted = 4.0f;
// The share of each round that goes everywhere, whatever is known: what has been overlooked so far
// is found in the end.
constexpr float kUniformShare = 0.1f;
// Pixels whose error is to fall to the threshold get a little more than the estimate asks for.
constexpr float kThresholdMargin = 1.05f;

constexpr uint32_t kLeastPilot = 4, kMostPilot = 16;

// Without a threshold the pilot is an eighth of the budget: what it spends on pixels that turn out
// to need nothing is lost.
uint32_t pilot_samples(const AdaptiveSettings& s, const EstimatorEntry& entry) {
  uint32_t samples = entry.first_samples;
  if (s.min_samples > 0) {
    samples = s.min_samples;
  } else if (entry.batch == 0 && s.threshold <= 0.0f) {
    samples = std::clamp(s.budget / 8 / 4 * 4, kLeastPilot, kMostPilot);
  }
  if (s.budget > 0) samples = std::min(samples, s.budget);
  if (s.max_samples > 0) samples = std::min(samples, s.max_samples);
  return std::max(samples, 1u);
}

// Whole blocks of the sampler: pairs of dimensions are stratified by 8, streams alternate by 8.
uint32_t count_step(float wanted) { return wanted < 64.0f ? 8 : 16; }

constexpr double kUnlimited = 1e18;

constexpr size_t kGrain = 8192;

}  // namespace

RoundPlanner::RoundPlanner(const AdaptiveSettings& settings, int width, int height, uint32_t seed)
    : settings_(settings),
      entry_(find_estimator(settings.estimator)),
      estimator_(entry_.create({settings.threshold})),
      seed_(seed),
      error_estimate_(std::numeric_limits<double>::quiet_NaN()),
      recorded_(std::numeric_limits<size_t>::max()) {
  const size_t pixels = size_t(width) * size_t(height);
  const uint32_t pilot = pilot_samples(settings, entry_);
  targets_.assign(pixels, pilot);
  spent_ = double(pilot) * double(pixels);
  round_weight_ = planned_mean_ = pilot;
}

uint32_t RoundPlanner::round_seed() const {
  return settings_.unbiased && round_ > 0 ? hash_combine(seed_, uint32_t(round_)) : seed_;
}

void RoundPlanner::look(const FilmTile& film) {
  gather_statistics(film, &statistics_);
  estimator_->estimate(statistics_, settings_.allocation, &errors_);
  if (!entry_.rms_error) return;
  double sum = 0.0;
  for (const float error : errors_.error) sum += double(error) * double(error);
  error_estimate_ = std::sqrt(sum / std::max(1.0, double(errors_.error.size())));
}

bool RoundPlanner::unfinished(size_t i) const {
  if (settings_.max_samples > 0 && targets_[i] >= settings_.max_samples) return false;
  return !(settings_.threshold > 0.0f && errors_.error[i] <= settings_.threshold &&
           targets_[i] >= settings_.min_samples);
}

PixelStop RoundPlanner::stop_of(size_t i) const {
  if (settings_.threshold > 0.0f && !errors_.error.empty() &&
      errors_.error[i] <= settings_.threshold) {
    return PixelStop::kThreshold;
  }
  if (settings_.max_samples > 0 && targets_[i] >= settings_.max_samples) {
    return PixelStop::kMaximum;
  }
  return PixelStop::kBudget;
}

bool RoundPlanner::plan(const FilmTile& film) {
  look(film);
  ++round_;
  const double left = double(settings_.budget) * double(targets_.size()) - spent_;
  // Less than a rounding step for the frame, or for every thousandth pixel, is not worth a round.
  bool more = settings_.budget == 0 || left >= std::max(1.0, 8e-3 * double(targets_.size()));
  if (more) more = entry_.batch > 0 ? share_evenly() : share_by_deviation();
  double total = 0.0;
  for (const uint32_t count : targets_) total += count;
  if (!more || total <= spent_) return false;
  round_weight_ = settings_.unbiased ? planned_mean_ : (total - spent_) / double(targets_.size());
  planned_mean_ += planned_mean_;
  spent_ = total;
  return true;
}

// The share of the whole budget that is best by what is known now, of which the round goes as far
// as each pixel's present samples can vouch for.
bool RoundPlanner::share_by_deviation() {
  const size_t pixels = targets_.size();
  rates_.resize(pixels);
  bounds_.resize(pixels);
  size_t open = 0;
  for (size_t i = 0; i < pixels; ++i) {
    const auto have = float(targets_[i]);
    bounds_[i] = {have, unfinished(i) ? most_wanted(i) : have};
    open += bounds_[i].most > have;
    rates_[i] = errors_.deviation[i] / std::sqrt(statistics_.cost[i]);
  }
  if (open == 0) return false;
  double all = settings_.budget > 0 ? double(settings_.budget) : double(kUnlimited);
  // Rounds whose sizes are fixed beforehand: each brings as much as all before it.
  if (settings_.unbiased) all = std::min(all, 2 * planned_mean_);
  share_samples(rates_, bounds_, all * double(pixels), &shares_);
  double more = 0.0;
  for (size_t i = 0; i < pixels; ++i) {
    const auto have = float(targets_[i]);
    shares_[i] = std::min(shares_[i], kPixelGrowth * std::max(have, kLeastTrusted));
    more += double(shares_[i] - have);
  }
  round_to_counts(float(kUniformShare * more / double(pixels)));
  return true;
}

// The samples that would bring the pixel to the threshold, or the most it may have.
float RoundPlanner::most_wanted(size_t i) const {
  const float most = settings_.max_samples > 0 ? float(settings_.max_samples) : float(1u << 24);
  if (settings_.threshold <= 0.0f) return most;
  const auto have = float(targets_[i]);
  const float ratio = std::min(errors_.error[i] / settings_.threshold, 1e6f);
  return std::min(most, std::max(have * ratio * ratio * kThresholdMargin, have + 8.0f));
}

// From shares to whole counts, with at least `everywhere` samples more for each pixel on average.
void RoundPlanner::round_to_counts(float everywhere) {
  const uint32_t round_hash = hash_combine(hash_combine(hash32(seed_), 0x7a11u), uint32_t(round_));
  const float most = settings_.max_samples > 0 ? float(settings_.max_samples) : float(1u << 24);
  parallel_ranges(targets_.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const uint32_t have = targets_[i];
      const float u = to_unit_float(hash_combine(round_hash, uint32_t(i)));
      const float share = std::min(std::max(shares_[i], float(have) + everywhere), most);
      uint32_t count = round_count(have, share, count_step(share), u);
      if (settings_.unbiased) count = std::max(count, have + 1);
      count = std::max(have, std::min(count, uint32_t(most)));
      if (i == recorded_) {
        records_.push_back(
            {round_, have, errors_.error[i], errors_.deviation[i], statistics_.cost[i], count});
      }
      targets_[i] = count;
    }
  });
}

// Every unfinished pixel gets the same. Where only a budget is given, the half of the pixels with
// the larger errors counts as unfinished.
bool RoundPlanner::share_evenly() {
  const size_t pixels = targets_.size();
  const double left = settings_.budget > 0 ? double(settings_.budget) * double(pixels) - spent_
                                           : std::numeric_limits<double>::infinity();
  std::vector<uint32_t> open;
  for (size_t i = 0; i < pixels; ++i) {
    if (unfinished(i)) open.push_back(uint32_t(i));
  }
  const auto larger_error = [&](uint32_t a, uint32_t b) {
    return errors_.error[a] != errors_.error[b] ? errors_.error[a] > errors_.error[b] : a < b;
  };
  size_t chosen = open.size();
  if (settings_.threshold <= 0.0f) chosen = (chosen + 1) / 2;
  chosen = size_t(std::min(double(chosen), std::floor(left / entry_.batch)));
  if (chosen == 0) return false;
  if (chosen < open.size()) {
    std::nth_element(open.begin(), open.begin() + std::ptrdiff_t(chosen) - 1, open.end(),
                     larger_error);
    open.resize(chosen);
  }
  for (const uint32_t i : open) {
    const uint32_t have = targets_[i];
    uint32_t count = have + entry_.batch;
    if (settings_.max_samples > 0) count = std::min(count, settings_.max_samples);
    targets_[i] = count;
    if (i == recorded_) {
      records_.push_back({round_, have, errors_.error[i], 0.0f, statistics_.cost[i], count});
    }
  }
  return true;
}

uint64_t RoundPlanner::bytes() const {
  // Statistics have twelve planes, the map two.
  return targets_.capacity() * sizeof(uint32_t) + 12 * statistics_.size() * sizeof(float) +
         (errors_.error.capacity() + errors_.deviation.capacity() + rates_.capacity() +
          shares_.capacity()) *
             sizeof(float) +
         bounds_.capacity() * sizeof(SampleBounds);
}

}  // namespace emberline
