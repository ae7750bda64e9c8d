#include "renderer/drivers/adaptive/round_planner.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "renderer/core/archive.h"
#include "renderer/core/hash.h"
#include "renderer/core/parallel.h"
#include "renderer/core/vector.h"
#include "renderer/drivers/adaptive/frame_allocation.h"
#include "renderer/drivers/adaptive/frame_error.h"
#include "renderer/drivers/adaptive/missed_light.h"
#include "renderer/drivers/adaptive/ordered_sum.h"
#include "renderer/drivers/driver_choices.h"
#include "renderer/film/film.h"

namespace emberline {
namespace {

// In one round a pixel's count grows to at most kMaxGrowth times the larger of its present count
// and kMinTrusted, since the present samples may have been lucky.
constexpr float kMaxGrowth = 4.0f, kMinTrusted = 4.0f;
// The uniform share: this fraction of each round is spread evenly over all pixels, so that
// overlooked light is found eventually.
constexpr float kUniformFraction = 0.1f;
// The smallest fraction of the budget that is worth a round.
constexpr double kMinRoundFraction = 1.0 / 500;

// A few samples without any noise prove little: a point that is lit by a caustic, or through a gap,
// is black until a path finds the light. So noise-free pixels get more samples until all such
// pixels of a crop together have kNoiselessSamples, or until each has kNoiselessGrowth times the
// pilot. With 95 % confidence, n samples find light that one path in n / 3 reaches. For
// kNoiselessSamples, this is one path in 44 000.
constexpr uint64_t kNoiselessSamples = 1 << 17;
constexpr uint32_t kNoiselessGrowth = 64;
// An error below this fraction of the threshold is rounding noise.
constexpr float kNoiselessFraction = 1e-6f;

// Estimators with halves (EstimatorEntry) take the pilot in rounds: the first update comes at this
// many samples, and then one at every doubling.
constexpr uint32_t kFirstHalf = 8;
// With a time budget, the first update comes at this many samples.
constexpr uint32_t kFirstOpenRound = 2;

// Without a threshold, the pilot is an eighth of the budget in whole blocks: 8 or 16 samples. A
// larger pilot wastes samples on pixels that need none; a smaller one overlooks wires thinner than
// a pixel, which are seldom found later.
uint32_t pilot_samples(const AdaptiveSettings& s, const EstimatorEntry& entry) {
  uint32_t samples = entry.first_samples;
  if (s.min_samples > 0) {
    samples = s.min_samples;
  } else if (entry.batch == 0 && s.threshold <= 0.0f) {
    samples = std::clamp(s.budget / 8 / 8 * 8, kMinPilot, kMaxPilot);
  }
  // With fewer samples, the film's second half would have no samples.
  if (s.two_halves) samples = std::max(samples, kMaxPilot);
  if (s.budget > 0) samples = std::min(samples, s.budget);
  if (s.max_samples > 0) samples = std::min(samples, s.max_samples);
  return std::max(samples, 1u);
}

bool is_unfinished(const AdaptiveSettings& s, uint32_t current, float error) {
  const bool full = s.max_samples > 0 && current >= s.max_samples;
  const bool good = s.threshold > 0.0f && error <= s.threshold && current >= s.min_samples;
  return !full && !good;
}

// Returns the sample count that brings the pixel to the threshold, or its maximum if that is less.
float samples_to_threshold(const AdaptiveSettings& s, float current, float error, bool halves) {
  const float maximum = sample_limit(s);
  if (s.threshold <= 0.0f) return maximum;
  const float ratio = std::min(error / s.threshold, 1e6f);
  // Adds at least a whole step, so that rounding never ends a pixel above the threshold.
  const float minimum = current + float(count_multiple(current + 8.0f, halves));
  return std::min(maximum, std::max(current * ratio * ratio * kThresholdMargin, minimum));
}

uint32_t hash_of_round(uint32_t seed, int round) {
  return hash_combine(hash_combine(hash32(seed), 0x7a11u), uint32_t(round));
}

// Returns the next power of two above `current`, which must be below 2^24.
float next_power_of_two(float current) { return float(std::bit_ceil(uint32_t(current) + 1)); }

// With unequal counts, the pilot is over, whatever its size.
bool all_equal(std::span<const uint32_t> counts) {
  return counts.empty() || std::ranges::min(counts) == std::ranges::max(counts);
}

// Limits the number of rounds in a loaded state. A round spends a 500th of the budget or doubles
// counts, so real frames have far fewer.
constexpr int kMaxRounds = 1 << 20;

constexpr size_t kGrain = 8192;

}  // namespace

RoundPlanner::RoundPlanner(const AdaptiveSettings& settings, int width, int height, uint32_t seed,
                           int light_groups)
    : settings_(settings),
      entry_(find_estimator(settings.estimator)),
      seed_(seed),
      error_estimate_(std::numeric_limits<double>::quiet_NaN()),
      judged_(settings.judged, settings.threshold, light_groups),
      halves_(settings.unbiased ? SampleParts::kEveryUpdate : SampleParts::kPowersOfTwo,
              judged_.value_count()),
      recorded_(std::numeric_limits<size_t>::max()) {
  const size_t pixels = size_t(width) * size_t(height);
  pilot_ = pilot_samples(settings, entry_);
  // If the time may end before a pilot in rounds does, the rounds begin small, so that all pixels
  // have about as many samples.
  const uint32_t first_round = settings.is_open ? kFirstOpenRound : kFirstHalf;
  const uint32_t first = entry_.halves ? std::min(pilot_, first_round) : pilot_;
  targets_.assign(pixels, first);
  spent_ = double(first) * double(pixels);
  round_weight_ = planned_mean_ = first;
}

uint32_t RoundPlanner::round_seed() const {
  return settings_.unbiased && round_ > 0 ? hash_combine(seed_, uint32_t(round_)) : seed_;
}

// For a large frame, each step takes tens of milliseconds, so `stop` is checked between steps.
bool RoundPlanner::update(const FilmTile& film, const std::stop_token& stop) {
  gather_statistics(film, &statistics_);
  if (stop.stop_requested()) return false;
  if (entry_.halves) {
    const auto read_means = [&](size_t i, float* means) { judged_.read_means(film, i, means); };
    judged_.value_count() > 0 ? halves_.update(&statistics_, read_means)
                              : halves_.update(&statistics_);
  }
  entry_.estimate(statistics_, {settings_.threshold, settings_.allocation}, &errors_);
  if (!judged_.is_default()) judged_.update(film, statistics_, halves_, &errors_);
  if (stop.stop_requested()) return false;
  if (entry_.rms_error) {
    // An estimator with a batch size judges each pixel only by its own samples, so its frame error
    // leaves out light that the samples missed.
    const double missed = entry_.batch == 0 ? missed_light_error(statistics_) : 0.0;
    error_estimate_ = averaged() ? frame_error(*averages_, statistics_.size(), missed)
                                 : frame_error(statistics_, missed);
  }
  return true;
}

void RoundPlanner::write_variances(FilmTile* film) const {
  if (!has_variances(settings_) || !film->stores_sample_variance()) return;
  const PixelStatistics& p = statistics_;
  const bool averaged = this->averaged();
  parallel_ranges(p.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      // A pixel whose samples are all in one stream and one half is skipped: the film can compute
      // its variance itself.
      const bool has_two_parts = p.second_count[i] > 0.0f || film->sums(i).count[1] > 0;
      if (p.count[i] < 2.0f || !(has_two_parts || averaged)) continue;
      Rgb variance;
      for (size_t c = 0; c < 3; ++c) {
        // The film divides this value by its present count.
        variance[int(c)] = averaged ? float(averages_->variance(i, c) * film->sums(i).samples())
                                    : sample_variance(p.count[i], p.second_count[i],
                                                      p.stream_difference[c][i], p.variance[c][i]);
      }
      film->set_sample_variance(i, variance);
    }
  });
}

