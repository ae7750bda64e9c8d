// Tests drivers without rendering, by listing the work that they request.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>
#include <numeric>
#include <vector>

#include "renderer/core/archive.h"
#include "renderer/core/errors.h"
#include "renderer/core/hash.h"
#include "renderer/drivers/adaptive/error_estimator.h"
#include "renderer/drivers/adaptive/round_parts.h"
#include "renderer/drivers/bucket_schedule.h"
#include "renderer/film/film.h"
#include "support/busy_scene.h"
#include "support/processor_time.h"
#include "support/render.h"

namespace emberline {
namespace {

// Runs a driver and checks its requests. The film gets made-up numbers instead of samples.
class DriverRecord {
 public:
  DriverRecord(const DriverEntry& entry, const Frame& frame, const Rect& pixels,
               const DriverSettings& settings)
      : film_(frame.aovs, entry.film_extras(settings)), seed_(frame.seed) {
    film_.reset(pixels);
    driver_ = entry.create(frame, pixels, settings);
  }

  // Carries out at most `parts` parts, in an order that no thread would use.
  void run_parts(size_t parts) {
    std::vector<PixelWork> list;
    while (parts > 0 && !driver_->finished()) {
      const std::optional<Round> round = driver_->next(film_, {});
      if (!round) break;
      EXPECT_GE(round->pass, pass_);
      pass_ = round->pass;
      const size_t count = std::min(parts, round->parts);
      parts -= count;
      for (size_t part = count; part-- > 0;) {
        list.clear();
        driver_->expand(part, list);
        uint64_t samples = 0;
        for (const PixelWork& work : list) samples += add(work);
        EXPECT_EQ(samples, driver_->samples(part));
        EXPECT_LE(list.size(), 4096u) << "a part is about a millisecond of work";
      }
      const bool complete = count == round->parts;
      driver_->rendered({0, count, complete, {}}, film_);
      if (!complete) break;
    }
    EXPECT_EQ(driver_->min_samples(film_), film_.min_samples());
  }

  // Carries out one part of the current round.
  void run_part(size_t part) {
    std::vector<PixelWork> list;
    driver_->expand(part, list);
    for (const PixelWork& work : list) add(work);
    driver_->rendered({part, part + 1, true, {}}, film_);
  }

  FrameDriver& driver() { return *driver_; }
  void set_driver(std::unique_ptr<FrameDriver> driver) { driver_ = std::move(driver); }
  FilmTile& film() { return film_; }

 private:
  // Checks that each sample comes once and that a pixel's samples come in order.
  uint64_t add(const PixelWork& work) {
    EXPECT_TRUE(film_.rect().contains(work.x, work.y));
    EXPECT_EQ(work.first_sample, film_.sample_count(work.x, work.y));
    EXPECT_GT(work.sample_count, 0u);
    for (uint32_t i = 0; i < work.sample_count; ++i) {
      const uint32_t sample = work.first_sample + i;
      const uint32_t noise = hash_combine(hash_combine(seed_, uint32_t(work.x)),
                                          hash_combine(uint32_t(work.y), sample));
      SampleValue value;
      value.radiance = Rgb(to_unit_float(noise) * float(work.x % 7));
      value.alpha = 1.0f;
      value.rays.scatter = noise % 5;
      film_.add(work.x, work.y, {value});
    }
    return work.sample_count;
  }

  FilmTile film_;
  const uint32_t seed_;
  std::unique_ptr<FrameDriver> driver_;
  int pass_ = 0;
};

class Rounds : public testing::TestWithParam<std::string_view> {
 protected:
  static constexpr int kWidth = 131, kHeight = 67;
  static constexpr uint32_t kSamples = 24;

