#include "renderer/drivers/adaptive_driver.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <iterator>
#include <optional>

#include "renderer/core/parallel.h"
#include "renderer/drivers/adaptive/refinement_views.h"
#include "renderer/drivers/adaptive/round_averages.h"
#include "renderer/drivers/bisection_picture.h"
#include "renderer/drivers/bucket_driver.h"
#include "renderer/drivers/frame_film.h"
#include "samplers/owen_sobol.h"

namespace emberline {
namespace {

// About a millisecond of work: what a picture that is wanted waits for.
constexpr uint64_t kPartSamples = 4096;

// Samples of a pixel on the way to the pilot.
constexpr uint32_t kPilotStep = 4;

// The tree asks for the first of every so many pixels, and the others follow in tiles: by then it
// has found where the picture's features are, and asking costs as much as a sample of a simple
// scene.
constexpr size_t kTreePart = 16;
// But the estimator that is named after its authors has it go on to the end.
constexpr std::string_view kTreeEstimator = "painter-sloan";
constexpr size_t kTreePartPixels = 256;

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

std::vector<uint32_t> parts_by_gain(std::span<const size_t> parts, std::span<const uint32_t> order,
                                    std::span<const uint32_t> have,
                                    std::span<const uint32_t> targets,
                                    std::span<const float> gain) {
  const size_t count = parts.size() - 1;
  std::vector<double> rates(count);
  parallel_each(count, [&](size_t part) {
    double sum = 0;
    uint64_t samples = 0;
    for (size_t k = parts[part]; k < parts[part + 1]; ++k) {
      const size_t i = order[k];
      sum += double(gain[i]);
      samples += targets[i] - have[i];
    }
    rates[part] = samples > 0 ? sum / double(samples) : 0.0;
  });
  std::vector<uint32_t> sorted;
  sorted.reserve(count);
  const auto bits = uint32_t(std::bit_width(count));
  for (uint32_t i = 0; sorted.size() < count; ++i) {  // van der Corput's order
    const uint32_t part = bits > 0 ? owen_sobol::reverse_bits(i) >> (32 - bits) : 0;
    if (part < count) sorted.push_back(part);
  }
  std::ranges::stable_sort(sorted, std::ranges::greater(), [&](uint32_t p) { return rates[p]; });
  return sorted;
}

namespace {

FilmExtras film_extras(const AdaptiveSettings& settings) {
  return {
      .squares = true, .rays = true, .sample_variance = RoundPlanner::knows_variances(settings)};
}

}  // namespace

class AdaptiveDriver::Progress final : public FramePicture {
 public:
  Progress(const Frame& frame, const DriverSettings& settings, FrameObserver& observer,
           std::stop_token stop)
      : window_(frame.window),
        settings_(settings),
        smooth_(parse_reconstruction(settings.reconstruction) == Reconstruction::kLinear),
        observer_(observer),
        stop_(stop),
        film_(frame.aovs, frame.with_light_groups(film_extras(settings.adaptive))),
        runner_(frame, film_, observer, std::move(stop)),
        planner_(settings.adaptive, frame.window.width(), frame.window.height(), frame.seed),
        order_(tile_order(frame.window)),
        have_(order_.size(), 0) {
    reset_film(frame.window, &film_);
    if (settings.adaptive.unbiased) planner_.set_averages(&averages_);
    if (settings.explained) {
      planner_.record(index(settings.explained->x, settings.explained->y));
    }
    RefinementSettings refinement;
    refinement.seed = frame.seed;
    tree_.emplace(frame.window, refinement);
  }

