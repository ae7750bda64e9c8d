#include "renderer/reconstruction/sample_sharing.h"

#include <cmath>

#include "renderer/core/parallel.h"

namespace emberline {
namespace {

// A neighbour's mean of fewer samples, as a share of the pixel's own, may be noisier than what it
// is to help.
constexpr float kFewer = 0.5f;
// The weights' expectation is 1; negative lobes of a filter may leave less.
constexpr float kLeastWeight = 0.25f;

std::span<const float> of_half(const HalfPlanes& planes, size_t half) {
  return half == 0 ? planes.a : planes.b;
}

}  // namespace

SharedColour::SharedColour(const DenoiseInput& input) {
  if (input.shared[0].weight.a.empty() || !input.parts.empty()) return;
  const auto width = size_t(input.width);
  for (size_t s = 0; s < 2; ++s) {
    for (size_t c = 0; c < 3; ++c) {
      const std::span<const float> own = of_half(input.colour[c], s);
      planes_[c][s].assign(own.begin(), own.end());
    }
    const std::span<const float> count = of_half(input.samples, s);
    parallel_each(size_t(std::max(input.height - 2, 0)), [&](size_t row) {
      for (size_t x = 1; x + 1 < width; ++x) {
        const size_t i = (row + 1) * width + x;
        float sum[4] = {};
        bool enough = true;
        for (size_t k = 0; k < input.shared.size(); ++k) {
          // What the pixel on the one side counts for the one on its other side.
          const size_t from = i + width + 1 - (k / 3) * width - k % 3;
          enough &= count[from] >= kFewer * count[i] && count[from] > 0;
          for (size_t c = 0; c < 3; ++c) sum[c] += of_half(input.shared[k].colour[c], s)[from];
          sum[3] += of_half(input.shared[k].weight, s)[from];
        }
        if (!enough || !(sum[3] >= kLeastWeight)) continue;
        for (size_t c = 0; c < 3; ++c) {
          const float value = sum[c] / sum[3];
          if (std::isfinite(value)) planes_[c][s][i] = value;
        }
      }
    });
  }
}

HalfColour SharedColour::colour() const {
  HalfColour colour;
  for (size_t c = 0; c < 3; ++c) colour[c] = {planes_[c][0], planes_[c][1]};
  return colour;
}

}  // namespace emberline
