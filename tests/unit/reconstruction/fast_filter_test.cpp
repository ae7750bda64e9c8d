#include "renderer/reconstruction/fast_filter.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

namespace emberline::test {
namespace {

// A frame whose pixels are a true value plus noise of known variance.
struct Frame {
  int width, height;
  std::vector<float> rgba, albedo, normal, nearness, samples, variance;

  Frame(int w, int h, float value = 0.5f)
      : width(w),
        height(h),
        rgba(4 * size_t(w) * size_t(h), value),
        albedo(size_t(w) * size_t(h), 0.5f),
        normal(albedo.size(), 1.0f),
        nearness(albedo.size(), 0.1f),
        samples(albedo.size(), 4.0f),
        variance(albedo.size(), 0.0f) {}

  size_t at(int x, int y) const { return size_t(y) * size_t(width) + size_t(x); }
  void set(size_t i, float value) { std::fill_n(&rgba[4 * i], 3, value); }

  void add_noise(float deviation, uint32_t seed = 1) {
    std::mt19937 random(seed);
    std::normal_distribution<float> noise(0.0f, deviation);
    for (size_t i = 0; i < albedo.size(); ++i) {
      set(i, rgba[4 * i] + noise(random));
      variance[i] = deviation * deviation;
    }
  }

  std::vector<float> filtered(int levels = 4) const {
    FastFilter filter;
    return filtered(filter, levels);
  }

