#include "renderer/engine/live_picture.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "renderer/engine/film_memory.h"
#include "renderer/engine/render_plan.h"
#include "renderer/film/film.h"
#include "renderer/film/light_mix.h"

namespace emberline {
namespace {

FilmExtras picture_extras(const RenderPlan& plan) {
  return {.sample_variance = film_extras(*plan.driver, plan.driver_settings).sample_variance};
}

}  // namespace

const Rect& LivePicture::rect() const { return film().rect(); }
uint32_t LivePicture::sample_count(int x, int y) const { return film().sample_count(x, y); }
uint32_t LivePicture::non_finite(int x, int y) const { return film().non_finite(x, y); }
std::optional<Rgb> LivePicture::variance(int x, int y) const { return film().variance(x, y); }

std::vector<float> LivePicture::channels() const {
  std::vector<float> values;
  film().resolve(values);
  return values;
}

TilePicture::TilePicture(const RenderPlan& plan, std::vector<float> before)
    : film_(std::make_unique<FilmTile>(plan.aovs, picture_extras(plan))),
      overrides_means_(plan.driver_settings.adaptive.unbiased),
      rgba_(std::move(before)) {
  reset_film(plan.crop, film_.get());
  assert(rgba_.size() == 4 * size_t(plan.crop.area()));
}

TilePicture::~TilePicture() = default;

uint64_t TilePicture::bytes_per_pixel(const RenderPlan& plan) {
  return film_bytes_per_pixel(plan.aovs, picture_extras(plan)) + 4 * sizeof(float);
}

Rect TilePicture::add(const FilmTile& tile) {
  const Rect& rect = tile.rect();
  for (int y = rect.y0; y < rect.y1; ++y) {
    for (int x = rect.x0; x < rect.x1; ++x) {
      film_->copy_pixel(tile, x, y);
      float* shown = &rgba_[4 * film_->rect().index_of(x, y)];
      tile.rgba(x, y, shown);
      if (overrides_means_) film_->set_override(x, y, shown);
      samples_ += tile.sample_count(x, y);
    }
  }
  pixels_ += rect.area();
  return rect;
}

void TilePicture::resolve(std::span<float> rgba, const LightMix* mix) const {
  std::ranges::copy(rgba_, rgba.begin());
  if (!mix) return;
  for (size_t i = 0; i < rgba_.size() / 4; ++i) {
    if (film_->sums(i).samples() > 0) film_->lights(i).relight_pixel(*mix, &rgba[4 * i]);
  }
}

PixelStop TilePicture::current_stop(int x, int y) const {
  return film_->sample_count(x, y) > 0 ? film_->stop(x, y) : PixelStop::kUnfinished;
}

}  // namespace emberline
