#include "renderer/engine/film_memory.h"

#include <fmt/format.h>

#include <new>

#include "renderer/core/errors.h"

namespace emberline {

uint64_t film_bytes_per_pixel(const AovSet& aovs, const FilmExtras& extras) {
  FilmTile pixel(aovs, extras);
  pixel.reset({0, 0, 1, 1});
  return pixel.bytes() + 4 * sizeof(float);
}

uint64_t job_bytes_per_pixel(const DriverFactory& drivers, const AovSet& aovs) {
  if (drivers.tiles) return 0;
  return film_bytes_per_pixel(aovs, drivers.film_extras) + drivers.bytes_per_pixel;
}

uint64_t tile_bytes_per_pixel(const DriverFactory& drivers, const AovSet& aovs) {
  const uint64_t driver_bytes = drivers.tiles ? drivers.bytes_per_pixel : 0;
  return film_bytes_per_pixel(aovs, drivers.film_extras) + driver_bytes;
}

uint64_t delivery_bytes_per_pixel(size_t layers) {
  return layers * sizeof(Rgb) + (layers > 0 ? 4 * sizeof(float) : 0);
}

void reset_film(const Rect& crop, FilmTile* film) {
  try {
    film->reset(crop);
  } catch (const std::bad_alloc&) {
    throw RenderError(
        fmt::format("not enough memory for a frame of {}x{} pixels; use `driver` bucket, whose "
                    "memory use does not depend on the size of the frame",
                    crop.width(), crop.height()));
  }
}

}  // namespace emberline