  std::vector<float> filtered(FastFilter& filter, int levels = 4) const {
    std::vector<float> out(rgba.size());
    filter.filter(
        width, height, rgba,
        [&](int y, const FeatureRow& row) {
          for (int x = 0; x < width; ++x) {
            const size_t i = at(x, y);
            for (float* a : row.albedo) a[x] = albedo[i];
            row.normal[0][x] = normal[i];
            row.normal[1][x] = row.normal[2][x] = 0.0f;
            row.nearness[x] = nearness[i];
            row.samples[x] = samples[i];
            row.variance[x] = variance[i];
          }
        },
        levels, out);
    return out;
  }
};

double squared_error(const Frame& frame, const std::vector<float>& rgba, float truth) {
  double sum = 0.0;
  for (size_t i = 0; i < rgba.size(); i += 4)
    sum += double(rgba[i] - truth) * double(rgba[i] - truth);
  return sum / double(frame.albedo.size());
}

TEST(FastFilter, KeepsAConstantPicture) {
  for (const float variance : {-1.0f, 0.0f, 1.0f}) {
    Frame frame(70, 33);
    for (float& v : frame.variance) v = variance;
    const std::vector<float> out = frame.filtered();
    for (size_t i = 0; i < out.size(); ++i) ASSERT_NEAR(out[i], frame.rgba[i], 1e-6f) << i;
  }
}

TEST(FastFilter, KeepsANoiselessPicture) {
  Frame frame(70, 33);
  for (size_t i = 0; i < frame.albedo.size(); ++i) {
    frame.set(i, float((i * 7919) % 97) / 97.0f);
    frame.rgba[4 * i + 3] = 0.25f;
  }
  const std::vector<float> out = frame.filtered();
  for (size_t i = 0; i < out.size(); ++i) ASSERT_NEAR(out[i], frame.rgba[i], 1e-6f) << i;
}

// The share of the variance of independent noise that remains after `levels` levels of [1 2 1] / 4,
// at strides of 1, 2, 4 and so on, in two dimensions.
double kernel_residual(int levels) {
  std::vector<double> kernel = {1.0};
  for (int level = 0; level < levels; ++level) {
    const size_t stride = size_t(1) << level;
    std::vector<double> wider(kernel.size() + 2 * stride);
    for (size_t i = 0; i < kernel.size(); ++i) {
      wider[i] += 0.25 * kernel[i];
      wider[i + stride] += 0.5 * kernel[i];
      wider[i + 2 * stride] += 0.25 * kernel[i];
    }
    kernel = wider;
  }
  double squares = 0.0;
  for (const double k : kernel) squares += k * k;
  return squares * squares;
}

TEST(FastFilter, NoiseThatTellsNothingFallsAsTheKernelHasIt) {
  Frame frame(512, 256);
  frame.add_noise(0.1f);
  const double raw = squared_error(frame, frame.rgba, 0.5f);
  for (float& v : frame.variance) v *= 100.0f;  // so that differences are far below it
  for (int levels = 1; levels <= 4; ++levels) {
    const double left = squared_error(frame, frame.filtered(levels), 0.5f) / raw;
    EXPECT_NEAR(left / kernel_residual(levels), 1.0, 0.15) << levels;
  }
}

// The weights by brightness reduce the gain of the kernel.
TEST(FastFilter, NoiseOnAPlaneFalls) {
  Frame frame(256, 128);
  frame.add_noise(0.1f);
  EXPECT_LT(squared_error(frame, frame.filtered(), 0.5f),
            0.08 * squared_error(frame, frame.rgba, 0.5f));
}

TEST(FastFilter, OneSampleAPixelIsJudgedByItsNeighbours) {
  Frame frame(256, 128);
  frame.add_noise(0.1f);
  for (float& v : frame.variance) v = -1.0f;
  EXPECT_LT(squared_error(frame, frame.filtered(), 0.5f),
            0.02 * squared_error(frame, frame.rgba, 0.5f));
}

// The step is as high as the noise, so brightness alone does not reveal it.
TEST(FastFilter, EdgesOfFeaturesStay) {
  for (std::vector<float> Frame::*feature : {&Frame::normal, &Frame::nearness}) {
    Frame frame(96, 64);
    for (size_t i = 0; i < frame.albedo.size(); ++i) {
      const bool right = i % 96 >= 48;
      frame.set(i, right ? 0.6f : 0.5f);
      if (right) (frame.*feature)[i] *= feature == &Frame::normal ? -1.0f : 2.0f;
    }
    frame.add_noise(0.1f);
    const std::vector<float> out = frame.filtered();
    double left = 0.0, right = 0.0;
    for (int y = 0; y < 64; ++y) {
      left += double(out[4 * frame.at(47, y)]) / 64;
      right += double(out[4 * frame.at(48, y)]) / 64;
    }
    EXPECT_NEAR(left, 0.5, 0.02);
    EXPECT_NEAR(right, 0.6, 0.02);
  }
}

// Albedo is divided out before filtering and multiplied back afterwards.
TEST(FastFilter, TextureStays) {
  Frame frame(96, 64);
  for (size_t i = 0; i < frame.albedo.size(); ++i) {
    frame.albedo[i] = float((i * 7919) % 97 + 10) / 107.0f;
    frame.set(i, frame.albedo[i] + 0.02f);
  }
  const std::vector<float> truth = frame.rgba;
  for (size_t i = 0; i < frame.albedo.size(); ++i) {
    frame.variance[i] = 0.01f;
    frame.set(i, truth[4 * i] * ((i * 31) % 2 == 0 ? 1.1f : 0.9f));
  }
  const std::vector<float> out = frame.filtered();
  double before = 0.0, after = 0.0;
  for (size_t i = 0; i < out.size(); i += 4) {
    before += std::abs(double(frame.rgba[i] - truth[i]));
    after += std::abs(double(out[i] - truth[i]));
  }
  EXPECT_LT(after, 0.2 * before);
}

TEST(FastFilter, ConvergesToTheRawPicture) {
  double last = 1e9;
  for (const float deviation : {1e-1f, 1e-2f, 1e-3f, 1e-4f}) {
    Frame frame(96, 64);
    for (size_t i = 0; i < frame.albedo.size(); ++i) frame.set(i, float((i * 7919) % 97) / 97.0f);
    const std::vector<float> truth = frame.rgba;
    frame.add_noise(deviation);
    const std::vector<float> out = frame.filtered();
    double moved = 0.0;
    for (size_t i = 0; i < out.size(); ++i)
      moved = std::max(moved, double(std::abs(out[i] - truth[i])));
    EXPECT_LT(moved, last);
    last = moved;
  }
  EXPECT_LT(last, 1e-3);
}

TEST(FastFilter, NonFiniteValuesDoNotSpread) {
  Frame frame(64, 40);
  frame.add_noise(0.05f);
  const float infinity = std::numeric_limits<float>::infinity();
  frame.set(frame.at(20, 20), std::numeric_limits<float>::quiet_NaN());
  frame.set(frame.at(0, 0), infinity);
  frame.set(frame.at(63, 39), -infinity);
  frame.set(frame.at(30, 10), 3e38f);
  frame.normal[frame.at(5, 5)] = infinity;
  frame.nearness[frame.at(6, 30)] = std::numeric_limits<float>::quiet_NaN();
  frame.variance[frame.at(7, 7)] = infinity;
  frame.variance[frame.at(8, 8)] = std::numeric_limits<float>::quiet_NaN();
  for (int x = 0; x < 64; ++x) frame.set(frame.at(x, 30), infinity);
  const std::vector<float> out = frame.filtered();
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 64; ++x) {
      const float value = out[4 * frame.at(x, y)];
      ASSERT_TRUE(std::isfinite(value)) << x << "," << y;
      const bool near_extreme = std::abs(x - 30) <= 15 && std::abs(y - 10) <= 15;
      if (y != 30 && !near_extreme) {
        ASSERT_NEAR(value, 0.5f, 0.3f) << x << "," << y;
      }
    }
  }
}

