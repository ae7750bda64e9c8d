#include "renderer/drivers/adaptive_driver.h"

#include <tbb/task_arena.h>

#include <algorithm>

#include "renderer/core/errors.h"
#include "renderer/drivers/frame_film.h"

namespace emberline {
namespace {

// About half a millisecond of work: many parts for each thread of a slice.
constexpr uint64_t kPartSamples = 2048;
// A slice ends in a barrier and a look by the observer: some milliseconds of work for each thread.
constexpr size_t kPartsPerThread = 32;

}  // namespace

std::vector<uint32_t> tile_order(const Rect& window) {
  constexpr int kTile = 16;
  std::vector<uint32_t> order;
  order.reserve(size_t(window.area()));
  const int width = window.width(), height = window.height();
  for (int tile_y = 0; tile_y < height; tile_y += kTile) {
    for (int tile_x = 0; tile_x < width; tile_x += kTile) {
      for (int y = tile_y; y < std::min(tile_y + kTile, height); ++y) {
        for (int x = tile_x; x < std::min(tile_x + kTile, width); ++x) {
          order.push_back(uint32_t(y) * uint32_t(width) + uint32_t(x));
        }
      }
    }
  }
  return order;
}

std::vector<size_t> cut_into_parts(std::span<const uint32_t> order, std::span<const uint32_t> have,
                                   std::span<const uint32_t> targets, uint64_t samples) {
  std::vector<size_t> parts = {0};
  uint64_t in_part = 0;
  for (size_t k = 0; k < order.size(); ++k) {
    if (in_part >= samples) {
      parts.push_back(k);
      in_part = 0;
    }
    in_part += targets[order[k]] - have[order[k]];
  }
  if (!order.empty()) parts.push_back(order.size());
  return parts;
}

class AdaptiveDriver::Progress final : public FramePicture {
 public:
  Progress(const Frame& frame, const AdaptiveSettings& settings, FrameObserver& observer,
           std::stop_token stop)
      : window_(frame.window),
        observer_(observer),
        film_(frame.aovs, {.squares = true, .rays = true}),
        runner_(frame, film_, observer, std::move(stop)),
        planner_(settings, frame.window.width(), frame.window.height(), frame.seed),
        order_(tile_order(frame.window)),
        have_(order_.size(), 0) {
    film_.reset(frame.window);
  }

  FrameCounters render() {
    const std::vector<uint32_t> first(order_.size(), 1);
    bool complete = bring_to(first);
    complete = complete && bring_to(planner_.targets());
    while (complete && planner_.plan(film_)) complete = bring_to(planner_.targets());
    FrameCounters counters = runner_.counters();
    if (!have_.empty()) {
      const auto [least, most] = std::ranges::minmax_element(have_);
      counters.min_samples = *least;
      counters.max_samples = *most;
    }
    counters.stopped = !complete;
    return counters;
  }

  // The stop channel is filled in here, and the error of what there is found: both look at every
  // pixel once more, for which a user who stopped the frame would not wait.
  void finish() {
    if (covered_) planner_.look(film_);
    const bool stopped = runner_.counters().stopped;
    for (size_t i = 0; i < have_.size(); ++i) {
      const bool cut_short = stopped && have_[i] < planner_.targets()[i];
      const PixelStop stop = have_[i] == 0 ? PixelStop::kNone
                             : cut_short   ? observer_.stop_cause()
                                           : planner_.stop_of(i);
      film_.set_stop(x_of(i), y_of(i), stop);
    }
  }

  void resolve(std::span<float> rgba) const override { film_.resolve_rgba(rgba); }
  const FilmTile& film() const override { return film_; }
  std::optional<double> error_estimate() const {
    const double estimate = planner_.error_estimate();
    return estimate >= 0 ? std::optional(estimate) : std::nullopt;
  }
  uint64_t bytes() const { return film_.bytes() + planner_.bytes() + order_.capacity() * 8; }

 private:
  int x_of(size_t i) const { return window_.x0 + int(i % size_t(window_.width())); }
  int y_of(size_t i) const { return window_.y0 + int(i / size_t(window_.width())); }

  // Renders until each pixel has as many samples as `targets` says. False if stopped before.
  bool bring_to(std::span<const uint32_t> targets) {
    ++pass_;
    const std::vector<size_t> parts = cut_into_parts(order_, have_, targets, kPartSamples);
    const size_t part_count = parts.size() - 1;
    const size_t slice = kPartsPerThread * size_t(tbb::this_task_arena::max_concurrency());
    for (size_t begin = 0; begin < part_count; begin += slice) {
      const size_t end = std::min(part_count, begin + slice);
      const bool complete = runner_.run(end - begin, [&](size_t part, auto& list) {
        for (size_t k = parts[begin + part]; k < parts[begin + part + 1]; ++k) {
          const size_t i = order_[k];
          if (targets[i] > have_[i]) {
            list.push_back({x_of(i), y_of(i), have_[i], targets[i] - have_[i]});
          }
        }
      });
      for (size_t k = parts[begin]; k < parts[end]; ++k) {
        const size_t i = order_[k];
        have_[i] = complete ? targets[i] : film_.sample_count(x_of(i), y_of(i));
      }
      if (!complete) return false;
      report(begin > 0 ? double(parts[end]) / double(order_.size()) : 0.0, end == part_count);
    }
    covered_ = true;
    return true;
  }

  void report(double part_of_pass, bool finished) {
    FrameProgress progress;
    progress.pass = pass_;
    progress.samples = runner_.counters().samples;
    progress.completion = covered_ ? 1.0 : part_of_pass;
    progress.pass_finished = finished;
    progress.error_estimate = error_estimate();
    observer_.picture_changed(progress, *this);
  }

  const Rect window_;
  FrameObserver& observer_;
  FilmTile film_;
  SliceRunner runner_;
  RoundPlanner planner_;
  const std::vector<uint32_t> order_;
  std::vector<uint32_t> have_;  // samples of each pixel
  int pass_ = 0;
  bool covered_ = false;  // every pixel has a sample
};

AdaptiveDriver::AdaptiveDriver(const DriverSettings& settings)
    : settings_(settings.adaptive), tile_size_(settings.bucket_size) {
  find_estimator(settings_.estimator);
}

AdaptiveDriver::~AdaptiveDriver() = default;

FrameCounters AdaptiveDriver::render(const Frame& frame, FrameObserver& observer,
                                     std::stop_token stop) {
  progress_ = std::make_unique<Progress>(frame, settings_, observer, std::move(stop));
  return progress_->render();
}

void AdaptiveDriver::deliver(FrameObserver& observer) {
  progress_->finish();
  deliver_film(*progress_, tile_size_, observer);
}

std::optional<double> AdaptiveDriver::error_estimate() const {
  return progress_ ? progress_->error_estimate() : std::nullopt;
}

uint64_t AdaptiveDriver::film_bytes() const { return progress_ ? progress_->bytes() : 0; }

}  // namespace emberline
