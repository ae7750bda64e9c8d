// Drivers tested without rendering: their work items cover every pixel exactly once.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>

#include "renderer/core/errors.h"
#include "renderer/drivers/bucket_driver.h"

namespace emberline {
namespace {

TEST(BucketSchedule, CoversEveryPixelOnce) {
  for (const BucketOrderEntry& order : bucket_order_table()) {
    for (const Rect& window : {Rect{0, 0, 64, 64}, Rect{0, 0, 1, 1}, Rect{0, 0, 1, 97},
                               Rect{5, 9, 118, 40}, Rect{0, 0, 101, 103}}) {
      for (const int size : {1, 3, 16, 64, 4096}) {
        std::vector<int> hits(size_t(window.area()), 0);
        for (const WorkItem& item : bucket_schedule(window, size, order.order, 7, 1)) {
          EXPECT_EQ(item.first_sample, 0u);
          EXPECT_EQ(item.sample_count, 7u);
          EXPECT_LE(item.pixels.width(), size);
          EXPECT_LE(item.pixels.height(), size);
          for (int y = item.pixels.y0; y < item.pixels.y1; ++y) {
            for (int x = item.pixels.x0; x < item.pixels.x1; ++x) {
              ASSERT_TRUE(window.contains(x, y));
              hits[size_t(y - window.y0) * size_t(window.width()) + size_t(x - window.x0)]++;
            }
          }
        }
        for (const int h : hits) ASSERT_EQ(h, 1) << order.name << " size " << size;
      }
    }
  }
  EXPECT_TRUE(bucket_schedule(Rect{}, 16, BucketOrder::kHilbert, 1, 0).empty());
}

// The work of making a schedule grows with its buckets, not with the square around them: a frame
// of one column took minutes once.
TEST(BucketSchedule, AThinFrameIsScheduledAtOnce) {
  for (const BucketOrderEntry& order : bucket_order_table()) {
    for (const Rect& window : {Rect{0, 0, 1, 65536}, Rect{0, 0, 65536, 1}}) {
      const auto start = std::chrono::steady_clock::now();
      EXPECT_EQ(bucket_schedule(window, 1, order.order, 1, 0).size(), 65536u) << order.name;
      const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
      EXPECT_LT(taken.count(), 5.0) << order.name;  // milliseconds, on any machine
    }
  }
}

// Hilbert's curve and the spiral go from bucket to neighbouring bucket on a square power of two.
TEST(BucketSchedule, HilbertAndSpiralAreConnected) {
  for (const BucketOrder order : {BucketOrder::kHilbert, BucketOrder::kSpiral}) {
    const auto items = bucket_schedule({0, 0, 256, 256}, 16, order, 1, 0);
    ASSERT_EQ(items.size(), 256u);
    for (size_t i = 1; i < items.size(); ++i) {
      const Rect& a = items[i - 1].pixels;
      const Rect& b = items[i].pixels;
      EXPECT_EQ(std::abs(a.x0 - b.x0) + std::abs(a.y0 - b.y0), 16) << "step " << i;
    }
  }
}

TEST(BucketSchedule, SpiralStartsInTheMiddleScanlineAtTheTop) {
  const auto spiral = bucket_schedule({0, 0, 160, 160}, 32, BucketOrder::kSpiral, 1, 0);
  EXPECT_EQ(spiral.front().pixels, (Rect{64, 64, 96, 96}));
  const auto scanline = bucket_schedule({0, 0, 160, 160}, 32, BucketOrder::kScanline, 1, 0);
  EXPECT_EQ(scanline.front().pixels, (Rect{0, 0, 32, 32}));
  EXPECT_EQ(scanline[1].pixels, (Rect{32, 0, 64, 32}));
}

TEST(BucketSchedule, RandomDependsOnTheSeedAlone) {
  const Rect window{0, 0, 512, 512};
  EXPECT_EQ(bucket_schedule(window, 16, BucketOrder::kRandom, 1, 5),
            bucket_schedule(window, 16, BucketOrder::kRandom, 1, 5));
  EXPECT_NE(bucket_schedule(window, 16, BucketOrder::kRandom, 1, 5),
            bucket_schedule(window, 16, BucketOrder::kRandom, 1, 6));
}

TEST(BucketDriver, RefusesNonsense) {
  EXPECT_THROW(BucketDriver({0, "hilbert"}), UsageError);
  EXPECT_THROW(BucketDriver({5000, "hilbert"}), UsageError);
  try {
    BucketDriver({16, "hilbet"});
    FAIL() << "accepted an unknown order";
  } catch (const UsageError& e) {
    EXPECT_NE(std::string(e.what()).find("hilbert, spiral, scanline, random"), std::string::npos)
        << e.what();
  }
}

}  // namespace
}  // namespace emberline