bool RoundPlanner::unfinished(size_t i) const {
  return is_unfinished(settings_, targets_[i], errors_.error[i]);
}

void RoundPlanner::record(size_t pixel) {
  if (pixel != recorded_) records_.clear();
  recorded_ = pixel;
  judged_.record(pixel);
}

PixelStop RoundPlanner::stop_of(size_t i) const {
  if (settings_.threshold > 0.0f && !errors_.error.empty() &&
      errors_.error[i] <= settings_.threshold) {
    return PixelStop::kThreshold;
  }
  if (settings_.max_samples > 0 && targets_[i] >= settings_.max_samples) {
    return PixelStop::kMaximum;
  }
  return settings_.is_open ? PixelStop::kTimeBudget : PixelStop::kBudget;
}

PixelStop RoundPlanner::current_stop(size_t i, uint32_t current) const {
  constexpr float kUnknown = std::numeric_limits<float>::infinity();
  const float error = errors_.error.empty() ? kUnknown : errors_.error[i];
  return is_unfinished(settings_, current, error) ? PixelStop::kUnfinished : stop_of(i);
}

// Estimators that add samples in batches (EstimatorEntry::batch) do not estimate the deviation of a
// sample, so the gain is computed from the error that they estimate.
void RoundPlanner::expected_gains(std::span<const uint32_t> current,
                                  std::span<const uint32_t> targets,
                                  std::vector<float>* gains) const {
  gains->resize(current.size());
  const bool unknown = errors_.error.empty();
  parallel_ranges(current.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      if (unknown || targets[i] <= current[i]) {
        (*gains)[i] = 0.0f;
        continue;
      }
      const float now = entry_.batch > 0 ? square(errors_.error[i])
                                         : square(errors_.deviation[i]) / float(current[i]);
      (*gains)[i] = now * (1.0f - float(current[i]) / float(targets[i]));
    }
  });
}

