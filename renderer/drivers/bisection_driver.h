// `bisection`: progressive refinement after Arikan & Gudukbay (2000). The whole frame can be judged
// after the first milliseconds. Each further pass over the frame doubles the number of samples.
#pragma once

#include <memory>

#include "renderer/drivers/bisection_schedule.h"
#include "renderer/drivers/driver_table.h"
#include "renderer/drivers/frame_driver.h"

namespace emberline {

std::unique_ptr<FrameDriver> bisection_driver(const Frame& frame, const Rect& crop,
                                              const DriverSettings& settings);

// The end of the round that begins with part `first`. In the first pass a round stays within a step
// and has at most a hundredth of the frame's pixels (or one part), so that the picture can be shown
// often. Each later pass is one round, because every pause costs waiting threads half a part.
size_t bisection_round_end(const BisectionPass& pass, size_t first, uint64_t frame_pixels);

// How many pixels of a pass make a part: a power of two.
uint64_t bisection_part_pixels(const SampleRange& samples, uint64_t frame_pixels);

}  // namespace emberline
