// The pixels of a round of `adaptive`: their order, and how they are shared out among threads. Pure
// functions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/core/rect.h"

namespace emberline {

// The pixels of a crop in the order in which a round visits them: tiles of 16 x 16 pixels row by
// row, and within a tile row by row, so that neighbours in the list are neighbours in the frame. By
// index, rows from the crop's top.
std::vector<uint32_t> tile_order(const Rect& crop);

// Cuts a round's list of pixels into parts of about `samples` samples (at least one pixel each):
// entry p is part p's first place in the list, the last entry the list's length. Pixel order[k] is
// to go from have[order[k]] to targets[order[k]] samples.
std::vector<size_t> cut_into_parts(std::span<const uint32_t> order, std::span<const uint32_t> have,
                                   std::span<const uint32_t> targets, uint64_t samples);

// Sorts the parts by the expected gain of their samples, so that a picture shown or stopped in the
// middle of a round has improved where it was worst. gain[i] is the squared error that the
// samples of pixel i in this round take away; a part's rank is the sum over its pixels by its
// samples. Equal parts come in van der Corput's order, spread over the frame.
std::vector<uint32_t> parts_by_gain(std::span<const size_t> parts, std::span<const uint32_t> order,
                                    std::span<const uint32_t> have,
                                    std::span<const uint32_t> targets, std::span<const float> gain);

}  // namespace emberline
