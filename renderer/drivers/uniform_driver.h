// Gives every pixel the same number of samples, row by row.
#pragma once

#include <memory>

#include "renderer/drivers/frame.h"
#include "renderer/drivers/frame_driver.h"

namespace emberline {

std::unique_ptr<FrameDriver> uniform_driver(const Frame& frame, const Rect& pixels);

}  // namespace emberline
