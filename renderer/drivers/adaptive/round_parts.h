// Pure functions that determine the order of the pixels in a round of `adaptive`, and divide them
// into parts for threads.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/core/rect.h"

namespace emberline {

// Returns the order in which a round visits the pixels of a crop, as indices of pixels in rows from
// the crop's top. The crop is visited tile by tile (16 x 16 pixels), so that neighbours in the list
// are neighbours in the frame. Tiles are in row-by-row order, and so are the pixels within a tile.
std::vector<uint32_t> tile_order(const Rect& crop);

// Cuts a round's list of pixels into parts of about `samples` samples (at least one pixel each).
// Entry p of the result is part p's first position in the list; the last entry is the list's
// length. Pixel order[k] goes from current[order[k]] to targets[order[k]] samples.
std::vector<size_t> cut_into_parts(std::span<const uint32_t> order,
                                   std::span<const uint32_t> current,
                                   std::span<const uint32_t> targets, uint64_t samples);

// Sorts the parts by the expected gain of their samples, so that a picture from the middle of a
// round has already improved where it was worst. gain[i] is the squared error that pixel i's
// samples in this round are expected to remove; parts are ranked by gain per sample. Parts with
// equal gain are in van der Corput's order, which spreads them over the frame.
std::vector<uint32_t> parts_by_gain(std::span<const size_t> parts, std::span<const uint32_t> order,
                                    std::span<const uint32_t> current,
                                    std::span<const uint32_t> targets, std::span<const float> gain);

}  // namespace emberline