  FrameCounters render() {
    bool complete = cover() && render_pilot();
    while (complete) {
      if (settings_.adaptive.unbiased) averages_.add_round(film_, planner_.round_weight());
      const bool more = planner_.plan(film_, stop_);
      complete = !planner_.interrupted();
      if (complete) planner_.tell_variances(&film_);
      if (!more) break;
      runner_.set_seed(planner_.round_seed());
      ++pass_;
      complete = bring_to(planner_.targets());
    }
    FrameCounters counters = runner_.counters();
    if (!have_.empty()) {
      const auto [least, most] = std::ranges::minmax_element(have_);
      counters.min_samples = *least;
      counters.max_samples = *most;
    }
    counters.stopped = stopped_ = !complete;
    ended_ = true;
    return counters;
  }

  // Fills in the stop channel and finds the error of what there is: both look at every pixel once
  // more, for which a user who stopped the frame would not wait.
  void finish() {
    if (covered_ && stopped_) {  // else plan() has
      planner_.look(film_);
      planner_.tell_variances(&film_);
    }
    for (size_t i = 0; i < have_.size(); ++i) film_.set_stop(x_of(i), y_of(i), stop_of(i));
  }

  // Mixed, an unbiased frame is the mean of all its samples: rounds are not kept by light group.
  void resolve(std::span<float> rgba, const LightMix* mix) const override {
    if (mix) {
      relight(film_, *mix, rgba);
    } else {
      const auto width = size_t(window_.width());
      parallel_each(size_t(window_.height()), [&](size_t row) {
        for (size_t i = row * width; i < (row + 1) * width; ++i) {
          film_.rgba(x_of(i), y_of(i), &rgba[4 * i]);
          if (!averages_.empty()) averages_.resolve(i, &rgba[4 * i]);
        }
      });
    }
    if (!covered_ && tree_->sample_count() > 0) fill_from_tree(rgba);
  }
  const FilmTile& film() const override { return film_; }
  PixelStop stop_so_far(int x, int y) const override {
    const size_t i = index(x, y);
    return ended_ ? stop_of(i) : planner_.stop_so_far(i, have_[i]);
  }
  // Another average than that of all samples.
  bool all_shown() const { return !averages_.empty(); }

  std::optional<double> error_estimate() const {
    const double estimate = planner_.error_estimate();
    return estimate >= 0 ? std::optional(estimate) : std::nullopt;
  }
  const RefinementTree& tree() const { return *tree_; }
  uint64_t bytes() const {
    return film_.bytes() + planner_.bytes() + averages_.bytes() +
           (tree_ ? tree_->node_bytes() + tree_->map_bytes() : 0) +
           (order_.capacity() + have_.capacity()) * sizeof(uint32_t);
  }
  std::string explain(int x, int y) const;
  void follow(int x, int y) {
    if (ended_ || planner_.recorded() == index(x, y)) return;
    planner_.record(index(x, y));
    followed_from_ = planner_.round();
  }

 private:
  size_t index(int x, int y) const { return window_.index_of(x, y); }
  int x_of(size_t i) const { return window_.x_of(i); }
  int y_of(size_t i) const { return window_.y_of(i); }

  // What becomes of the pixel, or has: the end of explain()'s first line.
  std::string fate_of(size_t i) const;

  PixelStop stop_of(size_t i) const {
    if (have_[i] == 0) return PixelStop::kNone;
    // Between two rounds it is as if all pixels were to get more.
    const bool cut_short = !covered_ || planner_.interrupted() || have_[i] < planner_.targets()[i];
    return stopped_ && cut_short ? observer_.stop_cause() : planner_.stop_of(i);
  }

