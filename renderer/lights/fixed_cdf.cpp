#include "renderer/lights/fixed_cdf.h"

#include <algorithm>
#include <cmath>

namespace emberline {

void build_fixed_cdf(std::span<const double> weights, uint32_t* sums, uint32_t* guide) {
  const size_t count = weights.size();
  const int bits = guide_bits(count);
  const size_t cells = size_t(1) << bits;
  double total = 0;
  for (double w : weights) total += w;
  sums[0] = 0;
  if (!(total > 0)) {
    std::fill(sums, sums + count + 1, 0u);
    std::fill(guide, guide + cells + 1, 0u);
    return;
  }
  // The forward pass rounds the sums and gives each positive weight at least one step. The sums may
  // then reach the total too early. So the backward pass lowers them where needed, and again leaves
  // each positive weight at least one step.
  double sum = 0;
  for (size_t i = 0; i < count; ++i) {
    sum += weights[i];
    const double ideal = std::min(sum / total, 1.0) * double(kCdfTotal);
    const uint64_t min_sum = uint64_t(sums[i]) + (weights[i] > 0 ? 1 : 0);
    sums[i + 1] =
        uint32_t(std::min<uint64_t>(std::max(uint64_t(std::llround(ideal)), min_sum), kCdfTotal));
  }
  uint32_t limit = kCdfTotal;
  bool past_last = true;  // whether no positive weight follows entry i
  for (size_t i = count; i-- > 0;) {
    sums[i + 1] = past_last ? kCdfTotal : std::min(sums[i + 1], limit);
    limit = sums[i + 1];
    if (weights[i] > 0) {
      past_last = false;
      --limit;
    }
  }
  // guide[c] is the entry that contains the first value of cell c.
  uint32_t entry = 0;
  for (size_t cell = 0; cell < cells; ++cell) {
    const uint64_t first = uint64_t(cell) << (32 - bits);
    while (entry + 1 < count && sums[entry + 1] <= first) ++entry;
    guide[cell] = entry;
  }
  while (entry + 1 < count && sums[entry + 1] < kCdfTotal) ++entry;
  guide[cells] = entry;
}

}  // namespace emberline
