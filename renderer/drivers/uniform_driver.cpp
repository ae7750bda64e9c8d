#include "renderer/drivers/uniform_driver.h"

#include "renderer/core/archive.h"
#include "renderer/film/film.h"

namespace emberline {

std::optional<Round> UniformDriver::next(FilmTile&, const std::stop_token&) {
  if (begun_) return std::nullopt;
  begun_ = true;
  return round();
}

Round UniformDriver::round() const {
  return {begun_ ? size_t(pixels_.height()) : 0, seed_, 1, true};
}

void UniformDriver::expand(size_t part, std::vector<PixelWork>& list) const {
  for (int x = pixels_.x0; x < pixels_.x1; ++x) {
    list.push_back({x, pixels_.y0 + int(part), 0, samples_per_pixel_});
  }
}

void UniformDriver::rendered(const RenderedParts& parts, const FilmTile&) {
  if (parts.complete) rows_ = int(parts.end);
}

uint32_t UniformDriver::least_samples(const FilmTile& film) const {
  return finished() ? samples_per_pixel_ : film.least_samples();
}

PixelStop UniformDriver::stop_so_far(const FilmTile& film, int x, int y) const {
  return film.sample_count(x, y) < samples_per_pixel_ ? PixelStop::kGoingOn : PixelStop::kBudget;
}

void UniformDriver::archive(Archive& archive, const FilmTile&) {
  archive.number(begun_, false, true);
  archive.number(rows_, 0, pixels_.height());
}

void UniformDriver::end(FilmTile& film, PixelStop cut_short) {
  film.mark_stops(samples_per_pixel_, cut_short);
}

}  // namespace emberline
