// `bisection`: progressive refinement after Arikan & Gudukbay (2000). The whole frame can be judged
// after the first milliseconds; each further pass doubles the number of samples.
#pragma once

#include <memory>

#include "renderer/drivers/bisection_schedule.h"
#include "renderer/drivers/driver_table.h"
#include "renderer/drivers/frame_driver.h"

namespace emberline {

std::unique_ptr<FrameDriver> bisection_driver(const Frame& frame, const Rect& crop,
                                              const DriverSettings& settings);

// End of the round that begins with part `first`. Rounds of the first pass stay within one step and
// have at most a hundredth of the frame's pixels (or one part), so that the picture can be shown
// often. Each later pass is one round, because a pause keeps each thread waiting for half a part.
size_t bisection_round_end(const BisectionPass& pass, size_t first, uint64_t frame_pixels);

// Pixels in a part of the pass: a power of two.
uint64_t bisection_part_pixels(const SampleRange& samples, uint64_t frame_pixels);

}  // namespace emberline
