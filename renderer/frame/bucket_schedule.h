// The order of `bucket`: the frame in buckets, each finished, then streamed out and let go, so that
// memory does not grow with the frame.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "renderer/core/rect.h"

namespace emberline {

enum class BucketOrder { kHilbert, kSpiral, kScanline, kRandom };

struct BucketOrderEntry {
  std::string_view name;
  std::string_view summary;
  BucketOrder order;
};
std::span<const BucketOrderEntry> bucket_order_table();
// Throws UsageError that lists the valid names.
BucketOrder parse_bucket_order(std::string_view name);

// Buckets of size x size pixels, aligned to the crop's corner and clipped by
// it, each pixel of the crop in exactly one.
//   hilbert   along Hilbert's curve over the smallest power-of-two grid that holds the buckets
//   spiral    from the middle outwards, clockwise, ring by ring
//   scanline  rows from the top, left to right
//   random    a shuffle drawn from `seed`
// Throws UsageError for more than 2^24 buckets.
std::vector<Rect> bucket_schedule(const Rect& crop, int bucket_size, BucketOrder order,
                                  uint32_t seed);

inline constexpr int kMostBucketSize = 4096;
// Throws UsageError outside [1, kMostBucketSize].
int checked_bucket_size(int bucket_size);

}  // namespace emberline
