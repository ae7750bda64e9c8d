// What a frame will hold until it is written, before there is any of it: for a budget.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "renderer/core/memory_budget.h"
#include "renderer/engine/render_plan.h"
#include "renderer/output/outputs.h"

namespace emberline {

// An upper bound of film_bytes() of the render and outputs and of what encoding a picture takes on
// top. Light groups are known later: what they add.
uint64_t frame_bytes(const RenderOptions& options, const OutputSettings& settings,
                     const RenderPlan& plan);
uint64_t light_group_bytes(const RenderOptions& options, const OutputSettings& settings,
                           const RenderPlan& plan, const std::vector<std::string>& layers);
// What light groups add to a pixel of a tile that is worked on: to the film of all samples and, for
// denoising, to that of a half.
uint64_t light_tile_bytes_per_pixel(const AovSet& aovs, size_t lights);
// What the files hold of it until they are written, with these layers of light groups.
uint64_t output_bytes(const RenderOptions& options, const OutputSettings& settings,
                      const std::vector<std::string>& layers);

// Adds it. Throws UsageError: the size of a frame is the command line's.
void reserve_frame(uint64_t bytes, const Rect& crop, MemoryReservation& memory);
// Adds the lists of the frame's buckets, and where each output has them. Throws UsageError: their
// size is the command line's.
void reserve_bucket_lists(const RenderOptions& options, const OutputSettings& settings,
                          MemoryReservation& memory);
// What writing so many channels of a tile takes of each of its pixels, about.
uint64_t written_bytes_per_pixel(size_t channels);
// The number of channels that a tile has when it is written, with these layers of light groups.
size_t tile_channels(const OutputSettings& settings, const std::vector<std::string>& layers);
// Adds the tiles that so many threads work on at once, with what writing them takes. Throws
// UsageError, as their size is.
void reserve_tiles(uint64_t film_bytes_per_pixel, size_t channels, const OutputSettings& settings,
                   int threads, MemoryReservation& memory);

}  // namespace emberline
