// Searches for the orders of samplers/owen_sobol.h, and prints the first columns of the best
// orders:
//
//     build/release/bin/pair_orders [COLUMNS]
//
// Good orders make any two pairs of dimensions jointly uniform at every power of two, and also any
// number of one pair with any number of another (tests/support/pair_coupling.h). Each combination
// has a weight, which says how much its uniformity matters. With few samples, there are fewer ways
// to split the samples into halves than there are numbers. So the first digits of some numbers must
// agree with those of others; the search chooses combinations of low weight for this. It is a beam
// search over columns and takes minutes.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

#include "renderer/core/vector.h"
#include "support/pair_coupling.h"

namespace emberline {
namespace {

using namespace test;

constexpr int kColumns = owen_sobol::kSearchedColumns;
constexpr int kOrders = owen_sobol::kOrders - 1;  // the pixel's order is always 0

enum { kPixel, kFirst, kSecond, kChoice, kLens, kTime };
enum Part { kBoth, kX, kY };  // of a pair; time has only x

// The weight of two pairs, and the cost if a number of one pair copies a number of the other pair.
struct Weight {
  int a, b;
  double pairs, copies;
};
constexpr Weight kWeights[] = {
    {kPixel, kFirst, 25, 3},    {kPixel, kLens, 2, 1},        {kPixel, kChoice, 2, 1},
    {kPixel, kSecond, 1, 0.7},  {kFirst, kSecond, 1, 0.7},    {kFirst, kChoice, 1, 3},
    {kFirst, kLens, 1.5, 0.7},  {kSecond, kChoice, 0.4, 0.2}, {kSecond, kLens, 0.4, 0.03},
    {kChoice, kLens, 0.4, 0.1}, {kPixel, kTime, 3, 1},        {kFirst, kTime, 1.5, 0.3},
    {kLens, kTime, 0.5, 0.1},   {kChoice, kTime, 0.3, 0.05},  {kSecond, kTime, 0.3, 0.03}};

struct Coupling {
  size_t a, b;
  Part part_a, part_b;
  double weight, copy_weight;
};

std::vector<Coupling> couplings() {
  std::vector<Coupling> list;
  for (const auto& [a, b, pairs, copies] : kWeights) {
    const bool time = b == kTime;
    list.push_back({size_t(a), size_t(b), kBoth, time ? kX : kBoth, pairs, 0});
    for (const Part x : {kX, kY}) {
      list.push_back({size_t(a), size_t(b), x, kX, 0, copies});
      if (!time) list.push_back({size_t(a), size_t(b), x, kY, 0, copies});
    }
  }
  return list;
}

struct Orders {
  std::array<std::array<uint32_t, kColumns>, kOrders> columns{};
  std::vector<double> sums;  // of each coupling over the points so far
  double cost = 0;
};

class Search {
 public:
  Search() {
    for (uint32_t i = 0; i < 1u << kColumns; ++i) {
      parts_[kBoth].push_back(float(pair_sum(i)));
      parts_[kX].push_back(float(first_sum(i)));
      parts_[kY].push_back(float(second_sum(i)));
    }
  }
  void run(int columns);

 private:
  double random_sum(const Coupling& c) const {
    return double(parts_[c.part_a][0]) * double(parts_[c.part_b][0]);
  }
  void add_points(Orders& o, int m) const;
  double extended_cost(const Orders& before, Orders& o, int m) const;
  void improve(const Orders& before, Orders& o, int m) const;
  void print(const Orders& o) const;

  const std::vector<Coupling> couplings_ = couplings();
  std::vector<float> parts_[3];  // by index
  std::mt19937 random_{1};
};

// Adds the points [2^(m-1), 2^m). Each point is one column away from the point before it (Gray
// code).
void Search::add_points(Orders& o, int m) const {
  const uint32_t first = 1u << (m - 1);
  std::array<uint32_t, kOrders + 1> index{first};
  for (size_t q = 0; q < size_t(kOrders); ++q) index[q + 1] = o.columns[q][size_t(m - 1)];
  for (uint32_t i = 1; i <= first; ++i) {
    for (size_t k = 0; k < couplings_.size(); ++k) {
      const Coupling& c = couplings_[k];
      o.sums[k] += double(parts_[c.part_a][index[c.a]] * parts_[c.part_b][index[c.b]]);
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
  for (size_t k = 0; k < couplings_.size(); ++k) {
    const Coupling& c = couplings_[k];
    const double ratio = o.sums[k] / random_sum(c);
    cost += c.weight * ratio + (m < 3 ? 0.0 : c.copy_weight * square(std::max(0.0, ratio - 1.5)));
  }
  return o.cost = before.cost + cost * (m < 3 ? 0.3 : m > 8 ? 0.7 : 1.0);
}

// Improves one column after another until no change helps.
void Search::improve(const Orders& before, Orders& o, int m) const {
  const uint32_t first = 1u << (m - 1);
  for (bool better = true; better;) {
    better = false;
    for (size_t q = 0; q < size_t(kOrders); ++q) {
      for (uint32_t low = 0; low < std::min(first, 256u); ++low) {
        Orders other = o;
        other.columns[q][size_t(m - 1)] ^= first > 256u ? (low * (first / 256u)) : low;
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
  for (const Coupling& c : couplings_) kept[0].sums.push_back(random_sum(c));
  const auto cheaper = [](const Orders& a, const Orders& b) { return a.cost < b.cost; };
  for (int m = 1; m <= columns; ++m) {
    const uint32_t first = 1u << (m - 1);
    const size_t keep = m <= 6 ? 1000 : m <= 9 ? 100 : 10, tries = m <= 7 ? 500 : 100;
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
    for (size_t k = 0; k < couplings_.size(); ++k) {
      const bool pairs = couplings_[k].part_a == kBoth;
      std::printf(pairs ? "  %.2f:" : " %.1f", kept[0].sums[k] / random_sum(couplings_[k]));
    }
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
