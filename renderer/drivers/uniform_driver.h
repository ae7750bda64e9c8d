// Gives every pixel the same number of samples, row by row.
#pragma once

#include "renderer/drivers/frame.h"
#include "renderer/drivers/frame_driver.h"

namespace emberline {

class UniformDriver final : public FrameDriver {
 public:
  UniformDriver(const Frame& frame, const Rect& pixels)
      : pixels_(pixels), seed_(frame.seed), samples_per_pixel_(frame.samples_per_pixel) {}

  std::optional<Round> next(FilmTile& film, const std::stop_token& stop) override;
  Round round() const override;
  void expand(size_t part, std::vector<PixelWork>& list) const override;
  uint64_t samples(size_t) const override { return uint64_t(pixels_.width()) * samples_per_pixel_; }
  void rendered(const RenderedParts& parts, const FilmTile& film) override;
  bool finished() const override { return rows_ == pixels_.height(); }
  uint32_t least_samples(const FilmTile& film) const override;
  PixelStop stop_so_far(const FilmTile& film, int x, int y) const override;
  void end(FilmTile& film, PixelStop cut_short) override;
  void archive(Archive& archive, const FilmTile& film) override;

 private:
  const Rect pixels_;
  const uint32_t seed_, samples_per_pixel_;
  bool begun_ = false;
  int rows_ = 0;  // complete
};

}  // namespace emberline
