#include "renderer/drivers/adaptive_driver.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/core/archive.h"
#include "renderer/core/parallel.h"
#include "renderer/drivers/adaptive/pixel_explanation.h"
#include "renderer/drivers/adaptive/refinement_tree.h"
#include "renderer/drivers/adaptive/round_averages.h"
#include "renderer/drivers/adaptive/round_parts.h"
#include "renderer/drivers/adaptive/round_planner.h"
#include "renderer/drivers/adaptive/smooth_reconstruction.h"
#include "renderer/drivers/frame.h"
#include "renderer/film/film.h"
#include "renderer/film/light_mix.h"

namespace emberline {
namespace {

// Number of samples in a part: about a millisecond of work. A picture request may have to wait that
// long.
constexpr uint64_t kPartSamples = 4096;

// Samples per pixel after Stage::kPilotStep.
constexpr uint32_t kStepSamples = 4;

// One pixel in kPixelsPerTreePixel gets its first sample in the order of the tree; the other pixels
// follow in tiles. By then the tree has found the picture's features. Choosing another pixel with
// the tree would take as long as rendering a sample of a simple scene.
constexpr size_t kPixelsPerTreePixel = 16;
constexpr size_t kTreePartPixels = 256;

uint32_t min_count(std::span<const uint32_t> counts) {
  return counts.empty() ? 0 : *std::ranges::min_element(counts);
}

class AdaptiveDriver final : public FrameDriver {
 public:
  // If `is_progressive`, the picture is shown before the frame is finished. All pixels then get a
  // first sample before any pixel gets a second, so the picture is complete early.
  AdaptiveDriver(const Frame& frame, const Rect& crop, const DriverSettings& settings,
                 bool is_progressive)
      : crop_(crop),
        settings_(settings),
        is_progressive_(is_progressive),
        smooth_(settings.reconstruction == Reconstruction::kLinear),
        planner_(settings.adaptive, crop.width(), crop.height(), frame.seed,
                 frame.with_light_groups({}).light_groups),
        order_(tile_order(crop)),
        sample_counts_(order_.size(), 0),
        stage_(is_progressive_ ? Stage::kTree : Stage::kPilotStep) {
    if (settings.adaptive.unbiased) planner_.set_averages(&averages_);
    if (settings.is_extension) planner_.skip_pilot();
    if (settings.explained && crop.contains(settings.explained->x, settings.explained->y)) {
      planner_.record(index(settings.explained->x, settings.explained->y));
    }
    if (!is_progressive_) return;
    RefinementSettings refinement;
    refinement.seed = frame.seed;
    tree_.emplace(crop, refinement);
  }

  std::optional<Round> next(FilmTile& film, const std::stop_token& stop) override {
    if (stage_ == Stage::kTree) {
      if (const std::optional<Round> round = next_tree_round()) return round;
      stage_ = Stage::kFirst;
      return make_uniform_round(1, true);
    }
    if (stage_ == Stage::kFirst) {
      if (!settings_.keep_tree && !settings_.explained) tree_.reset();
      stage_ = Stage::kPilotStep;
      ++pass_;
      const std::span<const uint32_t> pilot = planner_.targets();  // equal for all pixels
      if (!pilot.empty() && pilot[0] >= 2 * kStepSamples)
        return make_uniform_round(kStepSamples, false);
    }
    if (stage_ == Stage::kPilotStep) {
      stage_ = Stage::kPilot;
      uniform_targets_ = {};
      return make_round(planner_.targets(), true);
    }
    stage_ = Stage::kRounds;
    if (settings_.adaptive.unbiased && !is_round_averaged_) {
      averages_.add_round(film, planner_.round_weight());
    }
    is_round_averaged_ = false;
    const bool more = planner_.plan(film, stop);
    if (planner_.interrupted()) return std::nullopt;
    planner_.write_variances(&film);
    if (!more) {
      stage_ = Stage::kFinished;
      return std::nullopt;
    }
    ++pass_;
    return make_round(planner_.targets(), true);
  }

  Round round() const override {
    const size_t parts = stage_ == Stage::kTree
                             ? (tree_pixels_.size() + kTreePartPixels - 1) / kTreePartPixels
                             : std::max<size_t>(1, parts_.size()) - 1;
    return {parts, planner_.round_seed(), pass_, ends_pass_};
  }