// The rest of the budget is too small for a round if it is less than one sample, less than 8
// samples per thousand pixels, or less than a 500th of the budget.
bool RoundPlanner::is_budget_spent() const {
  const auto pixels = double(targets_.size());
  const double left = double(settings_.budget) * pixels - spent_;
  const double minimum = std::max(8e-3, kMinRoundFraction * double(settings_.budget));
  return settings_.budget > 0 && left < std::max(1.0, minimum * pixels);
}

bool RoundPlanner::plan(const FilmTile& film, const std::stop_token& stop) {
  interrupted_ = !update(film, stop);
  if (interrupted_) return false;
  ++round_;
  bool more = !is_budget_spent();
  // The number and sizes of unbiased rounds are fixed: each takes as many samples as all rounds
  // before it, up to the budget.
  const double planned = std::min(double(settings_.budget), 2 * planned_mean_);
  if (settings_.unbiased) more = planned > planned_mean_;
  if (more && !grow_pilot()) more = entry_.batch > 0 ? allocate_evenly() : allocate_by_deviation();
  const auto total = double(std::accumulate(targets_.begin(), targets_.end(), uint64_t{0}));
  if (!more || total <= spent_) return false;
  if (settings_.unbiased) {
    round_weight_ = planned - planned_mean_;
    planned_mean_ = planned;
  }
  spent_ = total;
  return true;
}

// Doubles all counts, up to the pilot. Returns false if they need not grow.
bool RoundPlanner::grow_pilot() {
  if (pilot_done_ || !doubles_counts() || targets_.empty() || targets_[0] >= pilot_) return false;
  std::ranges::fill(targets_, std::min(pilot_, 2 * targets_[0]));
  return true;
}

// First distributes the whole budget optimally for the present estimates. Then limits the growth of
// each pixel's count, because its present samples may be misleading.
bool RoundPlanner::allocate_by_deviation() {
  const size_t pixels = targets_.size();
  bounds_.resize(pixels);
  const std::array<std::vector<float>*, 2> planes = {&rates_, &allocated_};
  resize_planes(planes, pixels);
  const OpenPixels open = ordered_sum(
      pixels, [&](size_t begin, size_t end) { return set_rates_and_bounds(begin, end); });
  if (open.count == 0) return resample_noise_free_pixels();
  // If no pixel has shown noise, all get the same rate, because they may still be noisy.
  if (open.largest_rate == 0.0f) {
    for (size_t i = 0; i < pixels; ++i)
      rates_[i] = doubles_counts() ? jitter_rate(1.0f, seed_, i) : 1.0f;
  }
  double all = settings_.budget > 0 ? double(settings_.budget) : double(kUnlimited);
  if (settings_.unbiased) all = std::min(all, 2 * planned_mean_);
  allocate_budget(all * double(pixels));
  const bool doubling = doubles_counts();
  const double more = ordered_sum(pixels, [&](size_t begin, size_t end) {
    float lanes[kSumLanes] = {};
    float* allocated = allocated_.data();
    const uint32_t* targets = targets_.data();
    for_lanes(begin, end, [&](size_t i, size_t lane) {
      const auto current = float(targets[i]);
      const float trusted = kMaxGrowth * std::max(current, kMinTrusted);
      allocated[i] = std::min(allocated[i], doubling ? next_power_of_two(current) : trusted);
      lanes[lane] += allocated[i] - current;
    });
    return sum_of_lanes(lanes);
  });
  const auto uniform_samples = float(kUniformFraction * more / double(pixels));
  if (doubling && settings_.budget > 0) {
    round_to_steps(uniform_samples);
  } else {
    round_to_counts(scale_to_budget(uniform_samples));
  }
  return true;
}

