#include "renderer/drivers/uniform_driver.h"

#include <cassert>
#include <utility>

#include "renderer/core/archive.h"
#include "renderer/drivers/frame.h"
#include "renderer/drivers/sample_plan.h"
#include "renderer/film/film.h"

namespace emberline {
namespace {

class FixedCountDriver final : public FrameDriver {
 public:
  // Without a plan, every pixel gets Frame::samples_per_pixel samples.
  FixedCountDriver(const Frame& frame, const Rect& pixels, std::shared_ptr<const SamplePlan> plan)
      : pixels_(pixels),
        seed_(frame.seed),
        samples_per_pixel_(frame.samples_per_pixel),
        complete_stop_(frame.complete_stop()),
        plan_(std::move(plan)) {}

  std::optional<Round> next(FilmTile&, const std::stop_token&) override {
    if (begun_) return std::nullopt;
    begun_ = true;
    return round();
  }

  Round round() const override { return {begun_ ? size_t(pixels_.height()) : 0, seed_, 1, true}; }

  void expand(size_t part, std::vector<PixelWork>& list) const override {
    for (int x = pixels_.x0; x < pixels_.x1; ++x) {
      const int y = pixels_.y0 + int(part);
      list.push_back({x, y, 0, count(x, y)});
    }
  }

  uint64_t samples(size_t part) const override {
    uint64_t samples = 0;
    for (int x = pixels_.x0; x < pixels_.x1; ++x) samples += count(x, pixels_.y0 + int(part));
    return samples;
  }

  void rendered(const RenderedParts& parts, const FilmTile&) override {
    if (parts.complete) rows_ = int(parts.end);
  }

  bool finished() const override { return rows_ == pixels_.height(); }

  uint32_t min_samples(const FilmTile& film) const override {
    return finished() && !plan_ ? samples_per_pixel_ : film.min_samples();
  }

  PixelStop current_stop(const FilmTile& film, int x, int y) const override {
    return film.sample_count(x, y) < count(x, y) ? PixelStop::kUnfinished : complete_stop_;
  }

  void end(FilmTile& film, PixelStop unfinished_stop) override {
    if (!plan_) return film.mark_stops(samples_per_pixel_, complete_stop_, unfinished_stop);
    for (int y = pixels_.y0; y < pixels_.y1; ++y) {
      for (int x = pixels_.x0; x < pixels_.x1; ++x) {
        const uint32_t samples = film.sample_count(x, y);
        film.set_stop(x, y,
                      samples == 0             ? PixelStop::kNone
                      : samples == count(x, y) ? complete_stop_
                                               : unfinished_stop);
      }
    }
  }

  void archive(Archive& archive, const FilmTile&) override {
    archive.number(begun_, false, true);
    archive.number(rows_, 0, pixels_.height());
  }

 private:
  uint32_t count(int x, int y) const { return plan_ ? plan_->count(x, y) : samples_per_pixel_; }

  const Rect pixels_;
  const uint32_t seed_, samples_per_pixel_;
  const PixelStop complete_stop_;
  const std::shared_ptr<const SamplePlan> plan_;
  bool begun_ = false;
  int rows_ = 0;  // number of complete rows
};

}  // namespace

std::unique_ptr<FrameDriver> uniform_driver(const Frame& frame, const Rect& pixels) {
  return std::make_unique<FixedCountDriver>(frame, pixels, nullptr);
}

std::unique_ptr<FrameDriver> planned_driver(const Frame& frame, const Rect& pixels,
                                            const DriverSettings& settings) {
  assert(settings.plan);
  return std::make_unique<FixedCountDriver>(frame, pixels, settings.plan);
}

}  // namespace emberline
