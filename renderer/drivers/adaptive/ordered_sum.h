// Parallel sums over a crop's pixels. The results do not depend on how threads share the work.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "renderer/core/parallel.h"

namespace emberline {

// Divides [0, count) into fixed parts and adds the results of part_sum(begin, end) in order, with
// +=. Returns a value-initialised sum if count is 0.
template <typename PartSum>
auto ordered_sum(size_t count, const PartSum& part_sum) {
  constexpr size_t kPart = 8192;
  std::vector<decltype(part_sum(size_t{}, size_t{}))> sums((count + kPart - 1) / kPart);
  parallel_each(sums.size(), [&](size_t part) {
    sums[part] = part_sum(part * kPart, std::min(count, (part + 1) * kPart));
  });
  typename decltype(sums)::value_type total{};
  for (const auto& sum : sums) total += sum;
  return total;
}

// Number of separate running values (lanes) per part. With a single running value, loops would not
// vectorise, because compilers may not reorder float additions. Each lane adds at most kPart /
// kSumLanes terms.
inline constexpr size_t kSumLanes = 16;

// Calls body(i, lane) for each i in [begin, end), with lane = (i - begin) % kSumLanes.
template <typename Body>
void for_lanes(size_t begin, size_t end, const Body& body) {
  size_t i = begin;
  for (; i + kSumLanes <= end; i += kSumLanes) {
    for (size_t lane = 0; lane < kSumLanes; ++lane) body(i + lane, lane);
  }
  for (size_t lane = 0; i + lane < end; ++lane) body(i + lane, lane);
}

template <typename Lane>
double sum_of_lanes(const Lane (&lanes)[kSumLanes]) {
  double sum = 0.0;
  for (const Lane lane : lanes) sum += double(lane);
  return sum;
}

}  // namespace emberline