  void expand(size_t part, std::vector<PixelWork>& list) const override {
    if (stage_ == Stage::kTree) {
      const size_t end = std::min(tree_pixels_.size(), (part + 1) * kTreePartPixels);
      for (size_t k = part * kTreePartPixels; k < end; ++k) {
        list.push_back({tree_pixels_[k].x, tree_pixels_[k].y, 0, 1});
      }
      return;
    }
    for (size_t k = parts_[part_in_order(part)]; k < parts_[part_in_order(part) + 1]; ++k) {
      const size_t i = order_[k];
      if (targets_[i] > sample_counts_[i]) {
        list.push_back({x_of(i), y_of(i), sample_counts_[i], targets_[i] - sample_counts_[i]});
      }
    }
  }

  uint64_t samples(size_t part) const override {
    if (stage_ == Stage::kTree) {
      return std::min(tree_pixels_.size(), (part + 1) * kTreePartPixels) - part * kTreePartPixels;
    }
    uint64_t samples = 0;
    for (size_t k = parts_[part_in_order(part)]; k < parts_[part_in_order(part) + 1]; ++k) {
      samples += targets_[order_[k]] - sample_counts_[order_[k]];
    }
    return samples;
  }

  void rendered(const RenderedParts& parts, const FilmTile& film) override {
    if (stage_ != Stage::kTree) {
      parallel_each(parts.end - parts.begin, [&](size_t part) {
        const size_t t = part_in_order(parts.begin + part);
        for (size_t k = parts_[t]; k < parts_[t + 1]; ++k) {
          const size_t i = order_[k];
          sample_counts_[i] = parts.complete ? targets_[i] : film.sample_count(x_of(i), y_of(i));
        }
      });
      return;
    }
    const size_t end = std::min(tree_pixels_.size(), parts.end * kTreePartPixels);
    for (size_t k = parts.begin * kTreePartPixels; k < end; ++k) {
      sample_counts_[index(tree_pixels_[k].x, tree_pixels_[k].y)] =
          film.sample_count(tree_pixels_[k].x, tree_pixels_[k].y);
    }
    if (!parts.complete || end < tree_pixels_.size()) return;
    std::vector<Rgb> values;
    values.reserve(tree_pixels_.size());
    for (const Vec2i& pixel : tree_pixels_) values.push_back(film.mean(pixel.x, pixel.y));
    tree_->insert(values);
    tree_pixels_ = {};
  }

  bool finished() const override { return stage_ == Stage::kFinished; }

  void extend_work(double factor) override {
    planner_.extend_work(factor);
    stage_ = Stage::kRounds;
  }

  uint32_t min_samples(const FilmTile&) const override { return min_count(sample_counts_); }

  std::optional<double> error_estimate() const override {
    const double estimate = planner_.error_estimate();
    return estimate >= 0 ? std::optional(estimate) : std::nullopt;
  }

  std::optional<WorkForecast> forecast() const override {
    // The sample budget of a frame with a time budget (is_open) grows until the time is over.
    const bool is_known = !settings_.adaptive.unbiased && !settings_.adaptive.is_open;
    return stage_ == Stage::kRounds && is_known ? planner_.forecast() : std::nullopt;
  }

  PixelStop current_stop(const FilmTile&, int x, int y) const override {
    const size_t i = index(x, y);
    if (finished() || end_stop_) return stop_of(i, end_stop_.value_or(PixelStop::kUser));
    return planner_.current_stop(i, sample_counts_[i]);
  }

  // The averages over rounds include neither light groups nor the shadows in alpha. So with a light
  // mix, an unbiased frame is shown as the mean of all samples.
  void resolve(const FilmTile& film, std::span<float> rgba, const LightMix* mix) const override {
    FrameDriver::resolve(film, rgba, mix);
    if (!mix && !averages_.empty()) {
      parallel_each(sample_counts_.size(), [&](size_t i) {
        const float alpha = rgba[4 * i + 3];
        averages_.resolve(i, &rgba[4 * i]);
        if (film.has(Sums::kShadow)) rgba[4 * i + 3] = alpha;
      });
    }
    if (!is_covered() && tree_->sample_count() > 0) fill_from_tree(film, rgba);
  }

  bool overrides_means() const override { return !averages_.empty(); }

  void end(FilmTile& film, PixelStop unfinished_stop) override {
    end_stop_ = unfinished_stop;
    if (!finished() &&
        min_count(sample_counts_) > 0) {  // in a finished frame, plan() has updated the planner
      planner_.update(film);
      planner_.write_variances(&film);
    }
    parallel_each(sample_counts_.size(), [&](size_t i) {
      film.set_stop(x_of(i), y_of(i), stop_of(i, unfinished_stop),
                    planner_.judged().last_unfinished(i));
    });
  }

