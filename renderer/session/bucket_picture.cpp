#include "renderer/session/bucket_picture.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "renderer/engine/film_memory.h"
#include "renderer/engine/render_job.h"
#include "renderer/film/light_mix.h"

namespace emberline {

BucketPicture::BucketPicture(const Rect& crop, const AovSet& aovs, bool averages,
                             std::vector<float> before, const FilmExtras& extras)
    : film_(aovs, extras), averages_(averages), rgba_(std::move(before)) {
  reset_film(crop, &film_);
  assert(rgba_.size() == 4 * size_t(crop.area()));
  rgba8_.resize(rgba_.size());
}

void BucketPicture::finish(const FilmTile& tile, const std::shared_ptr<const Grading>& grading) {
  const Rect& rect = tile.rect();
  const Rect& crop = film_.rect();
  const size_t row = 4 * size_t(rect.width());
  for (int y = rect.y0; y < rect.y1; ++y) {
    const size_t first = 4 * crop.index_of(rect.x0, y);
    for (int x = rect.x0; x < rect.x1; ++x) {
      film_.copy_pixel(tile, x, y);
      float* shown = &rgba_[4 * crop.index_of(x, y)];
      tile.rgba(x, y, shown);
      if (averages_) film_.show(x, y, shown);
      samples_ += tile.sample_count(x, y);
    }
    if (grading && grading == grading_)
      grading->grade_run({&rgba_[first], row}, {&rgba8_[first], row});
  }
  pixels_ += rect.area();
  std::erase(in_progress_, rect);
}

std::span<const uint8_t> BucketPicture::rgba8(const std::shared_ptr<const Grading>& grading) {
  if (grading != grading_) {
    // On this thread alone: it must not begin another bucket while it waits for help.
    grading->grade_run(rgba_, rgba8_);
    grading_ = grading;
  }
  return rgba8_;
}

void BucketPicture::resolve(std::span<float> rgba, const LightMix* mix) const {
  std::ranges::copy(rgba_, rgba.begin());
  if (!mix) return;
  for (size_t i = 0; i < rgba_.size() / 4; ++i) {
    if (film_.sums(i).samples() > 0) film_.light_groups().relit(i, *mix, &rgba[4 * i]);
  }
}

}  // namespace emberline