  // Pixels without samples, from those that the tree has asked for, as `rgba` shows them. The film
  // knows the colour of some more pixels than the tree.
  void fill_from_tree(std::span<float> rgba) const {
    const auto sampled_for = [&](uint32_t leaf) {
      const Vec2i pixel = tree_->sampled_pixel(leaf);
      return &rgba[4 * index(pixel.x, pixel.y)];
    };
    std::vector<Rgb> smooth;
    if (smooth_) {
      std::vector<Rgb> values;
      values.reserve(tree_->sample_count());
      for (uint32_t leaf = 0; leaf < tree_->sample_count(); ++leaf) {
        const float* value = sampled_for(leaf);
        values.emplace_back(value[0], value[1], value[2]);
      }
      smooth.resize(have_.size());
      reconstruct_smooth_of(*tree_, values, smooth);
    }
    constexpr size_t kGrain = 4096;
    parallel_ranges(have_.size(), kGrain, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        if (film_.sums(i).samples() > 0) continue;
        std::copy_n(sampled_for(tree_->leaf_map()[i]), 4, &rgba[4 * i]);
        if (smooth_) std::copy_n(&smooth[i].x, 3, &rgba[4 * i]);
      }
    });
  }

  // Brings every pixel its first sample; first those that the tree asks for.
  bool cover() {
    ++pass_;
    const auto pixels = size_t(window_.area());
    const bool whole = settings_.adaptive.estimator == kTreeEstimator;
    const size_t refined = whole ? pixels : (pixels + kTreePart - 1) / kTreePart;
    std::vector<Rgb> values;
    while (!tree_->finished() && tree_->sample_count() < refined) {
      const std::span<const Vec2i> wanted = tree_->next_round(refined - tree_->sample_count());
      if (!render_first_samples(wanted)) return false;
      values.clear();
      for (const Vec2i& pixel : wanted) values.push_back(film_.mean(pixel.x, pixel.y));
      tree_->insert(values);
      report(double(tree_->sample_count()) / double(pixels), tree_->finished());
    }
    const std::vector<uint32_t> first(order_.size(), 1);
    if (!bring_to(first)) return false;
    covered_ = true;
    if (!settings_.keep_tree && !settings_.explained) tree_.reset();
    return true;
  }

  bool render_first_samples(std::span<const Vec2i> pixels) {
    const size_t parts = (pixels.size() + kTreePartPixels - 1) / kTreePartPixels;
    const bool complete = runner_.run(parts, [&](size_t part, std::vector<PixelWork>& list) {
      const size_t end = std::min(pixels.size(), (part + 1) * kTreePartPixels);
      for (size_t k = part * kTreePartPixels; k < end; ++k) {
        list.push_back({pixels[k].x, pixels[k].y, 0, 1});
      }
    });
    for (const Vec2i& p : pixels) have_[index(p.x, p.y)] = film_.sample_count(p.x, p.y);
    return complete;
  }

  // In two steps: else, for as long as the pilot takes, pixels with all of it would stand beside
  // pixels with one sample, which looks like dirt on the picture.
  bool render_pilot() {
    ++pass_;
    const std::span<const uint32_t> pilot = planner_.targets();
    if (!pilot.empty() && pilot[0] >= 2 * kPilotStep) {  // the same for all pixels
      const std::vector<uint32_t> step(pilot.size(), kPilotStep);
      if (!bring_to(step, false)) return false;
    }
    return bring_to(pilot);
  }

  // Renders until each pixel has as many samples as `targets` says. False if stopped before.
  bool bring_to(std::span<const uint32_t> targets, bool ends_pass = true) {
    const std::vector<size_t> parts = cut_into_parts(order_, have_, targets, kPartSamples);
    const size_t part_count = parts.size() - 1;
    planner_.expected_gains(have_, targets, &gains_);
    const std::vector<uint32_t> turns = parts_by_gain(parts, order_, have_, targets, gains_);
    for (size_t begin = 0, end; begin < part_count; begin = end) {
      size_t count = parts_until_wanted(parts, std::span(turns).subspan(begin), targets);
      const bool complete = runner_.run_until_wanted(count, [&](size_t part, auto& list) {
        const size_t turn = turns[begin + part];
        for (size_t k = parts[turn]; k < parts[turn + 1]; ++k) {
          const size_t i = order_[k];
          if (targets[i] > have_[i]) {
            list.push_back({x_of(i), y_of(i), have_[i], targets[i] - have_[i]});
          }
        }
      });
      end = begin + count;
      parallel_each(count, [&](size_t part) {
        const size_t turn = turns[begin + part];
        for (size_t k = parts[turn]; k < parts[turn + 1]; ++k)
          have_[order_[k]] = targets[order_[k]];
      });
      for (const size_t part : runner_.cut_short()) {
        const size_t turn = turns[begin + part];
        for (size_t k = parts[turn]; k < parts[turn + 1]; ++k) {
          have_[order_[k]] = film_.sample_count(x_of(order_[k]), y_of(order_[k]));
        }
      }
      if (!complete) return false;
      const auto samples = double(runner_.counters().samples);
      report(std::min(1.0, samples / double(order_.size())), ends_pass && end == part_count);
    }
    return true;
  }

