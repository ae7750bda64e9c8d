// Choices of drivers for settings, without the drivers themselves.
#pragma once

#include <cstdint>
#include <string_view>

namespace emberline {

// The most samples of a pixel. The film's sums are exact beyond it, and the `samples` channel, a
// float on its way to the file, counts to 2^24 exactly.
inline constexpr uint32_t kMaxSamples = 1u << 24;

// The order of the tiles of `bucket` (bucket_schedule.h).
enum class BucketOrder { kHilbert, kSpiral, kScanline, kRandom };

// Which lines `bisection` halves the frame by: whole rows, whole columns, or both in turn.
enum class BisectionAxis { kRows, kColumns, kBoth };

// Which estimator decides how large an error is, unless settings say so.
inline constexpr std::string_view kDefaultEstimator = "nested";

// How pixels without samples are shown: by their neighbour, or blended.
enum class Reconstruction { kDuplicate, kLinear };

// In what units an error counts (drivers/adaptive/error_estimator.h).
enum class ErrorMetric { kMse, kRelMse, kDisplay, kDenoised };

// Every `count`-th tile of the driver's order, from the `index`-th on, 1 the first.
struct FramePart {
  uint32_t index = 1, count = 1;
  bool operator==(const FramePart&) const = default;
};

}  // namespace emberline