  void archive(Archive& archive, const FilmTile& film) override {
    archive.number(stage_, is_progressive_ ? Stage::kTree : Stage::kPilotStep, Stage::kFinished);
    archive.number(pass_, 1, std::numeric_limits<int>::max() / 2);
    archive.number(ends_pass_, false, true);
    archive.number(recorded_since_, 0, std::numeric_limits<int>::max());
    planner_.archive(archive);
    averages_.archive(archive, film);
    archive_tree(archive);
    for (size_t i = 0; archive.loading() && i < sample_counts_.size(); ++i) {
      sample_counts_[i] = film.sample_count(x_of(i), y_of(i));
    }
    uint32_t uniform_target = uniform_targets_.empty() ? 0 : uniform_targets_[0];
    archive.number(uniform_target, 0u, kStepSamples);
    archive.list(parts_, order_.size() + 1);
    archive.list(part_order_, order_.size());
    if (!archive.loading()) return;
    if (uniform_target > 0) uniform_targets_.assign(order_.size(), uniform_target);
    targets_ =
        uniform_target > 0 ? std::span<const uint32_t>(uniform_targets_) : planner_.targets();
    if (parts_.empty()) return archive.check(part_order_.empty());
    for (size_t i = 0; i < sample_counts_.size(); ++i)
      archive.check(sample_counts_[i] <= targets_[i]);
    archive.check(parts_.front() == 0 && parts_.back() == order_.size());
    archive.check(std::ranges::is_sorted(parts_, std::ranges::less_equal()));
    archive.check(part_order_.size() == (is_progressive_ ? parts_.size() - 1 : 0));
    std::vector<bool> is_used(part_order_.size());
    for (const uint32_t part_in_order : part_order_) {
      archive.check(part_in_order < is_used.size() && !is_used[part_in_order]);
      is_used[part_in_order] = true;
    }
  }

  void extend(Archive& finished, const FilmTile& film) override {
    archive(finished, film);
    finished.check(stage_ == Stage::kFinished);
    stage_ = Stage::kRounds;
    is_round_averaged_ = true;
  }

  uint64_t bytes() const override {
    return planner_.bytes() + averages_.bytes() +
           (tree_ ? tree_->node_bytes() + tree_->map_bytes() : 0) +
           (order_.capacity() + sample_counts_.capacity()) * sizeof(uint32_t) +
           gains_.capacity() * sizeof(float);
  }

  DriverFacts facts() const override { return {.tree = settings_.keep_tree ? &*tree_ : nullptr}; }

  std::string history() const override {
    const bool is_known = planner_.recorded() < sample_counts_.size() && has_errors();
    return is_known ? describe_history(history_of(planner_.recorded())) : "";
  }

  std::string explain(const FilmTile& film, int x, int y) const override {
    const size_t i = index(x, y);
    const Rgb mean = film.mean(x, y);
    std::string text = fmt::format("pixel {},{}: {} sample{}, {}\n", x, y, sample_counts_[i],
                                   sample_counts_[i] == 1 ? "" : "s", describe_status(i));
    const auto out = std::back_inserter(text);
    fmt::format_to(out, "mean {:.6g} {:.6g} {:.6g}\n", mean.x, mean.y, mean.z);
    if (has_errors()) {
      fmt::format_to(out, "error now {:.4g}{}\n", planner_.errors().error[i],
                     settings_.adaptive.threshold > 0
                         ? fmt::format(", threshold {:.4g}", settings_.adaptive.threshold)
                         : "");
    }
    const bool is_recorded = planner_.recorded() == i && has_errors();
    if (is_recorded) text += judged_errors(planner_.judged());
    const PixelHistory history = history_of(i);
    if (is_recorded) text += describe_history(history);
    if (tree_) text += tree_table(tree_->describe(x, y));
    if (is_recorded && !history.rounds.empty()) text += rounds_table(history);
    return text;
  }

  std::vector<uint32_t> planned_counts(const AdaptiveSettings& limits) const override {
    return planner_.planned_counts(limits);
  }

  void record_pixel(int x, int y) override {
    if (finished() || end_stop_ || planner_.recorded() == index(x, y)) return;
    planner_.record(index(x, y));
    recorded_since_ = planner_.round();
  }

 private:
  enum class Stage {
    kTree,       // first samples chosen by the refinement tree
    kFirst,      // first samples of all other pixels
    kPilotStep,  // a few samples for every pixel before a long pilot, so that the picture does not
                 // show pixels with all pilot samples next to pixels with one, which looks like
                 // dirt
    kPilot,
    kRounds,
    kFinished,
  };

  size_t index(int x, int y) const { return crop_.index_of(x, y); }
  int x_of(size_t i) const { return crop_.x_of(i); }
  int y_of(size_t i) const { return crop_.y_of(i); }
  // Returns whether every pixel has a sample.
  bool is_covered() const { return stage_ > Stage::kFirst; }