TEST(FastFilter, AFactorOfAllLightIsOneOfThePicture) {
  Frame plain(70, 33, 0.5f);
  plain.add_noise(0.1f);
  const std::vector<float> reference = plain.filtered();
  for (int exponent = -20; exponent <= 20; ++exponent) {
    Frame frame = plain;
    for (size_t i = 0; i < frame.albedo.size(); ++i) {
      frame.set(i, std::ldexp(plain.rgba[4 * i], exponent));
      frame.variance[i] = std::ldexp(plain.variance[i], 2 * exponent);
    }
    const std::vector<float> out = frame.filtered();
    for (size_t i = 0; i < out.size(); ++i) {
      const float shown = std::ldexp(out[i], i % 4 == 3 ? 0 : -exponent);
      ASSERT_TRUE(std::isfinite(shown)) << exponent;
      if (exponent >= 0) {
        ASSERT_NEAR(shown, reference[i], 1e-4f) << exponent;
      }
    }
  }
}

TEST(FastFilter, PixelsWithoutSamplesTakeTheirNeighbours) {
  Frame frame(64, 40);
  for (size_t i = 0; i < frame.albedo.size(); i += 2) {
    frame.samples[i] = 0.0f;
    frame.set(i, 100.0f);
  }
  const std::vector<float> out = frame.filtered();
  for (size_t i = 0; i < out.size(); i += 4) ASSERT_NEAR(out[i], 0.5f, 1e-5f) << i / 4;
  for (float& n : frame.samples) n = 0.0f;  // pixels without samples are black
  const std::vector<float> none = frame.filtered();
  for (size_t i = 0; i < none.size(); i += 4) ASSERT_NEAR(none[i], 0.0f, 1e-5f) << i / 4;
}

TEST(FastFilter, SmallPictures) {
  for (const auto& [width, height] : {std::pair(1, 1), {1, 9}, {17, 1}, {3, 2}, {0, 0}}) {
    const Frame frame(width, height);
    const std::vector<float> out = frame.filtered();
    for (size_t i = 0; i < out.size(); ++i) ASSERT_NEAR(out[i], frame.rgba[i], 1e-6f);
  }
}

// The result does not depend on the number of threads or on earlier use of the filter.
TEST(FastFilter, SameBitsForAnyThreads) {
  Frame frame(150, 99);
  frame.add_noise(0.1f);
  FastFilter used;
  Frame(200, 50, 1e6f).filtered(used);
  std::vector<float> one, two;
  tbb::task_arena(1).execute([&] { one = frame.filtered(); });
  tbb::task_arena(2).execute([&] { two = frame.filtered(used); });
  EXPECT_EQ(std::memcmp(one.data(), two.data(), one.size() * sizeof(float)), 0);
}

}  // namespace
}  // namespace emberline::test
