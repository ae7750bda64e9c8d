// `adaptive`: samples go where the error is, round by round (after Painter & Sloan 1989,
// "Antialiased Ray Tracing by Adaptive Progressive Refinement", with today's estimators beside
// theirs).
//
// First one sample for every pixel, in the order of the refinement tree; then the estimator's
// pilot; then rounds: at each barrier the planner decides from the film how many samples every
// pixel gets next. If the picture is not shown before it is finished, it begins with the pilot.
#pragma once

#include <memory>

#include "renderer/drivers/driver_table.h"
#include "renderer/drivers/frame_driver.h"

namespace emberline {

// Both throw UsageError for an unknown estimator. A tile is not shown before it is finished.
std::unique_ptr<FrameDriver> adaptive_driver(const Frame& frame, const Rect& crop,
                                             const DriverSettings& settings);
std::unique_ptr<FrameDriver> adaptive_tile_driver(const Frame& frame, const Rect& tile,
                                                  const DriverSettings& settings);

FilmExtras adaptive_film_extras(const DriverSettings& settings);

// The most that FrameDriver::bytes() reaches, per pixel.
uint64_t adaptive_bytes_per_pixel(const DriverSettings& settings);

}  // namespace emberline
