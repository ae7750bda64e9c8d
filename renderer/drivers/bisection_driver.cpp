#include "renderer/drivers/bisection_driver.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <vector>

#include "renderer/core/archive.h"
#include "renderer/drivers/bisection_picture.h"
#include "renderer/drivers/frame.h"
#include "renderer/film/film.h"
#include "renderer/film/light_mix.h"

namespace emberline {
namespace {

// Samples in a part of the later passes: about a millisecond of work on neighbouring pixels. Larger
// parts would use the caches only a little better (tests/bench/results).
constexpr uint64_t kPartSamples = 4096;

constexpr uint64_t kFirstPassRounds = 100;

// A round of the first pass is divided into kFirstPassParts parts, which is enough for many
// threads. If a part would then have fewer than two batches of samples, the round has fewer parts,
// but at least kMinFirstPassParts.
constexpr uint64_t kFirstPassParts = 64, kMinFirstPassParts = 16;
constexpr uint64_t kTwoBatches = 32;

PartShape shape_of(const SampleRange& samples, BisectionAxis axis) {
  if (samples.first_sample > 0 || axis == BisectionAxis::kBoth) return PartShape::kSquare;
  return axis == BisectionAxis::kRows ? PartShape::kRow : PartShape::kColumn;
}

// Returns the steps of a pass. They are lines of pixels in the first pass, and lines of cells in
// later passes.
std::vector<BisectionStep> steps_of(const Rect& crop, const SampleRange& samples,
                                    BisectionAxis axis) {
  const uint64_t cell_pixels =
      samples.first_sample > 0 ? bisection_part_pixels(samples, uint64_t(crop.area())) : 1;
  return bisection_steps(crop.width(), crop.height(), axis, square_cell(cell_pixels));
}

// Returns the coverage of the first pass once `parts` have been rendered. The parts must lie in one
// step.
BisectionCoverage coverage(const BisectionPass& pass, const RenderedParts& parts, size_t begin) {
  const size_t step = pass.step_of(begin), first = pass.first_part(step);
  if (parts.complete && parts.end == pass.first_part(step + 1)) return {step + 1, 0, 0};
  return {step, (parts.complete ? parts.end : parts.begin) - first, parts.end - first};
}

}  // namespace

uint64_t bisection_part_pixels(const SampleRange& samples, uint64_t frame_pixels) {
  const uint64_t pixels =
      std::bit_floor(std::max<uint64_t>(1, kPartSamples / samples.sample_count));
  if (samples.first_sample > 0) return pixels;
  const uint64_t round = frame_pixels / kFirstPassRounds;
  const uint64_t max_pixels =
      std::max(round / kFirstPassParts, std::min(kTwoBatches, round / kMinFirstPassParts));
  return std::min(pixels, std::bit_floor(std::max<uint64_t>(1, max_pixels)));
}

size_t bisection_round_end(const BisectionPass& pass, size_t first, uint64_t frame_pixels) {
  if (pass.samples().first_sample > 0) return pass.parts();
  const uint64_t max_pixels = frame_pixels / kFirstPassRounds;
  const size_t last = pass.first_part(pass.step_of(first) + 1);
  uint64_t pixels = pass.pixels(first);
  size_t end = first + 1;
  while (end < last && pixels + pass.pixels(end) <= max_pixels) pixels += pass.pixels(end++);
  return end;
}

namespace {

class BisectionDriver final : public FrameDriver {
 public:
  BisectionDriver(const Frame& frame, const Rect& crop, const DriverSettings& settings)
      : crop_(crop),
        seed_(frame.seed),
        is_open_(frame.time_budget_s > 0),
        complete_stop_(frame.complete_stop()),
        samples_per_pixel_(frame.samples_per_pixel),
        axis_(settings.bisection_axis),
        reconstruction_(settings.reconstruction),
        passes_(bisection_passes(samples_per_pixel_)),
        first_(crop, passes_.front(), axis_) {}

  std::optional<Round> next(FilmTile&, const std::stop_token&) override {
    begin_ = end_;
    if (begin_ == pass().parts.parts()) {
      if (pass_ + 1 == passes_.size()) return std::nullopt;
      later_pass_.emplace(crop_, passes_[++pass_], axis_);
      begin_ = 0;
    }
    const BisectionPass& parts = pass().parts;
    end_ = bisection_round_end(parts, begin_, uint64_t(crop_.area()));
    return round();
  }

  Round round() const override {
    return {end_ - begin_, seed_, int(pass_) + 1, end_ == pass().parts.parts()};
  }

  void expand(size_t part, std::vector<PixelWork>& list) const override {
    pass().parts.expand(begin_ + part, list);
  }

  uint64_t samples(size_t part) const override {
    return pass().parts.pixels(begin_ + part) * passes_[pass_].sample_count;
  }

