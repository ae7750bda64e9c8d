// Computes the memory of films in bytes per pixel before they are allocated.
#pragma once

#include <cstddef>
#include <cstdint>

#include "renderer/drivers/driver_table.h"
#include "renderer/film/film.h"

namespace emberline {

// Returns the bytes per pixel of a film, including what RenderJob::deliver() adds for pixels
// without samples.
uint64_t film_bytes_per_pixel(const AovSet& aovs, const FilmExtras& extras);

// Returns an upper bound on the bytes that render() and deliver() keep per pixel of the crop; 0 for
// tiled drivers. Excludes the workers' tiles. Also excludes light groups; `n` groups add 24 (n + 1)
// bytes per pixel.
uint64_t job_bytes_per_pixel(const DriverFactory& drivers, const AovSet& aovs);
// Returns the bytes per pixel of a worker's tile.
uint64_t tile_bytes_per_pixel(const DriverFactory& drivers, const AovSet& aovs);

// Returns the additional bytes per pixel that RenderJob::deliver() needs if some pixels have no
// samples. This memory holds a picture and, computed from it, the displayed values of `layers`
// light groups or light-path layers.
uint64_t delivery_bytes_per_pixel(size_t layers);

// Resets the film to the crop. Throws RenderError if there is not enough memory.
void reset_film(const Rect& crop, FilmTile* film);

}  // namespace emberline
