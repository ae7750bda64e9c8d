// Tests the memory of the film, both small arrays and arrays in huge pages.
#include "renderer/core/zeroed_array.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace emberline {
namespace {

template <typename T>
bool all_zero(const ZeroedArray<T>& array) {
  return std::all_of(array.begin(), array.end(), [](T value) { return value == T(0); });
}

TEST(ZeroedArray, IsZeroWhenMadeAndAfterEachReset) {
  // 5 million doubles take 38 MiB, which is large enough for huge pages but not a multiple of them.
  for (const size_t size : {size_t(0), size_t(1), size_t(1000), size_t(5'000'001)}) {
    ZeroedArray<double> array;
    array.reset(size);
    EXPECT_EQ(array.size(), size);
    EXPECT_TRUE(all_zero(array)) << size;
    for (const size_t again : {size, size / 2, size}) {
      std::fill(array.begin(), array.end(), 1.0);
      array.reset(again);
      EXPECT_EQ(array.size(), again);
      EXPECT_TRUE(all_zero(array)) << size << " then " << again;
      EXPECT_GE(array.capacity(), size);
    }
  }
}

TEST(ZeroedArray, ClearsNoByteMore) {
  constexpr size_t kBytes = (size_t(9) << 20) + 13;
  std::vector<unsigned char> bytes(kBytes + 2, 7);
  clear_bytes(bytes.data() + 1, kBytes);
  EXPECT_EQ(bytes.front(), 7);
  EXPECT_EQ(bytes.back(), 7);
  EXPECT_EQ(std::count(bytes.begin(), bytes.end(), 0), std::ptrdiff_t(kBytes));
}

}  // namespace
}  // namespace emberline