  Rounds()
      : camera_(test::busy_view(), kWidth, kHeight, scene_->origin(), scene_->scale()),
        plan_(plan()) {
    settings_.adaptive.budget = kSamples;
  }
  static RenderPlan plan() {
    FrameSettings settings;
    settings.integrator = "normal";
    settings.spp = kSamples;
    settings.seed = 3;
    settings.width = kWidth;
    settings.height = kHeight;
    settings.aovs = "stop";
    return RenderPlan(settings);
  }
  Frame frame(const Rect& crop) const {
    Frame frame = plan_.frame(*scene_, camera_);
    frame.crop = crop;
    frame.exact_counts = settings_.adaptive.threshold == 0.0f;
    return frame;
  }
  const DriverEntry& entry() const { return find_driver(GetParam()); }

  const std::unique_ptr<Scene> scene_ = test::busy_scene();
  const Camera camera_;
  const RenderPlan plan_;
  DriverSettings settings_;
};

const Rect kRoundWindows[] = {{0, 0, 131, 67}, {7, 5, 8, 67}, {1, 1, 2, 2}, {3, 60, 131, 61}};

TEST_P(Rounds, AskForEachSampleOnceAndInOrder) {
  for (const float threshold : {0.0f, 0.1f}) {
    settings_.adaptive.threshold = threshold;
    settings_.adaptive.max_samples = 64;
    for (const Rect& crop : kRoundWindows) {
      const Frame whole = frame(crop);
      DriverRecord record(entry(), whole, crop, settings_);
      record.run_parts(std::numeric_limits<size_t>::max());
      EXPECT_TRUE(record.driver().finished());
      record.driver().end(record.film(), PixelStop::kUser);
      uint64_t samples = 0;
      for (size_t i = 0; i < size_t(crop.area()); ++i) {
        const int x = crop.x_of(i), y = crop.y_of(i);
        samples += record.film().sample_count(x, y);
        EXPECT_NE(record.film().stop(x, y), PixelStop::kUser);
        EXPECT_NE(record.film().stop(x, y), PixelStop::kNone);
        EXPECT_EQ(record.film().stop(x, y), record.driver().current_stop(record.film(), x, y));
      }
      if (threshold > 0.0f) continue;
      const double mean = double(samples) / double(crop.area());
      EXPECT_NEAR(mean, kSamples, GetParam() == "adaptive" ? 8.0 : 0.0);
    }
  }
}

// Wherever the frame is cut short, counts are true, the picture is complete, and stop reasons are
// right.
TEST_P(Rounds, AreCorrectWhereverTheyAreCut) {
  const Rect crop = kRoundWindows[0];
  const Frame whole = frame(crop);
  for (size_t parts = 1; parts < 3000; parts += 1 + parts / 3) {
    DriverRecord record(entry(), whole, crop, settings_);
    record.run_parts(parts);
    if (record.driver().finished()) break;
    record.driver().end(record.film(), PixelStop::kTimeLimit);
    std::vector<float> rgba(4 * size_t(crop.area()), std::numeric_limits<float>::quiet_NaN());
    record.driver().resolve(record.film(), rgba, nullptr);
    EXPECT_TRUE(std::ranges::all_of(rgba, [](float v) { return std::isfinite(v); }));
    size_t unfinished = 0;
    for (size_t i = 0; i < size_t(crop.area()); ++i) {
      const int x = crop.x_of(i), y = crop.y_of(i);
      const PixelStop stop = record.film().stop(x, y);
      EXPECT_EQ(stop == PixelStop::kNone, record.film().sample_count(x, y) == 0);
      unfinished += stop == PixelStop::kTimeLimit || stop == PixelStop::kNone;
    }
    EXPECT_GT(unfinished, 0u) << parts;
  }
}

// Carries the rounds out part by part. If `replaced`, a new driver that has loaded the old driver's
// saved state takes over at each boundary between two parts.
FilmTile run_by_parts(const DriverEntry& entry, const Frame& frame, const Rect& pixels,
                      const DriverSettings& settings, bool replaced, std::vector<std::byte>* state,
                      std::string* explanation) {
  DriverRecord record(entry, frame, pixels, settings);
  const auto replace = [&] {
    if (!replaced) return;
    std::vector<std::byte> bytes;
    Archive saving(bytes);
    record.driver().archive(saving, record.film());
    const Round round = record.driver().round();
    record.set_driver(entry.create(frame, pixels, settings));
    Archive loading{std::span<const std::byte>(bytes)};
    record.driver().archive(loading, record.film());
    loading.end();
    EXPECT_EQ(record.driver().round(), round);
  };
  for (replace(); record.driver().next(record.film(), {}); replace()) {
    for (size_t part = 0; part < record.driver().round().parts; ++part) {
      replace();
      record.run_part(part);
    }
  }
  record.driver().end(record.film(), PixelStop::kUser);
  Archive saving(*state);
  record.driver().archive(saving, record.film());
  *explanation = record.driver().explain(record.film(), 5, 3);
  return std::move(record.film());
}

TEST_P(Rounds, ResumeFromEveryBoundaryToTheSameBits) {
  std::vector<DriverSettings> all(4);
  for (DriverSettings& settings : all) settings.adaptive.budget = kSamples;
  all[1].keep_tree = true;
  all[1].explained = {5, 3};
  all[1].bisection_axis = BisectionAxis::kRows;
  all[2].adaptive.unbiased = true;
  all[3].adaptive.threshold = 0.1f;
  all[3].adaptive.max_samples = 64;
  all.push_back(all[3]);
  all.back().adaptive.budget = 0;  // only the threshold and the maximum count end the frame
  for (const EstimatorEntry& estimator : estimator_table()) {
    if (GetParam() == "bisection") break;
    all.push_back(all[GetParam() == "bucket" ? 3 : 0]);
    all.back().adaptive.estimator = estimator.name;
  }
  const Rect crop{3, 2, 52, 35};
  for (const DriverSettings& settings : all) {
    Frame whole = frame(crop);
    whole.exact_counts = settings.adaptive.threshold == 0.0f;
    std::vector<std::byte> state_once, state;
    std::string explained_once, explained;
    const FilmTile once =
        run_by_parts(entry(), whole, crop, settings, false, &state_once, &explained_once);
    const FilmTile replaced =
        run_by_parts(entry(), whole, crop, settings, true, &state, &explained);
    std::vector<float> expected, found;
    once.resolve(expected);
    replaced.resolve(found);
    EXPECT_EQ(found, expected) << settings.adaptive.estimator;
    EXPECT_EQ(explained, explained_once);
    EXPECT_EQ(state, state_once);
  }
}

// A saved state may be damaged. It is then rejected, or the driver requests nothing outside its
// frame.
TEST_P(Rounds, ADamagedStateIsRefusedOrHarmless) {
  const Rect crop{3, 2, 52, 35};
  const Frame whole = frame(crop);
  for (const size_t parts : {2u, 9u, 30u}) {
    DriverRecord record(entry(), whole, crop, settings_);
    record.run_parts(parts);
    std::vector<std::byte> state;
    Archive saving(state);
    record.driver().archive(saving, record.film());
    size_t refused = 0;
    constexpr uint32_t kTrials = 600;
    for (uint32_t trial = 0; trial < kTrials; ++trial) {
      std::vector<std::byte> damaged = state;
      // Half of the trials damage one of the first bytes. The scalars come first and are few
      // compared with the arrays.
      const uint32_t random = hash_combine(trial, uint32_t(parts));
      const size_t at = random % (trial % 2 ? std::min<size_t>(200, state.size()) : state.size());
      if (trial % 10 == 0) {
        damaged.resize(at);
      } else {
        damaged[at] ^= std::byte(1u << (hash32(random) % 8));
      }
      const auto driver = entry().create(whole, crop, settings_);
      try {
        Archive loading{std::span<const std::byte>(damaged)};
        driver->archive(loading, record.film());
        loading.end();
      } catch (const InputError&) {
        ++refused;
        continue;
      }
      ASSERT_LE(driver->round().parts, size_t(crop.area()));
      std::vector<PixelWork> list;
      for (size_t part = 0; part < driver->round().parts; ++part) driver->expand(part, list);
      for (const PixelWork& work : list) {
        ASSERT_TRUE(crop.contains(work.x, work.y));
        ASSERT_LE(work.first_sample + work.sample_count, kMaxSamples);
      }
      std::vector<float> rgba(4 * size_t(crop.area()));
      driver->resolve(record.film(), rgba, nullptr);
    }
    EXPECT_GT(refused, kTrials / 20);
  }
}

INSTANTIATE_TEST_SUITE_P(Drivers, Rounds, testing::Values("bucket", "bisection", "adaptive"),
                         [](const auto& test) { return std::string(test.param); });

TEST(BucketSchedule, CoversEveryPixelOnce) {
  for (const NamedValue<BucketOrder>& order : bucket_order_table()) {
    for (const Rect& crop : {Rect{0, 0, 64, 64}, Rect{0, 0, 1, 1}, Rect{0, 0, 1, 97},
                             Rect{5, 9, 118, 40}, Rect{0, 0, 101, 103}}) {
      for (const int size : {1, 3, 16, 64, 4096}) {
        std::vector<int> hits(size_t(crop.area()), 0);
        for (const Rect& bucket : bucket_schedule(crop, size, order.value, 1)) {
          EXPECT_LE(bucket.width(), size);
          EXPECT_LE(bucket.height(), size);
          for (int y = bucket.y0; y < bucket.y1; ++y) {
            for (int x = bucket.x0; x < bucket.x1; ++x) {
              ASSERT_TRUE(crop.contains(x, y));
              hits[size_t(y - crop.y0) * size_t(crop.width()) + size_t(x - crop.x0)]++;
            }
          }
        }
        for (const int h : hits) ASSERT_EQ(h, 1) << order.name << " size " << size;
      }
    }
  }
  EXPECT_TRUE(bucket_schedule(Rect{}, 16, BucketOrder::kHilbert, 0).empty());
}

// The cost of a schedule grows with the number of its buckets, not with the square around them.
TEST(BucketSchedule, AThinFrameIsScheduledAtOnce) {
  for (const NamedValue<BucketOrder>& order : bucket_order_table()) {
    for (const Rect& crop : {Rect{0, 0, 1, 65536}, Rect{0, 0, 65536, 1}}) {
      const double start = test::processor_seconds();
      EXPECT_EQ(bucket_schedule(crop, 1, order.value, 0).size(), 65536u) << order.name;
      EXPECT_LT(test::processor_seconds() - start, 5.0)
          << order.name;  // takes milliseconds on any machine
    }
  }
}

// On a square whose side is a power of two, each step of the Hilbert curve and of the spiral leads
// to a neighbouring bucket.
TEST(BucketSchedule, HilbertAndSpiralAreConnected) {
  for (const BucketOrder order : {BucketOrder::kHilbert, BucketOrder::kSpiral}) {
    const auto buckets = bucket_schedule({0, 0, 256, 256}, 16, order, 0);
    ASSERT_EQ(buckets.size(), 256u);
    for (size_t i = 1; i < buckets.size(); ++i) {
      const Rect& a = buckets[i - 1];
      const Rect& b = buckets[i];
      EXPECT_EQ(std::abs(a.x0 - b.x0) + std::abs(a.y0 - b.y0), 16) << "step " << i;
    }
  }
}

TEST(BucketSchedule, SpiralStartsInTheMiddleScanlineAtTheTop) {
  const auto spiral = bucket_schedule({0, 0, 160, 160}, 32, BucketOrder::kSpiral, 0);
  EXPECT_EQ(spiral.front(), (Rect{64, 64, 96, 96}));
  const auto scanline = bucket_schedule({0, 0, 160, 160}, 32, BucketOrder::kScanline, 0);
  EXPECT_EQ(scanline.front(), (Rect{0, 0, 32, 32}));
  EXPECT_EQ(scanline[1], (Rect{32, 0, 64, 32}));
}

TEST(BucketSchedule, RandomOrderDependsOnlyOnTheSeed) {
  const Rect crop{0, 0, 512, 512};
  EXPECT_EQ(bucket_schedule(crop, 16, BucketOrder::kRandom, 5),
            bucket_schedule(crop, 16, BucketOrder::kRandom, 5));
  EXPECT_NE(bucket_schedule(crop, 16, BucketOrder::kRandom, 5),
            bucket_schedule(crop, 16, BucketOrder::kRandom, 6));
}

TEST(AdaptiveSchedule, TilesCoverEveryPixelOnceRowByRow) {
  for (const Rect& crop : {Rect{0, 0, 1, 1}, Rect{0, 0, 1, 97}, Rect{5, 9, 118, 40}}) {
    std::vector<int> hits(size_t(crop.area()), 0);
    std::array<int, 4> before = {-1, -1, -1, -1};
    for (const uint32_t i : tile_order(crop)) {
      ASSERT_LT(i, hits.size());
      ++hits[i];
      const int x = int(i) % crop.width(), y = int(i) / crop.width();
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

// cut_into_parts() skips whole blocks of pixels that contain no part boundary.
TEST(AdaptiveSchedule, PartsMatchAPixelByPixelSearch) {
  const std::vector<uint32_t> order = tile_order({0, 0, 83, 47});
  const std::vector<uint32_t> have(order.size(), 3);
  for (const uint64_t samples : {uint64_t(1), uint64_t(40), uint64_t(500), uint64_t(100000)}) {
    for (const uint32_t seldom : {1u, 2u, 50u, 5000u}) {
      std::vector<uint32_t> targets = have;
      for (uint32_t i = 0; i < order.size(); ++i) {
        if (hash32(i) % seldom == 0) targets[i] += 1 + hash32(i + 9) % 30;
      }
      std::vector<size_t> expected = {0};
      uint64_t in_part = 0;
      for (size_t k = 0; k < order.size(); ++k) {
        if (in_part >= samples) expected.push_back(k), in_part = 0;
        in_part += targets[order[k]] - have[order[k]];
      }
      expected.push_back(order.size());
      EXPECT_EQ(cut_into_parts(order, have, targets, samples), expected)
          << samples << ' ' << seldom;
    }
  }
}

TEST(AdaptiveSchedule, LargestGainPerSampleComesFirst) {
  const std::vector<uint32_t> order = {5, 4, 3, 2, 1, 0};
  const std::vector<size_t> parts = {0, 2, 4, 6};  // pixels 5 4, 3 2, 1 0
  const std::vector<uint32_t> have(6, 8), targets = {16, 16, 40, 40, 16, 8};
  // The gain per sample is 2 over 8 in the first part, 8 + 8 over 64 in the second, and 1/8 + 1/8
  // over 16 in the third.
  const std::vector<float> gain = {0.125f, 0.125f, 8.0f, 8.0f, 2.0f, 0.0f};
  EXPECT_EQ(parts_by_gain(parts, order, have, targets, gain), (std::vector<uint32_t>{0, 1, 2}));
  const std::vector<float> opposite = {8.0f, 8.0f, 8.0f, 8.0f, 0.125f, 0.0f};
  EXPECT_EQ(parts_by_gain(parts, order, have, targets, opposite), (std::vector<uint32_t>{2, 1, 0}));
  // Pixels that get no samples come last, whatever they might gain.
  EXPECT_EQ(parts_by_gain(parts, order, have, have, gain).size(), 3u);
}

TEST(AdaptiveSchedule, EqualPartsAreSpreadOverTheFrame) {
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
    EXPECT_EQ(sorted, order);  // each part comes once
    // No two parts of the first eighth are neighbours in the frame.
    for (size_t i = 0; i < count / 8; ++i) {
      for (size_t j = 0; j < i; ++j) EXPECT_GT(std::abs(int(turns[i]) - int(turns[j])), 3);
    }
  }
  EXPECT_TRUE(parts_by_gain(std::vector<size_t>{0}, {}, {}, {}, {}).empty());
}

}  // namespace
}  // namespace emberline
