#include "renderer/frame/frame.h"

#include <tuple>

namespace emberline {

namespace {

bool comes_before(const NonFiniteSample& a, const NonFiniteSample& b) {
  return std::tie(a.y, a.x, a.sample, a.seed) < std::tie(b.y, b.x, b.sample, b.seed);
}

}  // namespace

FrameCounters Frame::no_counts() const {
  FrameCounters counters;
  if (clamp_indirect > 0.0f) {
    counters.clamped = ClampedLight(clamp_indirect, light_groups ? light_groups->size() : 0);
  }
  return counters;
}

void FrameCounters::locate(const NonFiniteSample& sample) {
  located.insert(std::ranges::upper_bound(located, sample, comes_before), sample);
  if (located.size() > kLocatedLimit) located.pop_back();
}

void FrameCounters::merge(const FrameCounters& other) {
  rays.merge(other.rays);
  max_samples = std::max(max_samples, other.max_samples);
  samples += other.samples;
  non_finite_samples += other.non_finite_samples;
  clamped.merge(other.clamped);
  located.insert(located.end(), other.located.begin(), other.located.end());
  std::ranges::sort(located, comes_before);
  if (located.size() > kLocatedLimit) located.resize(kLocatedLimit);
}

void FrameCounters::archive(Archive& archive) {
  constexpr uint64_t kMost = UINT64_MAX / 4;  // sums of a few stay numbers
  for (uint64_t* count :
       {&rays.camera, &rays.scatter, &rays.shadow, &samples, &non_finite_samples}) {
    archive.number(*count, uint64_t(0), kMost);
  }
  archive.number(min_samples, 0u, UINT32_MAX);
  archive.number(max_samples, 0u, UINT32_MAX);
  clamped.archive(archive);
  archive.list(located, kLocatedLimit);
  archive.check(located.empty() == (non_finite_samples == 0));
}

}  // namespace emberline
