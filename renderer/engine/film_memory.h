// Memory of films in bytes per pixel, known before they are allocated.
#pragma once

#include <cstddef>
#include <cstdint>

#include "renderer/drivers/driver_table.h"
#include "renderer/film/film.h"

namespace emberline {

// A film's bytes, and those that RenderJob::deliver() adds for pixels without samples.
uint64_t film_bytes_per_pixel(const AovSet& aovs, const FilmExtras& extras);

// The most that render() and deliver() of a job keep of a pixel of the crop, without its workers'
// tiles; each light group adds 24 bytes, and 24 more for all. 0 for drivers of tiles.
uint64_t kept_bytes_per_pixel(const DriverFactory& drivers, const AovSet& aovs);
// The bytes of a pixel of a worker's tile.
uint64_t tile_bytes_per_pixel(const DriverFactory& drivers, const AovSet& aovs);

// Further bytes of RenderJob::deliver() for a film with pixels without samples, for this number of
// layers or lights: their values as shown, and a picture to take them from.
uint64_t shown_layer_bytes_per_pixel(size_t layers);

// Resets the film to the crop. Throws RenderError if there is not enough memory.
void reset_film(const Rect& crop, FilmTile* film);

}  // namespace emberline
