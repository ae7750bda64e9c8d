// Drivers that know the sample count of every pixel before they begin: the same count for all, or
// the counts of a plan.
#pragma once

#include <memory>

#include "renderer/drivers/driver_table.h"
#include "renderer/drivers/frame_driver.h"

namespace emberline {

// Gives every pixel Frame::samples_per_pixel samples.
std::unique_ptr<FrameDriver> uniform_driver(const Frame& frame, const Rect& pixels);

// Gives each pixel its count in DriverSettings::plan, which must cover `pixels`.
std::unique_ptr<FrameDriver> planned_driver(const Frame& frame, const Rect& pixels,
                                            const DriverSettings& settings);

}  // namespace emberline
