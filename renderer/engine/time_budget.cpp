#include "renderer/engine/time_budget.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <numbers>
#include <numeric>
#include <utility>

#include "renderer/drivers/adaptive/pixel_statistics.h"
#include "renderer/drivers/driver_choices.h"

namespace emberline {
namespace {

// The fractions of the time at which the work of the first plan, of the first correction and of the
// second correction ends. The last one is planned too long on purpose: a frame that takes too long
// is stopped in time, but a frame that ends early cannot continue.
constexpr double kStages[] = {0.6, 0.93, 1.1};

// The work of a resumed frame grows by this factor to measure the pace.
constexpr double kProbe = 1.25;

// The counts are corrected when tiles with these fractions of the total cost have begun.
constexpr double kTileCorrections[] = {0.3, 0.88};

// Corrections aim at this fraction of the time, because frames then end in time on average. With 1,
// 30 frames of six scenes ended 2.4 % late on average; with 0.98, 1.3 % early.
constexpr double kAim = 0.99;

// A correction changes the count by at most this factor, because the predictions for single tiles
// may be wrong.
constexpr double kMaxCorrection = 4;

// The least work of a tile. It avoids divisions by 0.
constexpr double kMinWork = 1e-9;

// Returns a stride near count / phi, because multiples of the golden ratio, modulo 1, are spread
// evenly.
size_t spreading_stride(size_t count) {
  auto stride = size_t(std::max(1.0, double(count) / std::numbers::phi));
  while (std::gcd(stride, count) > 1) ++stride;
  return stride;
}

// Returns the tiles by falling powers of two of their cost, and spread evenly within each power.
std::vector<size_t> tile_order(std::span<const double> costs) {
  const size_t stride = spreading_stride(costs.size());
  std::vector<size_t> order;
  for (size_t n = 0; n < costs.size(); ++n) order.push_back(n * stride % costs.size());
  std::ranges::stable_sort(order, std::ranges::greater(),
                           [&](size_t i) { return std::ilogb(std::max(costs[i], kMinWork)); });
  return order;
}

}  // namespace

double work_of(const RayCounters& rays) {
  return double(kCameraRayCost) * double(rays.camera) + double(rays.scatter + rays.shadow);
}

std::optional<double> FrameBudget::next_factor(double work) {
  const double now_s = clock_(), work_since = work - last_work_;
  // Skips the stages whose end is near or past.
  while (stage_ < std::size(kStages) && now_s > 0.9 * kStages[stage_] * seconds_) ++stage_;
  if (work_since > 0) pace_ = (now_s - last_s_) / work_since;
  // If an earlier run has done all planned work, the pace of this run is not known yet.
  const bool is_unknown = work > 0 && pace_ == 0 && stage_ < std::size(kStages);
  if (is_unknown && !std::exchange(has_probed_, true)) return kProbe;
  if (stage_ == std::size(kStages) || !(pace_ * work > 0)) return std::nullopt;
  const double factor = 1 + (kStages[stage_] * seconds_ - now_s) / (pace_ * work);
  ++stage_;
  last_work_ = work;
  last_s_ = now_s;
  return factor;
}

void TileCost::add(double work, double seconds) {
  const double pace = seconds / std::max(work, kMinWork);
  pace_ = count_ == 0 ? pace : std::min(pace_, pace);
  work_ += work;
  seconds_ += seconds;
  ++count_;
}

// Limits paces to a range around their median, because all measurements of a tile may have been
// slow.
std::vector<double> tile_seconds(std::span<const TileCost> costs) {
  constexpr double kRange = 2;
  std::vector<double> paces, seconds;
  for (const TileCost& cost : costs) paces.push_back(cost.pace());
  const auto middle = paces.begin() + std::ptrdiff_t(paces.size() / 2);
  std::ranges::nth_element(paces, middle);
  const double median = paces.empty() ? 0 : *middle;
  for (const TileCost& cost : costs) {
    seconds.push_back(cost.work() * std::clamp(cost.pace(), median / kRange, median * kRange));
  }
  return seconds;
}

double tile_pauses(std::span<const TileCost> costs) {
  constexpr double kMaxPauses = 4;  // limits the effect of one long pause
  double measured = 0, least = 0;
  for (const TileCost& cost : costs) {
    measured += cost.seconds();
    least += cost.work() * cost.pace();
  }
  return least > 0 ? std::min(measured / least, kMaxPauses) : 1;
}

TileBudget::TileBudget(double seconds, BudgetClock clock, std::vector<double> costs,
                       double seconds_per_work, uint32_t least)
    : seconds_(seconds),
      clock_(std::move(clock)),
      began_s_(clock_()),
      costs_(std::move(costs)),
      order_(tile_order(costs_)),
      seconds_per_work_(seconds_per_work),
      least_(least) {
  for (const double cost : costs_) all_ += cost;
  left_ = all_;
  plan();
}

void TileBudget::plan() {
  const double wanted = (seconds_ - began_s_) / std::max(all_ * seconds_per_work_, kMinWork);
  samples_ = std::clamp(wanted, least_, double(kMaxSamples));
}

// Assumes the pace of the work so far, and that all tiles in progress advance equally fast, because
// helpers share their work. Returns false without a correction if too few tiles are finished.
bool TileBudget::correct() {
  const double now_s = clock_(), elapsed_s = now_s - began_s_;
  double in_progress = 0, begun = 0;
  for (const Tile& tile : begun_) begun += tile.work;
  if (finished_ < 2 * begun || !(finished_ > 0 && left_ > 0 && elapsed_s > 0)) return false;
  const double pace = (finished_ + 0.5 * begun) / elapsed_s;
  for (const Tile& tile : begun_) {
    in_progress += std::min(tile.work, (now_s - tile.began_s) * pace / double(begun_.size()));
  }
  const double done = finished_ + in_progress;
  const double wanted =
      ((kAim * seconds_ - now_s) * done / elapsed_s - (begun - in_progress)) / left_;
  const double limited = std::clamp(wanted, samples_ / kMaxCorrection, samples_ * kMaxCorrection);
  samples_ = std::clamp(limited, least_, double(kMaxSamples));
  return true;
}

void TileBudget::skip(size_t tile) {
  const std::lock_guard lock(mutex_);
  all_ -= costs_[tile];
  left_ -= costs_[tile];
  if (corrections_ == 0) plan();
}

uint32_t TileBudget::begin(size_t tile) {
  const std::lock_guard lock(mutex_);
  if (corrections_ < std::size(kTileCorrections) &&
      all_ - left_ >= kTileCorrections[corrections_] * all_ && correct()) {
    ++corrections_;
  }
  // Carries the rounding error over to the next tile, so that the mean count is right.
  const double count = std::clamp(std::round(samples_ + rounding_), least_, double(kMaxSamples));
  rounding_ += samples_ - count;
  left_ -= costs_[tile];
  begun_.push_back({tile, count * costs_[tile], clock_()});
  return uint32_t(count);
}

void TileBudget::end(size_t tile) {
  const std::lock_guard lock(mutex_);
  const auto at = std::ranges::find(begun_, tile, &Tile::index);
  finished_ += at->work;
  begun_.erase(at);
}

}  // namespace emberline