  // After a stop request, parts that were not started have none of the pass's samples. A part that
  // was started lacks samples only if it was interrupted.
  void rendered(const RenderedParts& parts, const FilmTile& film) override {
    const BisectionPass& all = pass().parts;
    const RenderedParts pass_parts{begin_ + parts.begin, begin_ + parts.end, parts.complete, {}};
    if (pass_ == 0 && initial_samples_ == 0) coverage_ = coverage(all, pass_parts, begin_);
    if (pass_parts.end < all.parts()) return;
    uint32_t minimum = passes_[pass_].first_sample + passes_[pass_].sample_count;
    std::vector<PixelWork> list;
    for (const size_t part : parts.interrupted) expand(part, list);
    for (const PixelWork& work : list)
      minimum = std::min(minimum, film.sample_count(work.x, work.y));
    min_samples_ = minimum;
  }

  bool finished() const override { return min_samples_ == samples_per_pixel_; }
  void extend_work(double factor) override {
    // Rounds up: the time budget stops a frame with too many samples, but a frame with too few
    // would end too early.
    const double samples =
        std::min(std::ceil(factor * double(samples_per_pixel_)), double(kMaxSamples));
    const auto more = std::max(samples_per_pixel_, uint32_t(samples));
    add_bisection_passes(samples_per_pixel_, more, passes_);
    samples_per_pixel_ = more;
  }
  uint32_t min_samples(const FilmTile&) const override {
    return std::max(min_samples_, initial_samples_);
  }

  PixelStop current_stop(const FilmTile& film, int x, int y) const override {
    return film.sample_count(x, y) < samples_per_pixel_ ? PixelStop::kUnfinished : complete_stop_;
  }

  void resolve(const FilmTile& film, std::span<float> rgba, const LightMix* mix) const override {
    BisectionPicture{first_.steps, first_.parts, film, reconstruction_, coverage_}.resolve(rgba,
                                                                                           mix);
  }

  void end(FilmTile& film, PixelStop interrupted) override {
    film.mark_stops(samples_per_pixel_, complete_stop_, interrupted);
  }

  DriverFacts facts() const override {
    const size_t steps = coverage_.complete_steps;
    return {.lattice = steps > 0 ? &first_.steps[steps - 1].complete : nullptr};
  }

  void archive(Archive& archive, const FilmTile&) override {
    if (is_open_) archive_passes(archive);
    archive.number(pass_, size_t(0), passes_.size() - 1);
    if (archive.loading() && pass_ > 0) later_pass_.emplace(crop_, passes_[pass_], axis_);
    archive.number(end_, size_t(0), pass().parts.parts());
    archive.number(begin_, size_t(0), end_);
    BisectionCoverage& c = coverage_;
    archive.number(c.complete_steps, size_t(0), first_.steps.size());
    const size_t parts = c.complete_steps == first_.steps.size()
                             ? 0
                             : first_.parts.first_part(c.complete_steps + 1) -
                                   first_.parts.first_part(c.complete_steps);
    archive.number(c.begun_parts, size_t(0), parts);
    archive.number(c.complete_parts, size_t(0), c.begun_parts);
    archive.number(min_samples_, 0u, samples_per_pixel_);
    archive.number(initial_samples_, 0u, samples_per_pixel_);
  }

  void extend(Archive&, const FilmTile& film) override {
    initial_samples_ = std::min(film.min_samples(), samples_per_pixel_);
    if (initial_samples_ > 0) coverage_ = {first_.steps.size(), 0, 0};
  }

 private:
  // One pass and its steps.
  struct Pass {
    Pass(const Rect& crop, const SampleRange& samples, BisectionAxis axis)
        : steps(steps_of(crop, samples, axis)),
          parts(steps, crop, samples, shape_of(samples, axis),
                bisection_part_pixels(samples, uint64_t(crop.area()))) {}
    std::vector<BisectionStep> steps;
    BisectionPass parts;
  };
  const Pass& pass() const { return later_pass_ ? *later_pass_ : first_; }

  // With a time budget, the passes depend on the clock, so they are saved too.
  void archive_passes(Archive& archive) {
    constexpr size_t kMaxPasses = 256;
    archive.list(passes_, kMaxPasses);
    archive.number(samples_per_pixel_, 1u, kMaxSamples);
    uint32_t done = 0;
    for (const SampleRange& pass : passes_) {
      archive.check(pass.first_sample == done && pass.sample_count > 0 &&
                    pass.sample_count <= samples_per_pixel_ - done);
      done += pass.sample_count;
    }
    archive.check(done == samples_per_pixel_ && passes_.front() == bisection_passes(1).front());
  }

  const Rect crop_;
  const uint32_t seed_;
  const bool is_open_;  // the frame has a time budget
  const PixelStop complete_stop_;
  uint32_t samples_per_pixel_;
  const BisectionAxis axis_;
  const Reconstruction reconstruction_;
  std::vector<SampleRange> passes_;
  const Pass first_;
  std::optional<Pass> later_pass_;
  size_t pass_ = 0;               // index of the current pass
  size_t begin_ = 0, end_ = 0;    // the current round's parts, as a range in the pass
  BisectionCoverage coverage_;    // coverage of the first pass
  uint32_t min_samples_ = 0;      // number of samples that the passes have given every pixel
  uint32_t initial_samples_ = 0;  // samples per pixel of the finished frame that is extended
};

}  // namespace

std::unique_ptr<FrameDriver> bisection_driver(const Frame& frame, const Rect& crop,
                                              const DriverSettings& settings) {
  return std::make_unique<BisectionDriver>(frame, crop, settings);
}

}  // namespace emberline
