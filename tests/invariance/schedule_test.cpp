// Drivers tested without rendering: their work items cover every pixel exactly once.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <numeric>
#include <vector>

#include "renderer/core/errors.h"
#include "renderer/core/hash.h"
#include "renderer/drivers/adaptive_driver.h"
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

TEST(AdaptiveSchedule, TilesCoverEveryPixelOnceRowByRow) {
  for (const Rect& window : {Rect{0, 0, 1, 1}, Rect{0, 0, 1, 97}, Rect{5, 9, 118, 40}}) {
    std::vector<int> hits(size_t(window.area()), 0);
    std::array<int, 4> before = {-1, -1, -1, -1};
    for (const uint32_t i : tile_order(window)) {
      ASSERT_LT(i, hits.size());
      ++hits[i];
      const int x = int(i) % window.width(), y = int(i) / window.width();
      const std::array<int, 4> place = {y / 16, x / 16, y % 16, x % 16};
      EXPECT_LT(before, place);
      before = place;
    }
    for (const int h : hits) ASSERT_EQ(h, 1);
  }
}

TEST(AdaptiveSchedule, PartsHoldAllWorkInEqualPieces) {
  const std::vector<uint32_t> order = tile_order({0, 0, 40, 30});
  std::vector<uint32_t> have(order.size()), targets(order.size());
  for (uint32_t i = 0; i < order.size(); ++i) {
    have[i] = hash32(i) % 20;
    targets[i] = have[i] + hash32(i + 7000) % 30;
  }
  const std::vector<size_t> parts = cut_into_parts(order, have, targets, 500);
  ASSERT_EQ(parts.front(), 0u);
  ASSERT_EQ(parts.back(), order.size());
  for (size_t p = 0; p + 1 < parts.size(); ++p) {
    ASSERT_LT(parts[p], parts[p + 1]);
    uint64_t samples = 0;
    for (size_t k = parts[p]; k < parts[p + 1]; ++k) samples += targets[order[k]] - have[order[k]];
    EXPECT_LT(samples, 530u);
    if (p + 2 < parts.size()) {
      EXPECT_GE(samples, 500u);
    }
  }
  EXPECT_EQ(cut_into_parts({}, {}, {}, 500).size(), 1u);
}

TEST(AdaptiveSchedule, WhatGainsMostForItsSamplesComesFirst) {
  const std::vector<uint32_t> order = {5, 4, 3, 2, 1, 0};
  const std::vector<size_t> parts = {0, 2, 4, 6};  // pixels 5 4, 3 2, 1 0
  const std::vector<uint32_t> have(6, 8), targets = {16, 16, 40, 40, 16, 8};
  // Of one sample: 1/8 + 1/8 over 16, then 8 + 8 over 64, then 2 over 8.
  const std::vector<float> gain = {0.125f, 0.125f, 8.0f, 8.0f, 2.0f, 0.0f};
  EXPECT_EQ(parts_by_gain(parts, order, have, targets, gain), (std::vector<uint32_t>{0, 1, 2}));
  const std::vector<float> opposite = {8.0f, 8.0f, 8.0f, 8.0f, 0.125f, 0.0f};
  EXPECT_EQ(parts_by_gain(parts, order, have, targets, opposite), (std::vector<uint32_t>{2, 1, 0}));
  // Pixels that get nothing come last, whatever they might gain.
  EXPECT_EQ(parts_by_gain(parts, order, have, have, gain).size(), 3u);
}

TEST(AdaptiveSchedule, EqualPartsComeSpreadOverTheFrame) {
  for (const size_t count : {1u, 2u, 7u, 64u, 100u}) {
    std::vector<size_t> parts(count + 1);
    std::iota(parts.begin(), parts.end(), size_t{0});
    std::vector<uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0u);
    const std::vector<uint32_t> have(count, 1), targets(count, 8);
    const std::vector<uint32_t> turns =
        parts_by_gain(parts, order, have, targets, std::vector<float>(count, 0.0f));
    ASSERT_EQ(turns.size(), count);
    std::vector<uint32_t> sorted = turns;
    std::ranges::sort(sorted);
    EXPECT_EQ(sorted, order);  // each once
    // Of the first eighth, no two are neighbours.
    for (size_t i = 0; i < count / 8; ++i) {
      for (size_t j = 0; j < i; ++j) EXPECT_GT(std::abs(int(turns[i]) - int(turns[j])), 3);
    }
  }
  EXPECT_TRUE(parts_by_gain(std::vector<size_t>{0}, {}, {}, {}, {}).empty());
}

}  // namespace
}  // namespace emberline
