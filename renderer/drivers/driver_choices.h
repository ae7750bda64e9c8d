// Values of the drivers' settings, for code that does not include the drivers.
#pragma once

#include <cstdint>
#include <string_view>

namespace emberline {

// The maximum number of samples of a pixel. The film's sums would be exact for more samples, but
// the `samples` channel passes through a float, which is exact only up to 2^24.
inline constexpr uint32_t kMaxSamples = 1u << 24;

// The order of the tiles of `bucket` (bucket_schedule.h).
enum class BucketOrder { kHilbert, kSpiral, kScanline, kRandom };

// The lines by which `bisection` divides the frame: rows, columns, or both in turn.
enum class BisectionAxis { kRows, kColumns, kBoth };

// The default estimator of error.
inline constexpr std::string_view kDefaultEstimator = "nested";

// Says how a pixel without samples is shown: as its nearest neighbour, or as a blend of pixels.
enum class Reconstruction { kDuplicate, kLinear };

// How a squared error is weighted (error_metric_table() in drivers/adaptive/error_estimator.h).
enum class ErrorMetric { kMse, kRelMse, kDisplay };

// Setting `part`: selects every `count`-th tile in the driver's order, starting with tile `index`.
// The first tile has index 1.
struct FramePart {
  uint32_t index = 1, count = 1;
  bool operator==(const FramePart&) const = default;
};

}  // namespace emberline