  std::optional<Round> next_tree_round() {
    const size_t pixels = sample_counts_.size(), count = tree_->sample_count(),
                 refined = tree_pixel_count();
    if (tree_->finished() || count >= refined) return std::nullopt;
    tree_pixels_ = tree_->next_round(refined - count);
    ends_pass_ = count + tree_pixels_.size() == pixels;
    return round();
  }

  // Returns how many pixels get their first sample from the tree.
  size_t tree_pixel_count() const {
    const bool whole = find_estimator(settings_.adaptive.estimator).whole_tree;
    return whole ? sample_counts_.size()
                 : (sample_counts_.size() + kPixelsPerTreePixel - 1) / kPixelsPerTreePixel;
  }

  // The tree is a function of its values, so only the values are saved. Loading rebuilds the tree,
  // and lets the tree request the pixels of the current round again.
  void archive_tree(Archive& archive) {
    std::vector<float> rgb;
    for (size_t leaf = 0; tree_ && leaf < tree_->sample_count(); ++leaf) {
      const Rgb& value = tree_->value(uint32_t(leaf));
      rgb.insert(rgb.end(), {value.x, value.y, value.z});
    }
    bool has_tree = tree_.has_value(), is_round_active = !tree_pixels_.empty();
    archive.number(has_tree, false, true);
    archive.list(rgb, tree_ ? 3 * tree_pixel_count() : 0);
    archive.number(is_round_active, false, true);
    if (!archive.loading()) return;
    archive.check(has_tree ? tree_.has_value() : is_covered() && !settings_.keep_tree);
    archive.check(!is_round_active || stage_ == Stage::kTree);
    if (!has_tree) return tree_.reset();
    std::vector<Rgb> values;
    for (size_t i = 0; i + 2 < rgb.size(); i += 3) {
      values.emplace_back(rgb[i], rgb[i + 1], rgb[i + 2]);
    }
    for (size_t have = 0; have < values.size(); have = tree_->sample_count()) {
      const size_t wanted = tree_->next_round(tree_pixel_count() - have).size();
      archive.check(wanted > 0 && wanted <= values.size() - have);
      tree_->insert(std::span(values).subspan(have, wanted));
    }
    if (is_round_active) tree_pixels_ = tree_->next_round(tree_pixel_count() - values.size());
  }

  // Starts a round after which each pixel has its sample count in `targets`.
  Round make_round(std::span<const uint32_t> targets, bool ends_pass) {
    targets_ = targets;
    parts_ = cut_into_parts(order_, sample_counts_, targets, kPartSamples);
    if (is_progressive_) {
      planner_.expected_gains(sample_counts_, targets, &gains_);
      part_order_ = parts_by_gain(parts_, order_, sample_counts_, targets, gains_);
    }
    ends_pass_ = ends_pass;
    return round();
  }

  Round make_uniform_round(uint32_t samples, bool ends_pass) {
    uniform_targets_.assign(order_.size(), samples);
    return make_round(uniform_targets_, ends_pass);
  }

  size_t part_in_order(size_t part) const { return is_progressive_ ? part_order_[part] : part; }

  // Returns why the pixel gets no more samples. If a stop request interrupted the planning of a
  // round, all pixels count as needing more samples.
  PixelStop stop_of(size_t i, PixelStop unfinished_stop) const {
    if (sample_counts_[i] == 0) return PixelStop::kNone;
    const bool wants_more =
        !is_covered() || planner_.interrupted() || sample_counts_[i] < planner_.targets()[i];
    return !finished() && wants_more ? unfinished_stop : planner_.stop_of(i);
  }

  bool has_errors() const { return !planner_.errors().error.empty(); }  // after the first update

  PixelHistory history_of(size_t i) const {
    PixelHistory history = {.rounds = planner_.records(),
                            .recorded_since = recorded_since_,
                            .threshold = settings_.adaptive.threshold,
                            .judged = &planner_.judged(),
                            .samples = sample_counts_[i]};
    if (has_errors()) history.error = planner_.errors().error[i];
    if (finished() || end_stop_) history.end = stop_of(i, end_stop_.value_or(PixelStop::kUser));
    return history;
  }

