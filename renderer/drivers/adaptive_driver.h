// `adaptive`: each round places samples where the error is. This follows Painter & Sloan 1989,
// "Antialiased Ray Tracing by Adaptive Progressive Refinement", and adds modern error estimators.
//
// The driver starts with one sample for every pixel, in the order of the refinement tree. Then it
// takes the estimator's pilot samples. Rounds follow. Before each round, the planner decides from
// the film how many samples each pixel gets next. The driver of a tile starts with the pilot, since
// a tile's picture is shown only when the tile is finished.
#pragma once

#include <memory>

#include "renderer/drivers/driver_table.h"
#include "renderer/drivers/frame_driver.h"

namespace emberline {

// Both throw UsageError for an unknown estimator.
std::unique_ptr<FrameDriver> adaptive_driver(const Frame& frame, const Rect& crop,
                                             const DriverSettings& settings);
std::unique_ptr<FrameDriver> adaptive_tile_driver(const Frame& frame, const Rect& tile,
                                                  const DriverSettings& settings);

FilmExtras adaptive_film_extras(const DriverSettings& settings);

// Returns an upper bound on FrameDriver::bytes(), per pixel.
uint64_t adaptive_bytes_per_pixel(const DriverSettings& settings);

}  // namespace emberline
