// What a frame will hold until it is written, before there is any of it: for a budget.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "renderer/core/memory_budget.h"
#include "renderer/engine/render_plan.h"
#include "renderer/output/outputs.h"

namespace emberline {

// Adds what the frame holds until it is written: its film and files, the lists of its buckets, and
// the tiles that so many threads work on at once. Throws UsageError: sizes are the settings'.
void reserve_frame(const RenderOptions& options, const OutputSettings& settings,
                   const RenderPlan& plan, int threads, MemoryReservation& memory);
// What these layers of light groups, which are known later, add to that.
void reserve_lights(const RenderOptions& options, const OutputSettings& settings,
                    const RenderPlan& plan, const std::vector<std::string>& layers, int threads,
                    MemoryReservation& memory);
// Adds bytes of a frame of the crop's size. Throws UsageError.
void reserve_pixels(uint64_t bytes, const Rect& crop, MemoryReservation& memory);

// What the files hold of it until they are written, with these layers of light groups.
uint64_t output_bytes(const RenderOptions& options, const OutputSettings& settings,
                      const std::vector<std::string>& layers);
// What writing so many channels of a tile takes of each of its pixels, about.
uint64_t written_bytes_per_pixel(size_t channels);

}  // namespace emberline
