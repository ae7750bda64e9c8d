// Predicts the memory that a frame needs until it is written, for the budget.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "renderer/core/memory_budget.h"
#include "renderer/engine/render_plan.h"
#include "renderer/output/outputs.h"

namespace emberline {

// Reserves the frame's film, files and bucket lists, and the tiles that `threads` threads work on
// at once. Throws UsageError, since sizes are settings.
void reserve_frame(const RenderOptions& options, const OutputSettings& settings,
                   const RenderPlan& plan, int threads, MemoryReservation& memory);
// Reserves in addition what light groups need; their layers are known later.
void reserve_lights(const RenderOptions& options, const OutputSettings& settings,
                    const RenderPlan& plan, const std::vector<std::string>& layers, int threads,
                    MemoryReservation& memory);
// Reserves memory proportional to the crop. Throws UsageError.
void reserve_pixels(uint64_t bytes, const Rect& crop, MemoryReservation& memory);

// Bytes that the output files hold until they are written, with these light-group layers.
uint64_t output_bytes(const RenderOptions& options, const OutputSettings& settings,
                      const std::vector<std::string>& layers);
// Approximate bytes per pixel for writing a tile of `channels` channels.
uint64_t write_bytes_per_pixel(size_t channels);

}  // namespace emberline
