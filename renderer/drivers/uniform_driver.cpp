#include "renderer/drivers/uniform_driver.h"

#include "renderer/core/archive.h"
#include "renderer/film/film.h"

namespace emberline {
namespace {

class UniformDriver final : public FrameDriver {
 public:
  UniformDriver(const Frame& frame, const Rect& pixels)
      : pixels_(pixels), seed_(frame.seed), samples_per_pixel_(frame.samples_per_pixel) {}

  std::optional<Round> next(FilmTile&, const std::stop_token&) override {
    if (begun_) return std::nullopt;
    begun_ = true;
    return round();
  }

  Round round() const override { return {begun_ ? size_t(pixels_.height()) : 0, seed_, 1, true}; }

  void expand(size_t part, std::vector<PixelWork>& list) const override {
    for (int x = pixels_.x0; x < pixels_.x1; ++x) {
      list.push_back({x, pixels_.y0 + int(part), 0, samples_per_pixel_});
    }
  }

  uint64_t samples(size_t) const override { return uint64_t(pixels_.width()) * samples_per_pixel_; }

  void rendered(const RenderedParts& parts, const FilmTile&) override {
    if (parts.complete) rows_ = int(parts.end);
  }

  bool finished() const override { return rows_ == pixels_.height(); }

  uint32_t min_samples(const FilmTile& film) const override {
    return finished() ? samples_per_pixel_ : film.min_samples();
  }

  PixelStop current_stop(const FilmTile& film, int x, int y) const override {
    return film.sample_count(x, y) < samples_per_pixel_ ? PixelStop::kUnfinished
                                                        : PixelStop::kBudget;
  }

  void end(FilmTile& film, PixelStop unfinished_stop) override {
    film.mark_stops(samples_per_pixel_, unfinished_stop);
  }

  void archive(Archive& archive, const FilmTile&) override {
    archive.number(begun_, false, true);
    archive.number(rows_, 0, pixels_.height());
  }

 private:
  const Rect pixels_;
  const uint32_t seed_, samples_per_pixel_;
  bool begun_ = false;
  int rows_ = 0;  // number of complete rows
};

}  // namespace

std::unique_ptr<FrameDriver> uniform_driver(const Frame& frame, const Rect& pixels) {
  return std::make_unique<UniformDriver>(frame, pixels);
}

}  // namespace emberline