  std::string describe_status(size_t i) const {
    if (finished() || end_stop_) {
      return fmt::format("ended by {}",
                         pixel_stop_name(stop_of(i, end_stop_.value_or(PixelStop::kUser))));
    }
    if (!is_covered()) return "unfinished: every pixel gets its first sample";
    const uint32_t target = planner_.targets()[i];
    if (planner_.round() == 0)
      return fmt::format("unfinished: every pixel gets {} samples", target);
    const PixelStop stop = planner_.current_stop(i, sample_counts_[i]);
    if (stop != PixelStop::kUnfinished) {
      return fmt::format(
          "finished for now (ended by {}); it may still get extra samples that the whole frame "
          "gets",
          pixel_stop_name(stop));
    }
    return fmt::format("unfinished: it will have {} samples at the end of round {}", target,
                       planner_.round());
  }

  // Fills in the pixels without samples. Their values come from those pixels in `rgba` that the
  // tree has sampled. The film may also have samples of pixels that are not in the tree.
  void fill_from_tree(const FilmTile& film, std::span<float> rgba) const {
    const auto sampled_value = [&](uint32_t leaf) {
      const Vec2i pixel = tree_->sampled_pixel(leaf);
      return &rgba[4 * index(pixel.x, pixel.y)];
    };
    std::vector<Rgb> smooth;
    if (smooth_) {
      std::vector<Rgb> values;
      values.reserve(tree_->sample_count());
      for (uint32_t leaf = 0; leaf < tree_->sample_count(); ++leaf) {
        const float* value = sampled_value(leaf);
        values.emplace_back(value[0], value[1], value[2]);
      }
      smooth.resize(sample_counts_.size());
      reconstruct_smooth(*tree_, values, smooth);
    }
    constexpr size_t kGrain = 4096;
    parallel_ranges(sample_counts_.size(), kGrain, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        if (film.sums(i).samples() > 0) continue;
        std::copy_n(sampled_value(tree_->leaf_map()[i]), 4, &rgba[4 * i]);
        if (smooth_) std::copy_n(&smooth[i].x, 3, &rgba[4 * i]);
      }
    });
  }

  const Rect crop_;
  const DriverSettings settings_;
  const bool is_progressive_, smooth_;
  RoundPlanner planner_;
  RoundAverages averages_;
  std::optional<RefinementTree> tree_;  // until every pixel has a sample, or longer if kept
  std::vector<uint32_t> order_;
  std::vector<uint32_t> sample_counts_;  // samples of each pixel so far
  Stage stage_;
  int pass_ = 1;
  bool ends_pass_ = false;          // whether the current round ends the pass
  bool is_round_averaged_ = false;  // whether averages_ includes the last round
  // The current round. It has either the pixels that the tree requests, or the target count of each
  // pixel, the bounds of the parts in order_, and the order in which the parts are rendered.
  std::span<const Vec2i> tree_pixels_;
  std::span<const uint32_t> targets_;
  std::vector<uint32_t> uniform_targets_;  // equal targets for all pixels
  std::vector<size_t> parts_;
  std::vector<uint32_t> part_order_;
  std::vector<float> gains_;
  std::optional<PixelStop> end_stop_;  // set by end()
  int recorded_since_ = 0;  // round in which the recording of the pixel began; 0: from the start
};

}  // namespace

std::unique_ptr<FrameDriver> adaptive_driver(const Frame& frame, const Rect& crop,
                                             const DriverSettings& settings) {
  return std::make_unique<AdaptiveDriver>(frame, crop, settings, true);
}

std::unique_ptr<FrameDriver> adaptive_tile_driver(const Frame& frame, const Rect& tile,
                                                  const DriverSettings& settings) {
  return std::make_unique<AdaptiveDriver>(frame, tile, settings, false);
}

FilmExtras adaptive_film_extras(const DriverSettings& settings) {
  return {.squares = true,
          .rays = true,
          .sample_variance = RoundPlanner::has_variances(settings.adaptive)};
}

uint64_t adaptive_bytes_per_pixel(const DriverSettings& settings) {
  // Counts the planner's planes and halves, the driver's order, counts and gains, and the tree at
  // its largest, with two nodes for each sample. tests/cli/limits_test.cpp compares the result with
  // bytes().
  constexpr uint64_t kPlanner = 28 * sizeof(float), kOrder = 3 * sizeof(uint32_t);
  constexpr uint64_t kTree = 2 * 36 + sizeof(uint32_t);
  constexpr uint64_t kAverages = 10 * sizeof(double);
  const AdaptiveSettings& adaptive = settings.adaptive;
  const uint64_t judged = adaptive.judged.empty() ? 0
                                                  : judged_bytes_per_pixel(adaptive.judged, 0) +
                                                        JudgedChannels::kUpdateBytes;
  return kPlanner + kOrder + kTree + judged + (adaptive.unbiased ? kAverages : 0);
}

}  // namespace emberline
