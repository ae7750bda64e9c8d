// What films take, in bytes per pixel, before there are any.
#pragma once

#include <cstddef>
#include <cstdint>

#include "renderer/drivers/driver_table.h"
#include "renderer/film/film.h"

namespace emberline {

// What a film holds of a pixel, and RenderJob::deliver() beside it where it fills in.
uint64_t film_bytes_per_pixel(const AovSet& aovs, const FilmExtras& extras);

// What a job holds of each pixel of the crop in render() and deliver(), beside its workers' tiles,
// at most; with light groups 24 bytes for each and 24 more. 0 by tiles.
uint64_t kept_bytes_per_pixel(const DriverFactory& drivers, const AovSet& aovs);
// Of each pixel of a worker's tile.
uint64_t tile_bytes_per_pixel(const DriverFactory& drivers, const AovSet& aovs);

// What RenderJob::deliver() takes of a film whose pixels do not all have a sample, for so many
// layers or lights: each as it is shown, and a picture that they are taken from.
uint64_t shown_layer_bytes_per_pixel(size_t layers);

// Makes the film ready for the crop. Throws RenderError if there is not the memory for it.
void reset_film(const Rect& crop, FilmTile* film);

}  // namespace emberline
