// Predicts how much memory a frame needs until it is written, and reserves this memory in the
// budget.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "renderer/core/memory_budget.h"
#include "renderer/engine/render_plan.h"
#include "renderer/output/outputs.h"

namespace emberline {

// Reserves memory for the frame's film, files and bucket lists, and for the tiles that `threads`
// threads work on at once. Throws UsageError if the budget is too small, because the sizes come
// from settings.
void reserve_frame(const RenderOptions& options, const OutputSettings& settings,
                   const RenderPlan& plan, int threads, MemoryReservation& memory);
// Reserves the additional memory for light groups. Their layers are not yet known when
// reserve_frame() is called.
void reserve_lights(const RenderOptions& options, const OutputSettings& settings,
                    const RenderPlan& plan, const std::vector<std::string>& layers, int threads,
                    MemoryReservation& memory);
// Reserves `bytes` bytes for data whose amount depends on the size of the crop. Throws a UsageError
// that states the crop's size.
void reserve_pixels(uint64_t bytes, const Rect& crop, MemoryReservation& memory);

// Returns the bytes per pixel that the driver needs to estimate the error of light groups.
uint64_t judged_light_bytes(const RenderPlan& plan, size_t lights);

// Returns how many bytes the output files of a frame with these light-group layers keep in memory
// until they are written.
uint64_t output_bytes(const RenderOptions& options, const OutputSettings& settings,
                      const std::vector<std::string>& layers);
// Returns approximately how many bytes per pixel are needed to write a tile with this many
// channels.
uint64_t write_bytes_per_pixel(size_t channels);

}  // namespace emberline