// Doubles the samples of pixels whose camera rays hit something but which, like their neighbours,
// show no noise. Stops when these pixels have kNoiselessSamples in total. For example, a small
// bucket may be black after its pilot because only one path in thousands finds the light. Unbiased
// rounds need samples of every pixel, so all pixels double if one does. Called only if no pixel
// would otherwise get more samples.
bool RoundPlanner::resample_noise_free_pixels() {
  const size_t pixels = targets_.size();
  const auto noiseless = [&](size_t i) {
    return errors_.error[i] <= kNoiselessFraction * settings_.threshold &&
           statistics_.cost[i] > kCameraRayCost;
  };
  bool all = false;
  for (size_t i = 0; settings_.unbiased && i < pixels && !all; ++i) all = noiseless(i);
  uint64_t samples = 0;
  for (size_t i = 0; i < pixels; ++i) samples += all || noiseless(i) ? targets_[i] : 0;
  const bool affordable = settings_.budget == 0 ||
                          spent_ + double(samples) <= double(settings_.budget) * double(pixels);
  if (settings_.threshold <= 0.0f || samples >= kNoiselessSamples || !affordable) return false;
  const auto maximum = std::min(uint32_t(sample_limit(settings_)), kNoiselessGrowth * pilot_);
  if (all && std::ranges::max(targets_) >= maximum) return false;
  set_targets([&](size_t i, uint32_t current, float) {
    return all || noiseless(i) ? std::max(current, std::min(2 * current, maximum)) : current;
  });
  return true;
}

// Counts that grow in steps cannot be reduced slightly to make room for the uniform share, so a
// part of the remaining budget is reserved for that share.
void RoundPlanner::allocate_budget(double total) {
  if (!doubles_counts() || settings_.budget == 0)
    return allocate_samples(rates_, bounds_, total, &allocated_);
  allocate_steps(rates_, bounds_, total - kUniformFraction * (total - spent_), &allocated_);
}

// The allocated samples and the uniform share may exceed the remaining budget, so this scales both
// by one factor. Returns the scaled uniform share.
float RoundPlanner::scale_to_budget(float uniform_samples) {
  if (settings_.budget == 0) return uniform_samples;
  const size_t pixels = targets_.size();
  const uint32_t* targets = targets_.data();
  float* allocated = allocated_.data();
  const double more = ordered_sum(pixels, [&](size_t begin, size_t end) {
    float lanes[kSumLanes] = {};
    for_lanes(begin, end, [&](size_t i, size_t lane) {
      lanes[lane] += std::max(allocated[i] - float(targets[i]), uniform_samples);
    });
    return sum_of_lanes(lanes);
  });
  const double left = double(settings_.budget) * double(pixels) - spent_;
  const auto part = float(std::clamp(left / std::max(more, 1e-9), 0.0, 1.0));
  parallel_ranges(pixels, kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const auto current = float(targets[i]);
      allocated[i] = current + part * (allocated[i] - current);
    }
  });
  return part * uniform_samples;
}

// Sets the rates and bounds of a range of pixels and summarises the pixels that may get more
// samples. The loop's inputs are copies or pointers, so that the loop vectorises.
RoundPlanner::OpenPixels RoundPlanner::set_rates_and_bounds(size_t begin, size_t end) {
  const AdaptiveSettings s = settings_;
  const bool halves = entry_.halves;
  const uint32_t* targets = targets_.data();
  const float *error = errors_.error.data(), *deviation = errors_.deviation.data(),
              *cost = statistics_.cost.data();
  float* rates = rates_.data();
  SampleBounds* bounds = bounds_.data();
  uint32_t open[kSumLanes] = {};
  float largest_rate[kSumLanes] = {};
  for_lanes(begin, end, [&](size_t i, size_t lane) {
    const auto current = float(targets[i]);
    const float wanted = samples_to_threshold(s, current, error[i], halves);
    const float maximum = is_unfinished(s, targets[i], error[i]) ? wanted : current;
    bounds[i].minimum = current;
    bounds[i].maximum = maximum;
    open[lane] += maximum > current ? 1u : 0u;
    rates[i] = deviation[i] / std::sqrt(cost[i]);
  });
  if (doubles_counts()) {
    for (size_t i = begin; i < end; ++i) rates[i] = jitter_rate(rates[i], seed_, i);
  }
  for_lanes(begin, end, [&](size_t i, size_t lane) {
    const float rate = bounds[i].maximum > bounds[i].minimum ? rates[i] : 0.0f;
    largest_rate[lane] = std::max(largest_rate[lane], rate);
  });
  return {size_t(sum_of_lanes(open)), std::ranges::max(largest_rate)};
}

