// Computes sums over an image. They are bit-identical for any number of threads.
#pragma once

#include <cstddef>
#include <vector>

#include "renderer/core/parallel.h"

namespace emberline {

// Returns the sum over all rows. fn(row) returns the sum of a row; these sums are added with +=,
// from the first row to the last.
template <typename Sum, typename Function>
Sum sum_rows(int height, const Function& fn) {
  std::vector<Sum> partial(size_t(height > 0 ? height : 0));
  for_each_row(height, [&](int y) { partial[size_t(y)] = fn(y); });
  Sum total{};
  for (const Sum& row : partial) total += row;
  return total;
}

}  // namespace emberline
