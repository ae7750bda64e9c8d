// The order in which `bucket` renders. Each bucket is finished, streamed out and released, so
// memory does not grow with the frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "renderer/core/names.h"
#include "renderer/core/rect.h"
#include "renderer/drivers/driver_choices.h"

namespace emberline {

std::span<const NamedValue<BucketOrder>> bucket_order_table();

// Returns buckets of `bucket_size` pixels a side (at least 1, asserted), aligned to the crop's
// corner and clipped to the crop. Each pixel of the crop is in exactly one bucket.
//   hilbert   along Hilbert's curve over the smallest power-of-two grid that holds the buckets
//   spiral    from the middle outwards, clockwise, ring by ring
//   scanline  rows from the top, left to right
//   random    a shuffle drawn from `seed`
// Throws UsageError for more than 2^24 buckets.
std::vector<Rect> bucket_schedule(const Rect& crop, int bucket_size, BucketOrder order,
                                  uint32_t seed);

// bucket_count() returns the number of a crop's buckets; bucket_list_bytes() returns the memory
// that the lists of these buckets need.
uint64_t bucket_count(const Rect& crop, int bucket_size);
uint64_t bucket_list_bytes(const Rect& crop, int bucket_size);

// Returns the smallest multiple of the bucket size that is at least `least`. It is the side of a
// tile of whole buckets.
int round_up_to_buckets(int bucket_size, int least);

// Returns the index of a bucket in row-by-row order, which does not depend on the schedule.
size_t bucket_index(const Rect& crop, const Rect& bucket, int bucket_size);

// The buckets on which `threads` threads work at once: their number, and their largest width and
// height.
struct ActiveBuckets {
  int64_t count = 0;
  int width = 0, height = 0;

  uint64_t pixels() const { return uint64_t(count) * uint64_t(width) * uint64_t(height); }
};
ActiveBuckets active_buckets(const Rect& crop, int bucket_size, int threads);

inline constexpr int kMaxBucketSize = 4096;

}  // namespace emberline