// Sets each target to count_of(i, present target, allocated count), and updates the records.
template <typename CountOf>
void RoundPlanner::set_targets(const CountOf& count_of) {
  const bool recording = recorded_ < targets_.size();
  const uint32_t samples_before = recording ? targets_[recorded_] : 0;
  parallel_ranges(targets_.size(), kGrain, [&](size_t begin, size_t end) {
    uint32_t* targets = targets_.data();
    const float* allocated = allocated_.data();
    for (size_t i = begin; i < end; ++i) targets[i] = count_of(i, targets[i], allocated[i]);
  });
  if (recording) {
    const size_t i = recorded_;
    records_.push_back({round_, samples_before, errors_.error[i], errors_.deviation[i],
                        statistics_.cost[i], targets_[i], judged_.recorded_channel()});
  }
}

// Rounds the allocated counts to whole numbers of samples. On average, each pixel gets at least
// `uniform_samples` more samples.
void RoundPlanner::round_to_counts(float uniform_samples) {
  const uint32_t round_hash = hash_of_round(seed_, round_);
  const float maximum = sample_limit(settings_);
  const auto max_count = uint32_t(maximum);
  const uint32_t min_increase = settings_.unbiased ? 1 : 0;
  const bool doubling = doubles_counts();
  set_targets([&](size_t i, uint32_t current, float wanted) {
    // If counts double, even the uniform share must not raise a count beyond the next power of two.
    // Otherwise one of the two parts that SampleHalves compares could be much smaller than the
    // other, and a bright sample in the larger part would hardly show.
    const float cap = doubling ? std::min(maximum, next_power_of_two(float(current))) : maximum;
    const float share = std::min(std::max(wanted, float(current) + uniform_samples), cap);
    // The maximum need not be a multiple of the step, and random rounding might never reach it. So
    // a share equal to the maximum is always rounded up and then clipped.
    const float chance = to_unit_float(hash_combine(round_hash, uint32_t(i)));
    const float u = share < maximum ? chance : 0.0f;
    const uint32_t count = round_count(current, share, count_multiple(share, entry_.halves), u);
    return std::max(current, std::min(std::max(count, current + min_increase), max_count));
  });
}

// The allocated counts are already whole steps (allocate_steps()). Randomly chosen pixels advance
// at least to the next power of two, so that each pixel gets at least `uniform_samples` more
// samples on average.
void RoundPlanner::round_to_steps(float uniform_samples) {
  const uint32_t round_hash = hash_of_round(seed_, round_);
  const float maximum = sample_limit(settings_);
  set_targets([&](size_t i, uint32_t current, float share) {
    const auto now = float(current);
    const float next = std::min(next_power_of_two(now), maximum);
    const float chance = to_unit_float(hash_combine(round_hash, uint32_t(i)));
    const bool found = chance * (next - now) < uniform_samples;
    // Rounds up, because the limit by a threshold or --max-spp may leave a fraction of a sample.
    return std::max(current, uint32_t(std::ceil(found ? std::max(share, next) : share)));
  });
}

// Gives each unfinished pixel a batch of samples. Without a threshold, only half of the unfinished
// pixels get one: those with the larger errors.
bool RoundPlanner::allocate_evenly() {
  const size_t pixels = targets_.size();
  const double left = settings_.budget > 0 ? double(settings_.budget) * double(pixels) - spent_
                                           : std::numeric_limits<double>::infinity();
  std::vector<uint32_t> open;
  for (size_t i = 0; i < pixels; ++i) {
    if (unfinished(i)) open.push_back(uint32_t(i));
  }
  // The order of equal errors differs between rounds, so that no part of the crop is preferred.
  const uint32_t round_hash = hash_of_round(seed_, round_);
  const auto larger_error = [&](uint32_t a, uint32_t b) {
    if (errors_.error[a] != errors_.error[b]) return errors_.error[a] > errors_.error[b];
    return hash_combine(round_hash, a) < hash_combine(round_hash, b);
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
    const uint32_t current = targets_[i];
    uint32_t count = current + entry_.batch;
    if (settings_.max_samples > 0) count = std::min(count, settings_.max_samples);
    targets_[i] = count;
    if (i == recorded_) {
      records_.push_back({round_, current, errors_.error[i], 0.0f, statistics_.cost[i], count});
    }
  }
  return true;
}

