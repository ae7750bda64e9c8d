#include "renderer/drivers/frame_driver.h"

#include "renderer/core/parallel.h"
#include "renderer/core/rect.h"
#include "renderer/film/film.h"
#include "renderer/film/light_mix.h"

namespace emberline {

void FrameDriver::resolve(const FilmTile& film, std::span<float> rgba, const LightMix* mix) const {
  if (mix) return relight(film, *mix, rgba);
  const Rect& pixels = film.rect();
  constexpr size_t kGrain = 4096;  // as relight()
  parallel_ranges(size_t(pixels.area()), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) film.rgba(pixels.x_of(i), pixels.y_of(i), &rgba[4 * i]);
  });
}

}  // namespace emberline
