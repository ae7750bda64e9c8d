#include "renderer/engine/time_budget.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "renderer/drivers/adaptive/pixel_statistics.h"
#include "renderer/drivers/driver_choices.h"

namespace emberline {
namespace {

// The fractions of the time at which the plan, its first and its second correction end. The last
// one ends late, because the frame is stopped in time, while it could not go on if it ended early.
constexpr double kStages[] = {0.6, 0.93, 1.1};

// How much a resumed frame grows to measure the pace.
constexpr double kProbe = 1.25;

// The fractions of the tiles' costs after which the counts are corrected.
constexpr double kTileCorrections[] = {0.2, 0.8};

// A correction changes the count by at most this factor, as the predictions for single tiles may be
// wrong.
constexpr double kMaxCorrection = 4;

// The least work of a tile. It avoids divisions by 0.
constexpr double kMinWork = 1e-9;

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

TileBudget::TileBudget(double seconds, BudgetClock clock, std::vector<double> costs,
                       double seconds_per_work, uint32_t least)
    : seconds_(seconds),
      clock_(std::move(clock)),
      began_s_(clock_()),
      costs_(std::move(costs)),
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

// The pace is that of the work so far. Tiles in progress are half done on average, so enough tiles
// must be finished already. Returns whether there was a correction.
bool TileBudget::correct() {
  double in_progress = 0;
  for (const Tile& tile : begun_) in_progress += 0.5 * tile.work;
  const double now_s = clock_(), done = finished_ + in_progress;
  if (finished_ < 4 * in_progress || !(done > 0 && left_ > 0 && now_s > began_s_)) return false;
  const double wanted = ((seconds_ - now_s) * done / (now_s - began_s_) - in_progress) / left_;
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
  // Rounds up and down in turn, so that the mean is right.
  const double count = std::clamp(std::round(samples_ + rounding_), least_, double(kMaxSamples));
  rounding_ += samples_ - count;
  left_ -= costs_[tile];
  begun_.push_back({tile, count * costs_[tile]});
  return uint32_t(count);
}

void TileBudget::end(size_t tile) {
  const std::lock_guard lock(mutex_);
  const auto at = std::ranges::find(begun_, tile, &Tile::index);
  finished_ += at->work;
  begun_.erase(at);
}

}  // namespace emberline