FrameEstimates RoundPlanner::frame_estimates() const { return {statistics_, errors_, seed_}; }

std::vector<uint32_t> RoundPlanner::planned_counts(const AdaptiveSettings& limits) const {
  if (errors_.error.empty() || entry_.batch > 0) return {};
  return allocate_frame(frame_estimates(), limits);
}

std::optional<WorkForecast> RoundPlanner::predict() const {
  if (errors_.error.empty() || statistics_.size() != targets_.size() || entry_.batch > 0) {
    return std::nullopt;
  }
  return predict_work(frame_estimates(), settings_, targets_);
}

// In the first round, there are no halves to compare yet.
std::optional<WorkForecast> RoundPlanner::forecast() const {
  return round_ < 2 ? std::nullopt : predict();
}

// First predicts the work for the budget that would be right if all samples had the same cost. Then
// interpolates linearly between the present work and the predicted work.
void RoundPlanner::extend_work(double factor) {
  const double now = spent_ / double(targets_.size());
  const auto set_mean = [&](double mean) {
    settings_.budget = uint32_t(std::clamp(std::ceil(mean), now, double(kMaxSamples)));
  };
  set_mean(now * factor);
  const std::optional<WorkForecast> predicted = predict();
  if (predicted && predicted->work > 1) {
    set_mean(now + (double(settings_.budget) - now) * (factor - 1) / (predicted->work - 1));
  }
  if (all_equal(targets_)) pilot_ = pilot_samples(settings_, entry_);
}

void RoundPlanner::archive(Archive& archive) {
  const size_t pixels = targets_.size();
  if (settings_.is_open) archive.number(settings_.budget, 1u, kMaxSamples);
  archive.number(spent_, 0.0, kUnlimited);
  archive.number(round_, 0, kMaxRounds);
  archive.number(round_weight_, 0.0, kUnlimited);
  archive.number(planned_mean_, 0.0, kUnlimited);
  archive.number(error_estimate_, 0.0, std::numeric_limits<double>::infinity(), true);
  archive.array(targets_, pixels);
  archive.check(targets_.size() == pixels);
  // A bad file might request a year of work, so totals that no round would plan are rejected.
  uint64_t total = 0;
  for (const uint32_t target : targets_) {
    archive.check(target > 0 && float(target) <= sample_limit(settings_));
    total += target;
  }
  archive.check(spent_ == double(total));
  archive.check(settings_.budget == 0 || total <= 2 * uint64_t(settings_.budget) * pixels);
  if (settings_.is_open && archive.loading()) {
    // extend_work() may have raised the budget, and with it the pilot.
    pilot_ = pilot_samples(settings_, entry_);
    pilot_done_ |= !all_equal(targets_);
  }
  halves_.archive(archive, pixels);
  archive.array(errors_.error, pixels);
  archive.array(errors_.deviation, pixels);
  for (const auto* values : {&errors_.error, &errors_.deviation}) {
    for (const float value : *values) archive.check(value >= 0.0f);
  }
  archive.check(entry_.batch > 0 || errors_.error.size() == errors_.deviation.size());
  archive.number(recorded_, size_t(0), std::numeric_limits<size_t>::max());
  archive.list(records_, kMaxRounds);
  for (const RoundRecord& record : records_) archive.check(record.judged < judged_.size());
  judged_.record(recorded_);
  judged_.archive(archive, pixels);
}

uint64_t RoundPlanner::bytes() const {
  // The statistics have twelve planes.
  return halves_.bytes() + judged_.bytes() + targets_.capacity() * sizeof(uint32_t) +
         12 * statistics_.size() * sizeof(float) +
         (errors_.error.capacity() + errors_.deviation.capacity() + rates_.capacity() +
          allocated_.capacity()) *
             sizeof(float) +
         bounds_.capacity() * sizeof(SampleBounds);
}

}  // namespace emberline
