#include "renderer/drivers/frame_driver.h"

#include <algorithm>
#include <tuple>

#include "renderer/core/names.h"
#include "renderer/drivers/adaptive_driver.h"
#include "renderer/drivers/bisection_driver.h"
#include "renderer/drivers/bucket_driver.h"

namespace emberline {
namespace {

constexpr DriverEntry kDrivers[] = {
    {"bucket", "bucket after bucket, each finished, streamed out and released",
     [](const DriverSettings& settings) -> std::unique_ptr<FrameDriver> {
       return std::make_unique<BucketDriver>(settings);
     }},
    {"bisection", "the whole frame at once, refined line between lines and pass after pass",
     [](const DriverSettings& settings) -> std::unique_ptr<FrameDriver> {
       return std::make_unique<BisectionDriver>(settings);
     },
     true},
    {"adaptive", "the whole frame, samples going where the error is",
     [](const DriverSettings& settings) -> std::unique_ptr<FrameDriver> {
       return std::make_unique<AdaptiveDriver>(settings);
     },
     true},
};

}  // namespace

std::span<const DriverEntry> driver_table() { return kDrivers; }

std::unique_ptr<FrameDriver> create_driver(std::string_view name, const DriverSettings& settings) {
  // A misspelt name is an error even where the chosen driver would not look at it.
  parse_bucket_order(settings.bucket_order);
  parse_bisection_axis(settings.bisection_axis);
  parse_reconstruction(settings.reconstruction);
  return find_named(kDrivers, "--driver", "driver", name).create(settings);
}

void FrameCounters::merge(const FrameCounters& other) {
  rays.merge(other.rays);
  // A worker that came too late for any bucket has nothing to say about the least count.
  if (other.samples > 0 || other.stopped) {
    min_samples = samples == 0 ? other.min_samples : std::min(min_samples, other.min_samples);
  }
  max_samples = std::max(max_samples, other.max_samples);
  samples += other.samples;
  non_finite_samples += other.non_finite_samples;
  located.insert(located.end(), other.located.begin(), other.located.end());
  std::sort(located.begin(), located.end(), [](const auto& a, const auto& b) {
    return std::tie(a.y, a.x, a.sample) < std::tie(b.y, b.x, b.sample);
  });
  if (located.size() > kLocatedLimit) located.resize(kLocatedLimit);
  stopped = stopped || other.stopped;
}

}  // namespace emberline
