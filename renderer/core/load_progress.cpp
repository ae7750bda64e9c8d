#include "renderer/core/load_progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "renderer/core/errors.h"
#include "renderer/core/readable.h"

namespace emberline {
namespace {

struct StageInfo {
  const char* name;
  bool counted;  // whether the text shows the number of items
  double end;    // fraction of the load that is complete when the stage ends
};

// We chose the fractions so that a progress bar moves evenly for most files, in which images take
// most of the time.
constexpr StageInfo kStages[] = {
    {"reading", false, 0.1},     {"meshes", true, 0.25}, {"images", true, 0.6},
    {"environment", false, 0.7}, {"BVH", false, 0.9},    {"lights", false, 1.0},
};

// Smaller changes of the fraction are reported only when a stage begins or the load is complete.
constexpr double kMinStep = 1.0 / 256.0;

const StageInfo& info(LoadStage stage) { return kStages[size_t(stage)]; }

double start_of(LoadStage stage) {
  return stage == LoadStage::kReading ? 0.0 : kStages[size_t(stage) - 1].end;
}

// Timeouts of 1e9 s or more are ignored, since they might exceed the range of the clock.
std::optional<std::chrono::steady_clock::time_point> deadline(std::optional<double> timeout_s) {
  using Clock = std::chrono::steady_clock;
  if (!timeout_s || !(*timeout_s < 1e9)) return std::nullopt;
  return Clock::now() +
         std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(*timeout_s));
}

}  // namespace

LoadProgress::LoadProgress(Report report, std::stop_token stop, LoadLimits limits)
    : watched_(report || stop.stop_possible() || limits.timeout_s),
      report_(std::move(report)),
      stop_(std::move(stop)),
      limits_(std::move(limits)),
      deadline_(deadline(limits_.timeout_s)) {}

LoadProgress& LoadProgress::none() {
  static LoadProgress instance{Report()};
  return instance;
}

void LoadProgress::throw_stop_reason() const {
  if (stop_.stop_requested()) throw Cancelled();
  throw LimitError(limits_.scene, "loading took longer than " +
                                      readable_seconds(*limits_.timeout_s) +
                                      "; raise `load-timeout`");
}

void LoadProgress::begin(LoadStage stage, uint64_t items) {
  if (!watched_) return;
  check();
  const std::lock_guard lock(mutex_);
  stage_ = stage;
  items_ = items;
  done_ = 0;
  report_stage_fraction(0.0);
}

void LoadProgress::advance(uint64_t items) {
  if (!watched_) return;
  {
    const std::lock_guard lock(mutex_);
    done_ += items;
    report_stage_fraction(items_ > 0 ? double(done_) / double(items_) : 0.0);
  }
  check();
}

void LoadProgress::report_partial(uint64_t items, double share) noexcept {
  if (!watched_) return;
  const std::lock_guard lock(mutex_);
  if (items_ > 0) report_stage_fraction((double(done_) + double(items) * share) / double(items_));
}

void LoadProgress::finish() {
  if (!watched_) return;
  const std::lock_guard lock(mutex_);
  stage_ = LoadStage::kLights;
  items_ = 0;
  report_stage_fraction(1.0);
}

void LoadProgress::report_stage_fraction(double share) {
  if (!report_) return;
  const StageInfo& stage = info(stage_);
  const double start = start_of(stage_);
  const double fraction =
      std::max(fraction_, start + (stage.end - start) * std::clamp(share, 0.0, 1.0));
  const bool is_complete = fraction == 1.0 && fraction_ < 1.0;
  if (stage_ == reported_ && !is_complete && fraction < fraction_ + kMinStep) return;
  reported_ = stage_;
  fraction_ = fraction;
  std::string text = stage.name;
  if (stage.counted && items_ > 0) {
    text += fmt::format(" {} of {}", std::min(done_ + 1, items_), items_);
  }
  report_(text, fraction);
}

}  // namespace emberline
