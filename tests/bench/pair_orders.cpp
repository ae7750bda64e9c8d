// Searches the orders of samplers/owen_sobol.h and prints their first columns, best first found:
//
//     build/release/bin/pair_orders [COLUMNS]
//
// Wanted are orders in which any two pairs of dimensions are even together, at every power of two
// (tests/support/pair_coupling.h). Column after column, the best of many are kept. A minute.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

#include "support/pair_coupling.h"

namespace emberline {
namespace {

using namespace test;

constexpr int kColumns = owen_sobol::kSearchedColumns;
constexpr int kOrders = owen_sobol::kOrders - 1;  // the pixel's is 0, as it is

// Whose coupling counts how much. Time is a number of its own; X and Y are the pixel's.
enum { kPixel, kFirst, kSecond, kChoice, kLens, kTime, kX, kY };
struct Coupling {
  int a, b;
  double weight;
};
constexpr Coupling kCouplings[] = {
    {kPixel, kFirst, 25},  {kPixel, kLens, 2},    {kPixel, kChoice, 2}, {kPixel, kSecond, 1},
    {kFirst, kSecond, 1},  {kFirst, kChoice, 1},  {kFirst, kLens, 1.5}, {kSecond, kChoice, 0.4},
    {kSecond, kLens, 0.4}, {kChoice, kLens, 0.4}, {kTime, kPixel, 1.5}, {kTime, kX, 3},
    {kTime, kY, 3},        {kTime, kFirst, 1.5},  {kTime, kLens, 0.5},  {kTime, kChoice, 0.3},
    {kTime, kSecond, 0.3}};
constexpr size_t kCouplingCount = std::size(kCouplings);

struct Table {
  std::vector<float> pair, first, second;  // by index
  Table() {
    for (uint32_t i = 0; i < 1u << kColumns; ++i) {
      pair.push_back(float(pair_sum(i)));
      first.push_back(float(first_sum(i)));
      second.push_back(float(second_sum(i)));
    }
  }
};

using Sums = std::array<double, kCouplingCount>;
struct Orders {
  std::array<std::array<uint32_t, kColumns>, kOrders> columns{};
  Sums sums{};  // over the points so far
  double cost = 0;
};

class Search {
 public:
  void run(int columns);

 private:
  const std::vector<float>& of(int what) const {
    return what == kTime || what == kX ? table_.first : what == kY ? table_.second : table_.pair;
  }
  static size_t order(int what) { return what > kTime ? 0 : size_t(what); }
  double random_sum(size_t c) const {
    return double(of(kCouplings[c].a)[0]) * double(of(kCouplings[c].b)[0]);
  }
  void add_points(Orders& o, int m) const;
  double extended_cost(const Orders& before, Orders& o, int m) const;
  void improve(const Orders& before, Orders& o, int m) const;
  void print(const Orders& o) const;

  const Table table_;
  std::mt19937 random_{1};
};

// The points [2^(m-1), 2^m), each one column from the one before (Gray code).
void Search::add_points(Orders& o, int m) const {
  const uint32_t first = 1u << (m - 1);
  std::array<uint32_t, kOrders + 1> index{first};
  for (size_t q = 0; q < size_t(kOrders); ++q) index[q + 1] = o.columns[q][size_t(m - 1)];
  for (uint32_t i = 1; i <= first; ++i) {
    for (size_t c = 0; c < kCouplingCount; ++c) {
      const auto [a, b, weight] = kCouplings[c];
      o.sums[c] += double(of(a)[index[order(a)]] * of(b)[index[order(b)]]);
    }
    const auto column = size_t(std::countr_zero(i));
    if (i == first) break;
    index[0] ^= 1u << column;
    for (size_t q = 0; q < size_t(kOrders); ++q) index[q + 1] ^= o.columns[q][column];
  }
}

double Search::extended_cost(const Orders& before, Orders& o, int m) const {
  o.sums = before.sums;
  add_points(o, m);
  double cost = 0;
  for (size_t c = 0; c < kCouplingCount; ++c) {
    const double ratio = o.sums[c] / random_sum(c);
    cost += kCouplings[c].weight * ratio + std::pow(std::max(0.0, ratio - 1.3), 2) * 2;
  }
  return o.cost = before.cost + cost * (m < 3 ? 0.3 : m > 8 ? 0.7 : 1.0);
}

// One column after the other, while that helps.
void Search::improve(const Orders& before, Orders& o, int m) const {
  const uint32_t first = 1u << (m - 1);
  for (bool better = true; better;) {
    better = false;
    for (size_t q = 0; q < size_t(kOrders); ++q) {
      for (uint32_t low = 0; low < std::min(first, 256u); ++low) {
        Orders other = o;
        other.columns[q][size_t(m - 1)] ^= first > 256u ? (low * (first / 256u)) : low;
        if (other.columns[q][size_t(m - 1)] < first) continue;
        if (extended_cost(before, other, m) < o.cost - 1e-9) {
          o = other;
          better = true;
        }
      }
    }
  }
}

void Search::run(int columns) {
  std::vector<Orders> kept(1);
  for (size_t c = 0; c < kCouplingCount; ++c) kept[0].sums[c] = random_sum(c);
  const auto cheaper = [](const Orders& a, const Orders& b) { return a.cost < b.cost; };
  for (int m = 1; m <= columns; ++m) {
    const uint32_t first = 1u << (m - 1);
    const size_t keep = m <= 6 ? 2500 : m <= 9 ? 200 : 20, tries = m <= 7 ? 1000 : 100;
    std::vector<Orders> next;
    for (const Orders& before : kept) {
      std::vector<Orders> some;
      for (size_t t = 0; t < tries; ++t) {
        Orders o = before;
        for (auto& order : o.columns)
          order[size_t(m - 1)] = first | (uint32_t(random_()) & (first - 1));
        extended_cost(before, o, m);
        some.push_back(o);
      }
      std::ranges::sort(some, cheaper);
      some.resize(m <= 9 ? 6 : 2);
      for (Orders& o : some) improve(before, o, m);
      next.insert(next.end(), some.begin(), some.end());
    }
    std::ranges::sort(next, cheaper);
    const auto same = [](const Orders& a, const Orders& b) { return a.columns == b.columns; };
    const auto [begin, end] = std::ranges::unique(next, same);
    next.erase(begin, end);
    next.resize(std::min(next.size(), keep));
    kept = std::move(next);
    std::printf("2^%d points, variance over that of random numbers:", m);
    for (size_t c = 0; c < kCouplingCount; ++c)
      std::printf(" %.2f", kept[0].sums[c] / random_sum(c));
    std::printf("\n");
    std::fflush(stdout);
  }
  print(kept[0]);
}

void Search::print(const Orders& o) const {
  for (const auto& order : o.columns) {
    for (const uint32_t column : order) std::printf("%u, ", column);
    std::printf("\n");
  }
}

}  // namespace
}  // namespace emberline

int main(int argc, char** argv) {
  const int columns = argc > 1 ? std::atoi(argv[1]) : emberline::kColumns;
  emberline::Search().run(std::clamp(columns, 1, emberline::kColumns));
}