  // How many of a round's parts, in the order of `turns`, come before the next pause: all, unless a
  // picture is wanted at some number of samples.
  size_t parts_until_wanted(std::span<const size_t> parts, std::span<const uint32_t> turns,
                            std::span<const uint32_t> targets) const {
    const std::optional<uint64_t> wanted = runner_.samples_until_wanted();
    if (!wanted) return turns.size();
    size_t end = 0;
    for (uint64_t samples = 0; end < turns.size() && samples < *wanted; ++end) {
      for (size_t k = parts[turns[end]]; k < parts[turns[end] + 1]; ++k) {
        samples += targets[order_[k]] - have_[order_[k]];
      }
    }
    return end;
  }

  void report(double completion, bool pass_finished) {
    FrameProgress progress;
    progress.pass = pass_;
    progress.samples = runner_.counters().samples;
    progress.rays = runner_.counters().rays.total();
    progress.completion = completion;
    progress.pass_finished = pass_finished;
    progress.error_estimate = error_estimate();
    observer_.picture_changed(progress, *this);
  }

  const Rect window_;
  const DriverSettings& settings_;
  const bool smooth_;
  FrameObserver& observer_;
  const std::stop_token stop_;
  FilmTile film_;
  SliceRunner runner_;
  RoundPlanner planner_;
  RoundAverages averages_;
  std::optional<RefinementTree> tree_;  // until every pixel has a sample, or kept
  const std::vector<uint32_t> order_;
  std::vector<uint32_t> have_;  // samples of each pixel
  std::vector<float> gains_;    // expected of this round's
  int pass_ = 0;
  bool covered_ = false;   // every pixel has a sample
  bool stopped_ = false;   // before the work was done
  bool ended_ = false;     // render() is over
  int followed_from_ = 0;  // the round in which the recorded pixel was asked for; 0: before all
};

std::string AdaptiveDriver::Progress::fate_of(size_t i) const {
  if (ended_) return fmt::format("ended by {}", pixel_stop_name(stop_of(i)));
  if (!covered_) return "so far: every pixel gets its first";
  const uint32_t target = planner_.targets()[i];
  if (planner_.round() == 0) return fmt::format("so far: every pixel gets {}", target);
  const PixelStop stop = planner_.stop_so_far(i, have_[i]);
  if (stop != PixelStop::kGoingOn) {
    return fmt::format("so far ended by {}; what goes everywhere may bring more",
                       pixel_stop_name(stop));
  }
  return fmt::format("so far: {} by the end of round {}", target, planner_.round());
}

