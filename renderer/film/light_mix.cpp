#include "renderer/film/light_mix.h"

#include <cassert>

#include "renderer/core/parallel.h"
#include "renderer/film/film.h"

namespace emberline {

LightMix::LightMix(std::span<const Rgb> weights, Source source) : source_(source) {
  weights_.reserve(weights.size());
  for (const Rgb& weight : weights) weights_.push_back(color4(weight));
}

LightGroupSums LightMix::sums(const FilmTile& film, size_t pixel) const {
  return source_ == Source::kLights ? film.lights(pixel) : film.layers(pixel);
}

void relight(const FilmTile& film, const LightMix& mix, std::span<float> rgba) {
  const auto pixels = size_t(film.rect().area());
  assert(rgba.size() >= 4 * pixels);
  if (pixels == 0) return;
  const LightGroupSums first = mix.sums(film, 0);
  constexpr size_t kGrain = 4096;  // about 15 us
  parallel_ranges(pixels, kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) first.at_offset(i).relight_pixel(mix, &rgba[4 * i]);
  });
}

}  // namespace emberline
