// Sums over an image whose value does not depend on the number of threads.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cstddef>
#include <vector>

namespace emberline {

// fn(row) for each row, in parallel.
template <typename Function>
void for_each_row(int height, const Function& fn) {
  tbb::parallel_for(tbb::blocked_range<int>(0, height), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y) fn(y);
  });
}

// fn(row) gives one row's partial result; they are merged with += from the first row to the last.
template <typename Sum, typename Function>
Sum sum_rows(int height, const Function& fn) {
  std::vector<Sum> partial(size_t(height > 0 ? height : 0));
  for_each_row(height, [&](int y) { partial[size_t(y)] = fn(y); });
  Sum total{};
  for (const Sum& row : partial) total += row;
  return total;
}

}  // namespace emberline
