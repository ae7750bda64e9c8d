// Tests the contract of samplers/sampler.h for every row of the table, so that new samplers are
// tested automatically. Thresholds have a false-alarm rate of about 1e-6 per assertion. Seeds are
// fixed.
#include "samplers/sampler.h"

#include <gtest/gtest.h>

#include <cstring>
#include <iostream>
#include <string>
#include <tuple>
#include <vector>

#include "renderer/core/constants.h"
#include "renderer/core/errors.h"
#include "samplers/pixel_samples.h"
#include "support/processor_time.h"
#include "unit/sample_statistics.h"
#include "unit/table_names.h"

namespace emberline {
namespace {

class EverySampler : public testing::TestWithParam<std::tuple<std::string, StreamCount>> {
 protected:
  std::string name() const { return std::get<0>(GetParam()); }
  StreamCount streams() const { return std::get<1>(GetParam()); }
  // The frame covers all of the tests' pixels, for samplers that distribute their error over it.
  std::unique_ptr<Sampler> make() const {
    return create_sampler(
        name(), {.streams = streams(), .samples_per_pixel = 64, .width = 256, .height = 256});
  }
};

INSTANTIATE_TEST_SUITE_P(Table, EverySampler,
                         testing::Combine(testing::ValuesIn(test::names_of(sampler_table())),
                                          testing::Values(StreamCount::kOne, StreamCount::kTwo)),
                         [](const auto& test) {
                           return std::get<0>(test.param) +
                                  (std::get<1>(test.param) == StreamCount::kOne ? "One" : "Two");
                         });

// Law 1: a sample's numbers do not depend on other samples, and a fill writes only its own lanes.
TEST_P(EverySampler, BatchesDoNotChangeTheNumbers) {
  const auto sampler = make();
  const uint32_t firsts[] = {0, 16, 4080, 1u << 20, 0x7ffffff0u, 0x80000000u, 0xfffffff0u};
  for (const uint32_t first : firsts) {
    for (const uint32_t slot : {0u, 1u, 2u, 5u, 1000u}) {
      const PixelKey pixel{first % 97, slot, 3};
      SlotBlock whole;
      sampler->fill(pixel, slot, first, kSampleLanes, whole);
      for (int begin = 0; begin < kSampleLanes; ++begin) {
        for (int count = 1; begin + count <= kSampleLanes; ++count) {
          SlotBlock part;
          std::memset(&part, 0xff, sizeof part);  // NaNs
          sampler->fill(pixel, slot, first + uint32_t(begin), count, part);
          for (int d = 0; d < kSlotDimensions; ++d) {
            for (int lane = 0; lane < kSampleLanes; ++lane) {
              const bool inside = lane >= begin && lane < begin + count;
              if (inside) {
                ASSERT_EQ(part.values[d][lane], whole.values[d][lane])
                    << where(name(), pixel, slot, first + uint32_t(lane)) << ", dimension " << d;
              } else {
                ASSERT_TRUE(std::isnan(part.values[d][lane])) << "lane " << lane << " was touched";
              }
            }
          }
        }
      }
    }
  }
}

TEST_P(EverySampler, TwoInstancesAgree) {
  const auto a = make(), b = make();
  for (uint32_t i = 0; i < 200; ++i) {
    SlotBlock x, y;
    a->fill({i, 2 * i, 3 * i}, i % 9, 16 * i, kSampleLanes, x);
    b->fill({7, 7, 7}, 0, 0, kSampleLanes, y);  // no state may remain
    b->fill({i, 2 * i, 3 * i}, i % 9, 16 * i, kSampleLanes, y);
    ASSERT_EQ(std::memcmp(&x, &y, sizeof x), 0) << where(name(), {i, 2 * i, 3 * i}, i % 9, 16 * i);
  }
}

TEST_P(EverySampler, NumbersAreInTheHalfOpenInterval) {
  const auto sampler = make();
  for (uint32_t i = 0; i < 50000; ++i) {
    // The indices cover the whole range, with all bit lengths up to 32.
    const uint32_t first = (hash32(i) >> (i % 32)) & ~15u;
    SlotBlock block;
    sampler->fill({i, i >> 8, i & 3}, i % 5, first, kSampleLanes, block);
    for (int d = 0; d < kSlotDimensions; ++d) {
      for (int lane = 0; lane < kSampleLanes; ++lane) {
        const float u = block.values[d][lane];
        ASSERT_TRUE(u >= 0.0f && u <= kOneMinusEpsilon)  // also false for NaN
            << u << ", " << where(name(), {i, i >> 8, i & 3}, i % 5, first + uint32_t(lane));
      }
    }
  }
}

// Takes one sample from each of 65536 pixels, whose numbers are independent.
TEST_P(EverySampler, MarginalsAreUniform) {
  const auto sampler = make();
  for (const uint32_t sample : {0u, 5u, 8u, 100000u}) {
    for (const uint32_t slot : {0u, 1u, 12u}) {
      std::vector<std::vector<uint32_t>> counts(kSlotDimensions, std::vector<uint32_t>(64));
      for (uint32_t p = 0; p < 65536; ++p) {
        const SlotNumbers n = read_sample(*sampler, {p & 255u, p >> 8, 1}, slot, sample);
        for (int d = 0; d < kSlotDimensions; ++d) ++counts[d][size_t(n.u[d] * 64.0f)];
      }
      for (int d = 0; d < kSlotDimensions; ++d) {
        EXPECT_LT(chi_square(counts[d]), chi_square_limit(63))
            << "sample " << sample << " slot " << slot << " dimension " << d;
      }
    }
  }
}

// The low bits are also uniform. The last byte of a float's 24 bits has 256 cells.
TEST_P(EverySampler, LowBitsAreUniform) {
  const auto sampler = make();
  std::vector<uint32_t> counts(256);
  for (uint32_t p = 0; p < 4000; ++p) {
    for_each_sample(*sampler, {p, 1, 1}, p % 4, 32, [&](uint32_t, const SlotNumbers& n) {
      ++counts[size_t(n.u[p % kSlotDimensions] * 0x1p24f) & 255u];
    });
  }
  EXPECT_LT(chi_square(counts), chi_square_limit(255));
}

double correlation(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;  // both are uniform, with mean 1/2 and variance 1/12
  for (size_t i = 0; i < a.size(); ++i) sum += (a[i] - 0.5) * (b[i] - 0.5);
  return 12.0 * sum / double(a.size());
}

// Any two numbers of a pixel are uncorrelated over pixels: those of different dimensions, slots and
// samples of both streams, and those of neighbouring pixels and seeds. The limit |r| < 5/sqrt(N)
// has a false-alarm rate of 6e-7 per pair.
TEST_P(EverySampler, NumbersAreUncorrelatedOverPixels) {
  const auto sampler = make();
  constexpr uint32_t kPixels = 10000;
  std::vector<std::vector<float>> columns;
  std::vector<std::string> labels;
  const auto add = [&](uint32_t slot, uint32_t sample, uint32_t dx, uint32_t dseed) {
    std::vector<std::vector<float>> block(kSlotDimensions, std::vector<float>(kPixels));
    for (uint32_t p = 0; p < kPixels; ++p) {
      const SlotNumbers n = read_sample(*sampler, {p % 100 + dx, p / 100, 4 + dseed}, slot, sample);
      for (int d = 0; d < kSlotDimensions; ++d) block[d][p] = n.u[d];
    }
    for (int d = 0; d < kSlotDimensions; ++d) {
      columns.push_back(std::move(block[d]));
      labels.push_back("slot " + std::to_string(slot) + " sample " + std::to_string(sample) +
                       " dx " + std::to_string(dx) + " dseed " + std::to_string(dseed) +
                       " dimension " + std::to_string(d));
    }
  };
  add(0, 0, 0, 0);
  add(1, 0, 0, 0);
  add(2, 0, 0, 0);
  add(0, 0, 0, 1);
  add(0, 0, 1000, 0);
  if (streams() == StreamCount::kTwo || name() == "independent") add(0, 8, 0, 0);
  for (size_t i = 0; i < columns.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      EXPECT_LT(std::abs(correlation(columns[i], columns[j])), 5.0 / std::sqrt(double(kPixels)))
          << labels[i] << " against " << labels[j];
    }
  }
}

// Neighbouring pixels and seeds use different scrambles, so 16 samples share at most a stray
// number.
TEST_P(EverySampler, PixelsSeedsAndSlotsDiffer) {
  const auto sampler = make();
  SlotBlock reference;
  sampler->fill({10, 20, 30}, 1, 0, kSampleLanes, reference);
  const std::pair<PixelKey, uint32_t> others[] = {{{11, 20, 30}, 1},
                                                  {{10, 21, 30}, 1},
                                                  {{10, 20, 31}, 1},
                                                  {{20, 10, 30}, 1},
                                                  {{10, 20, 30}, 2}};
  for (const auto& [pixel, slot] : others) {
    SlotBlock block;
    sampler->fill(pixel, slot, 0, kSampleLanes, block);
    int equal = 0;
    for (int d = 0; d < kSlotDimensions; ++d) {
      for (int lane = 0; lane < kSampleLanes; ++lane) {
        equal += block.values[d][lane] == reference.values[d][lane];
      }
    }
    EXPECT_LE(equal, 1) << where(name(), pixel, slot, 0);
  }
}

// PixelSamples returns the sampler's numbers, cached or not, in any order of samples and slots.
TEST_P(EverySampler, PixelSamplesReadsTheSameNumbers) {
  const auto sampler = make();
  PixelSamples samples(*sampler);
  const PixelKey pixel{3, 4, 5};
  samples.start_batch(pixel, 18, 9);
  for (const uint32_t sample : {20u, 18u, 26u, 20u}) {
    samples.start_sample(int(sample) - 18);
    for (const uint32_t slot : {0u, 3u, 7u, 8u, 40u, 1u, 2u}) {
      samples.start_slot(slot);
      const SlotNumbers expected = read_sample(*sampler, pixel, slot, sample);
      for (int d = 0; d < kSlotDimensions; ++d) ASSERT_EQ(samples.get(d), expected.u[d]);
    }
  }
}

// A batch of samples from many pixels gets the same numbers as each sample alone, in every slot,
// and the same extra numbers.
TEST_P(EverySampler, ScatteredBatchesReadTheSameNumbers) {
  const auto sampler = make();
  std::vector<SampleAddress> addresses;
  for (uint32_t i = 0; i < 13; ++i) {
    addresses.push_back({100 + i / 2, 7 * (i % 3), i < 5 ? i * i : 1u << (2 * i)});
  }
  PixelSamples together(*sampler), alone(*sampler);
  together.start_batch(addresses, 5);
  for (const int i : {3, 0, 12, 7, 3}) {
    const SampleAddress& a = addresses[size_t(i)];
    together.start_sample(i);
    alone.start_batch({a.x, a.y, 5}, a.sample, 1);
    alone.start_sample(0);
    for (const uint32_t slot : {0u, 3u, 7u, 8u, 40u, 1u, 2u}) {
      together.start_slot(slot);
      alone.start_slot(slot);
      for (int d = 0; d < kSlotDimensions; ++d) {
        ASSERT_EQ(together.get(d), alone.get(d)) << name() << ", lane " << i << ", slot " << slot;
      }
      ASSERT_EQ(together.extra_bits(), alone.extra_bits());
      const CoverageKey of_one = together.coverage_key(), of_other = alone.coverage_key();
      ASSERT_TRUE(of_one.seed == of_other.seed && of_one.index == of_other.index);
      ASSERT_EQ(together.extra_bits(), alone.extra_bits());
    }
  }
}

// The same holds for whole blocks of eight, which may be filled together, and for blocks that are
// almost whole.
TEST_P(EverySampler, ScatteredBlocksReadTheSameNumbers) {
  const auto sampler = make();
  const auto eight = [](uint32_t x, uint32_t y, uint32_t first) {
    std::vector<SampleAddress> list;
    for (uint32_t i = 0; i < 8; ++i) list.push_back({x, y, first + i});
    return list;
  };
  const auto both = [](std::vector<SampleAddress> a, const std::vector<SampleAddress>& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
  };
  std::vector<SampleAddress> swapped = both(eight(3, 9, 16), eight(4, 9, 16));
  std::swap(swapped[2], swapped[13]);
  PixelSamples together(*sampler), alone(*sampler);
  for (const std::vector<SampleAddress>& addresses :
       {eight(5, 6, 8), eight(5, 6, 4), both(eight(5, 6, 8), eight(6, 6, 8)),
        both(eight(5, 6, 24), eight(9, 1, 16)), both(eight(5, 6, 8), eight(6, 6, 9)), swapped}) {
    together.start_batch(addresses, 5);
    for (int i = 0; i < int(addresses.size()); ++i) {
      const SampleAddress& a = addresses[size_t(i)];
      together.start_sample(i);
      alone.start_batch({a.x, a.y, 5}, a.sample, 1);
      alone.start_sample(0);
      for (const uint32_t slot : {0u, 1u, 2u, 3u, 40u}) {
        together.start_slot(slot);
        alone.start_slot(slot);
        for (int d = 0; d < kSlotDimensions; ++d) {
          ASSERT_EQ(together.get(d), alone.get(d)) << name() << ", lane " << i << ", slot " << slot;
        }
      }
    }
  }
}

// Prints the speed for tests/bench/results, and fails if the batch no longer vectorises. The tested
// ratio does not depend on the load of the machine.
TEST_P(EverySampler, BatchIsMuchCheaperThanItsSamples) {
  const auto sampler = make();
  SlotBlock block;
  float sum = 0;
  double best[2] = {1e9, 1e9};
  for (int repeat = 0; repeat < 15; ++repeat) {
    for (const int which : {0, 1}) {
      constexpr uint32_t kFills = 4000;
      const double start = test::processor_seconds();
      for (uint32_t i = 0; i < kFills; ++i) {
        sampler->fill({i % 64, i / 64, 7}, 1, (i & 63u) * 16, which == 0 ? kSampleLanes : 1, block);
        sum += block.values[i % 8][0];
      }
      best[which] = std::min(best[which], 1e9 * (test::processor_seconds() - start) / kFills);
    }
  }
  std::cout << "[ measured ] " << name() << ", 8 dimensions: " << best[0] << " ns for 16 samples ("
            << best[0] / 64 << " ns per 2D point), " << best[1] << " ns for one sample\n";
  EXPECT_GT(sum, 0.0f);
#if defined(__OPTIMIZE__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  EXPECT_LT(best[0], 8 * best[1]);
#endif
}

TEST(SamplerTable, UnknownNameListsTheValidOnes) {
  try {
    create_sampler("sobel", {});
    FAIL() << "accepted an unknown name";
  } catch (const UsageError& error) {
    std::string valid;
    for (const std::string& name : test::names_of(sampler_table()))
      valid += (valid.empty() ? "" : ", ") + name;
    EXPECT_EQ(error.what(),
              "sampler: unknown sampler 'sobel' (did you mean 'sobol'?); "
              "valid names are " +
                  valid);
    EXPECT_EQ(error.exit_code(), kExitUsage);
  }
  EXPECT_THROW(create_sampler("", {}), UsageError);
  EXPECT_THROW(create_sampler("Sobol", {}), UsageError);
}

// If a sampler weights its points, the first of three has a weight other than 1.
TEST(SamplerTable, SaysWhichSamplersWeighTheirPoints) {
  for (const SamplerEntry& entry : sampler_table()) {
    const float weight = entry.create({StreamCount::kOne, 4, 8, 8})->integration_weight(0, 3);
    EXPECT_EQ(weight != 1.0f, entry.weighted) << entry.name;
  }
}

}  // namespace
}  // namespace emberline
