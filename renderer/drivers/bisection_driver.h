// `bisection`: progressive refinement after Arikan & Gudukbay (2000). A rough picture of the whole
// frame is visible after the first milliseconds; each further pass doubles the number of samples.
#pragma once

#include <memory>

#include "renderer/drivers/bisection_schedule.h"
#include "renderer/drivers/driver_table.h"
#include "renderer/drivers/frame_driver.h"

namespace emberline {

std::unique_ptr<FrameDriver> bisection_driver(const Frame& frame, const Rect& crop,
                                              const DriverSettings& settings);

// Returns the end of the round that begins with part `first`. A round of the first pass stays
// within one step and has at most a hundredth of the frame's pixels, or one part if that has more
// pixels, so that the picture can be shown often. Each later pass is one round, because threads
// wait at the end of a round, on average for half the time that a part takes.
size_t bisection_round_end(const BisectionPass& pass, size_t first, uint64_t frame_pixels);

// Returns the maximum number of pixels in a part of a pass with these samples, a power of two.
uint64_t bisection_part_pixels(const SampleRange& samples, uint64_t frame_pixels);

}  // namespace emberline
