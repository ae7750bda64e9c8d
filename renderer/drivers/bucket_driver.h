// `bucket`: the frame in buckets, each finished, then streamed out and let go, so that memory does
// not grow with the frame. With a noise threshold, each bucket goes on until its pixels meet it.
#pragma once

#include <string_view>
#include <vector>

#include "renderer/drivers/frame_driver.h"

namespace emberline {

class RenderWorker;

enum class BucketOrder { kHilbert, kSpiral, kScanline, kRandom };

struct BucketOrderEntry {
  std::string_view name;
  std::string_view summary;
  BucketOrder order;
};
std::span<const BucketOrderEntry> bucket_order_table();
// Throws UsageError that lists the valid names.
BucketOrder parse_bucket_order(std::string_view name);

// The driver's work: buckets of size x size pixels, aligned to the window's corner and clipped by
// it, each pixel of the window in exactly one.
//   hilbert   along Hilbert's curve over the smallest power-of-two grid that holds the buckets
//   spiral    from the middle outwards, clockwise, ring by ring
//   scanline  rows from the top, left to right
//   random    a shuffle drawn from `seed`
// Throws UsageError for more than 2^24 buckets.
std::vector<WorkItem> bucket_schedule(const Rect& window, int bucket_size, BucketOrder order,
                                      uint32_t samples_per_pixel, uint32_t seed);

// Throws UsageError outside [1, 4096].
int checked_bucket_size(int bucket_size);

class BucketDriver final : public FrameDriver {
 public:
  // Throws UsageError for a bucket size outside [1, 4096] or an unknown order.
  explicit BucketDriver(const DriverSettings& settings);
  FrameCounters render(const Frame& frame, FrameObserver& observer, std::stop_token stop) override;
  std::optional<double> error_estimate() const override { return error_estimate_; }

 private:
  double render_adaptively(const Frame& frame, RenderWorker& worker, FilmTile& tile,
                           FrameObserver& observer, const std::stop_token& stop) const;

  int bucket_size_;
  BucketOrder order_;
  AdaptiveSettings adaptive_;  // in force if it has a threshold
  std::optional<double> error_estimate_;
};

}  // namespace emberline
