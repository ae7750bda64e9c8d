#include "renderer/frame/frame.h"

#include <tuple>

namespace emberline {

void FrameCounters::merge(const FrameCounters& other) {
  rays.merge(other.rays);
  max_samples = std::max(max_samples, other.max_samples);
  samples += other.samples;
  non_finite_samples += other.non_finite_samples;
  located.insert(located.end(), other.located.begin(), other.located.end());
  std::sort(located.begin(), located.end(), [](const auto& a, const auto& b) {
    return std::tie(a.y, a.x, a.sample) < std::tie(b.y, b.x, b.sample);
  });
  if (located.size() > kLocatedLimit) located.resize(kLocatedLimit);
}

}  // namespace emberline
