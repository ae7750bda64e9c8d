#include "renderer/drivers/adaptive/round_parts.h"

#include <algorithm>
#include <bit>
#include <functional>

#include "renderer/core/parallel.h"
#include "samplers/owen_sobol.h"

namespace emberline {

std::vector<uint32_t> tile_order(const Rect& crop) {
  constexpr int kTile = 16;
  std::vector<uint32_t> order;
  order.reserve(size_t(crop.area()));
  const int width = crop.width(), height = crop.height();
  for (int tile_y = 0; tile_y < height; tile_y += kTile) {
    for (int tile_x = 0; tile_x < width; tile_x += kTile) {
      for (int y = tile_y; y < std::min(tile_y + kTile, height); ++y) {
        for (int x = tile_x; x < std::min(tile_x + kTile, width); ++x) {
          order.push_back(uint32_t(y) * uint32_t(width) + uint32_t(x));
        }
      }
    }
  }
  return order;
}

std::vector<size_t> cut_into_parts(std::span<const uint32_t> order,
                                   std::span<const uint32_t> current,
                                   std::span<const uint32_t> targets, uint64_t samples) {
  const auto missing = [&](size_t k) { return uint64_t(targets[order[k]] - current[order[k]]); };
  // First all threads sum blocks, so that the serial loop only has to search for the ends of parts.
  constexpr size_t kBlock = 32;
  const size_t count = order.size();
  std::vector<uint64_t> sums((count + kBlock - 1) / kBlock);
  parallel_each(sums.size(), [&](size_t block) {
    const size_t end = std::min(count, (block + 1) * kBlock);
    for (size_t k = block * kBlock; k < end; ++k) sums[block] += missing(k);
  });
  std::vector<size_t> parts = {0};
  uint64_t in_part = 0;
  for (size_t block = 0; block < sums.size(); ++block) {
    if (in_part + sums[block] < samples) {
      in_part += sums[block];
      continue;
    }
    const size_t end = std::min(count, (block + 1) * kBlock);
    for (size_t k = block * kBlock; k < end; ++k) {
      if (in_part >= samples) {
        parts.push_back(k);
        in_part = 0;
      }
      in_part += missing(k);
    }
  }
  if (!order.empty()) parts.push_back(order.size());
  return parts;
}

std::vector<uint32_t> parts_by_gain(std::span<const size_t> parts, std::span<const uint32_t> order,
                                    std::span<const uint32_t> current,
                                    std::span<const uint32_t> targets,
                                    std::span<const float> gain) {
  const size_t count = parts.size() - 1;
  std::vector<double> rates(count);
  parallel_each(count, [&](size_t part) {
    double sum = 0;
    uint64_t samples = 0;
    for (size_t k = parts[part]; k < parts[part + 1]; ++k) {
      const size_t i = order[k];
      sum += double(gain[i]);
      samples += targets[i] - current[i];
    }
    rates[part] = samples > 0 ? sum / double(samples) : 0.0;
  });
  std::vector<uint32_t> sorted;
  sorted.reserve(count);
  const auto bits = uint32_t(std::bit_width(count));
  for (uint32_t i = 0; sorted.size() < count; ++i) {  // van der Corput's order
    const uint32_t part = bits > 0 ? owen_sobol::reverse_bits(i) >> (32 - bits) : 0;
    if (part < count) sorted.push_back(part);
  }
  std::ranges::stable_sort(sorted, std::ranges::greater(), [&](uint32_t p) { return rates[p]; });
  return sorted;
}

}  // namespace emberline