std::string AdaptiveDriver::Progress::explain(int x, int y) const {
  const size_t i = index(x, y);
  const Rgb mean = film_.mean(x, y);
  std::string text = fmt::format("pixel {},{}: {} sample{}, {}\n", x, y, have_[i],
                                 have_[i] == 1 ? "" : "s", fate_of(i));
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "mean {:.6g} {:.6g} {:.6g}\n", mean.x, mean.y, mean.z);
  if (!planner_.errors().error.empty()) {  // there was a round to plan
    fmt::format_to(out, "error now {:.4g}{}\n", planner_.errors().error[i],
                   settings_.adaptive.threshold > 0
                       ? fmt::format(", threshold {:.4g}", settings_.adaptive.threshold)
                       : "");
  }
  if (tree_) {
    fmt::format_to(out,
                   "refinement tree, from the window down to the leaf with this pixel\n"
                   "  {:>24} {:>10} {:>10} {:>10} {:>6}  {}\n",
                   "rectangle", "v_int", "v_ext", "priority", "round", "phase");
    for (const RefinementStep& step : tree_->describe(x, y)) {
      const Rect& r = step.rect;
      fmt::format_to(out, "  {:>24} {:>10.3g} {:>10.3g} {:>10.3g} {:>6}  {}{}\n",
                     fmt::format("{},{} {}x{}", r.x0, r.y0, r.width(), r.height()), step.v_int,
                     step.v_ext, step.priority, step.round, refinement_phase_name(step.phase),
                     step.leaf ? ", leaf" : "");
    }
  }
  if (planner_.recorded() != i || planner_.records().empty()) return text;
  const bool late = followed_from_ > 0;
  fmt::format_to(out, "rounds{}\n  {:>5} {:>8} {:>10} {:>10} {:>6} {:>8}\n",
                 late ? fmt::format(" since it was asked for, in round {}", followed_from_) : "",
                 "round", "samples", "error", "deviation", "cost", "to have");
  for (const RoundRecord& r : planner_.records()) {
    fmt::format_to(out, "  {:>5} {:>8} {:>10.4g} {:>10.4g} {:>6.3g} {:>8}\n", r.round, r.samples,
                   r.error, r.deviation, r.cost, r.target);
  }
  return text;
}

AdaptiveDriver::AdaptiveDriver(const DriverSettings& settings) : settings_(settings) {
  find_estimator(settings.adaptive.estimator);
  parse_reconstruction(settings.reconstruction);
  checked_bucket_size(settings.bucket_size);
}

AdaptiveDriver::~AdaptiveDriver() = default;

FrameCounters AdaptiveDriver::render(const Frame& frame, FrameObserver& observer,
                                     std::stop_token stop) {
  progress_ = std::make_unique<Progress>(frame, settings_, observer, std::move(stop));
  return progress_->render();
}

void AdaptiveDriver::deliver(FrameObserver& observer) {
  progress_->finish();
  deliver_film(*progress_, settings_.bucket_size, observer, progress_->all_shown());
}

std::optional<double> AdaptiveDriver::error_estimate() const {
  return progress_ ? progress_->error_estimate() : std::nullopt;
}

std::string AdaptiveDriver::explain(int x, int y) const { return progress_->explain(x, y); }

void AdaptiveDriver::follow(int x, int y) { progress_->follow(x, y); }

const FramePicture* AdaptiveDriver::picture() const { return progress_.get(); }

const RefinementTree* AdaptiveDriver::tree() const {
  return settings_.keep_tree ? &progress_->tree() : nullptr;
}

uint64_t AdaptiveDriver::bytes_per_pixel(const AovSet& aovs) const {
  // What Progress::bytes() adds up: the planner's planes and halves, order and counts, and the tree
  // at its largest, with two nodes for each sample. tests/cli/limits_test.cpp compares the two.
  constexpr uint64_t kPlanner = 28 * sizeof(float), kOrder = 2 * sizeof(uint32_t);
  constexpr uint64_t kTree = 2 * 36 + sizeof(uint32_t);
  constexpr uint64_t kAverages = 10 * sizeof(double);
  return film_bytes_per_pixel(aovs, film_extras(settings_.adaptive)) + kPlanner + kOrder + kTree +
         (settings_.adaptive.unbiased ? kAverages : 0);
}

uint64_t AdaptiveDriver::film_bytes() const { return progress_ ? progress_->bytes() : 0; }

}  // namespace emberline
