// --noise-threshold T must hold for the picture: in scenes that mislead an estimate, the true error
// of each block may exceed T only slightly.
#include <gtest/gtest.h>

#include <span>
#include <string>

#include "image/picture_error.h"
#include "renderer/core/hash.h"
#include "renderer/drivers/adaptive/error_estimator.h"
#include "support/long_tests.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

struct HardScene {
  std::unique_ptr<Scene> scene;
  CameraDescription view;
  int light_samples = 1;
  int max_depth = 16;
};

// A partition divides a room into two halves. All light in the visible half comes through the gap
// beside the partition, from a small lamp in the other half.
HardScene lamp_behind_a_corner() {
  SceneBuilderForTests b;
  const int wall = b.add_material(lambert(Rgb(0.7f)));
  const int lamp = b.add_material(emitter(Rgb(30.0f)));
  b.add_floor(2, 0, wall);
  b.add_floor(2, 2, wall, false);
  b.add_quad({-2, 0, -2}, {2, 0, -2}, {2, 2, -2}, {-2, 2, -2}, wall);  // back
  b.add_quad({2, 0, 2}, {-2, 0, 2}, {-2, 2, 2}, {2, 2, 2}, wall);      // front
  b.add_quad({-2, 0, 2}, {-2, 0, -2}, {-2, 2, -2}, {-2, 2, 2}, wall);  // left
  b.add_quad({2, 0, -2}, {2, 0, 2}, {2, 2, 2}, {2, 2, -2}, wall);      // right
  MaterialDescription both = lambert(Rgb(0.7f));
  both.double_sided = true;
  b.add_quad({-2, 0, 0}, {1, 0, 0}, {1, 2, 0}, {-2, 2, 0}, b.add_material(both));  // partition
  b.add_quad({-1.2f, 1.95f, -1.2f}, {-1.0f, 1.95f, -1.2f}, {-1.0f, 1.95f, -1.0f},
             {-1.2f, 1.95f, -1.0f}, lamp);
  return {b.build(), perspective({1.8, 1.2, 1.8}, {-1, 0.8, 0.3}, 70), true, 5};
}

// Small bright dots hang above a floor, and only BSDF samples hit them. As with a caustic, most
// paths contribute nothing and a few contribute much.
HardScene rare_dots() {
  SceneBuilderForTests b;
  b.add_floor(3, 0, b.add_material(lambert(Rgb(0.6f))));
  const int dot = b.add_material(emitter(Rgb(60.0f)));
  for (uint32_t i = 0; i < 12; ++i) {
    const float x = 3 * to_unit_float(hash_combine(1, i)) - 1.5f;
    const float z = 3 * to_unit_float(hash_combine(2, i)) - 1.5f;
    const float h = 0.4f + 0.5f * to_unit_float(hash_combine(3, i)), r = 0.03f;
    b.add_quad({x - r, h, z - r}, {x + r, h, z - r}, {x + r, h, z + r}, {x - r, h, z + r}, dot);
  }
  return {b.build(), perspective({0, 2.0, 3}, {0, 0, 0}, 50), false, 2};
}

// Under the sky, the left half of the floor is nearly black and the right half is grey. The
// display's curve is steepest in the dark.
HardScene nearly_black_half() {
  SceneBuilderForTests b;
  const int coal = b.add_material(lambert(Rgb(0.003f))), grey = b.add_material(lambert(Rgb(0.5f)));
  b.add_quad({-4, 0, 2}, {0, 0, 2}, {0, 0, -2}, {-4, 0, -2}, coal);
  b.add_quad({0, 0, 2}, {4, 0, 2}, {4, 0, -2}, {0, 0, -2}, grey);
  const int pillar = b.add_material(lambert(Rgb(0.3f)));
  for (const float x : {-1.5f, -0.5f, 0.5f, 1.5f}) {
    b.add_quad({x, 0, 0}, {x + 0.2f, 0, 0}, {x + 0.2f, 1, 0}, {x, 1, 0}, pillar);
  }
  b.set_environment(Rgb(0.8f));
  return {b.build(), perspective({0, 2.2, 3}, {0, 0.2, 0}, 45)};
}

constexpr int kCornerWidth = 48, kCornerHeight = 32, kBlock = 16, kCornerSeeds = 3;

struct Measured {
  double worst = 0, whole = 0;  // RMS errors divided by the threshold
  double samples = 0;
  std::string where;
};

// The adaptive driver makes its estimates over the whole frame. The bucket driver makes them for
// each bucket separately, and they end at the bucket's edge. A short run uses the first two
// methods, which differ in driver and estimator.
struct Method {
  const char *driver, *estimator;
};
constexpr Method kMethods[] = {{"adaptive", "two-stream"},
                               {"bucket", "nested"},
                               {"adaptive", "nested"},
                               {"bucket", "two-stream"}};

RenderSettings settings_for(const HardScene& hard) {
  RenderSettings s;
  s.width = kCornerWidth;
  s.height = kCornerHeight;
  s.light_samples = hard.light_samples;
  s.max_depth = hard.max_depth;
  return s;
}

// Each block is measured over three frames, which gives 2304 values. If noise is normally
// distributed, they determine the block's RMS error to 1.5 %, or to 2.5 % if the references are as
// noisy as the frame.
Measured measure(const Method& method, const HardScene& hard, float threshold,
                 const References& references) {
  const auto [driver, estimator] = method;
  RenderSettings s = settings_for(hard);
  s.driver = driver;
  s.bucket_size = 16;
  s.adaptive.estimator = estimator;
  s.streams = find_estimator(estimator).streams;
  s.adaptive.threshold = threshold;
  s.adaptive.max_samples = 65536;
  std::vector<double> blocks((kCornerWidth / kBlock) * (kCornerHeight / kBlock), 0.0);
  Measured m;
  for (int seed = 0; seed < kCornerSeeds; ++seed) {
    s.seed = uint32_t(seed);
    const RenderedImage image = render(*hard.scene, hard.view, s);
    EXPECT_LT(image.counters.max_samples, 65536u) << "ended by --max-spp";
    m.samples += double(image.counters.samples) / (kCornerWidth * kCornerHeight) / kCornerSeeds;
    for (size_t i = 0; i < blocks.size(); ++i) {
      const int x = int(i) % (kCornerWidth / kBlock) * kBlock,
                y = int(i) / (kCornerWidth / kBlock) * kBlock;
      blocks[i] += squared_display_error(image, references, {x, y, x + kBlock, y + kBlock});
    }
  }
  double all = 0;
  for (size_t i = 0; i < blocks.size(); ++i) {
    all += blocks[i];
    const double rms = std::sqrt(std::max(0.0, blocks[i]) / (3.0 * kBlock * kBlock * kCornerSeeds));
    if (rms / double(threshold) <= m.worst) continue;
    m.worst = rms / double(threshold);
    m.where = std::to_string(i % (kCornerWidth / kBlock)) + "," +
              std::to_string(i / (kCornerWidth / kBlock));
  }
  m.whole =
      std::sqrt(all / (3.0 * kCornerWidth * kCornerHeight * kCornerSeeds)) / double(threshold);
  std::printf(
      "  %s, %s: %.0f samples a pixel, error %.2f of the threshold, worst block (%s) %.2f\n",
      driver, estimator, m.samples, m.whole, m.where.c_str(), m.worst);
  return m;
}

void expect_error_within_threshold(const HardScene& hard, float threshold, uint32_t reference_spp,
                                   double least_error) {
  const References references =
      render_references(*hard.scene, hard.view, settings_for(hard), reference_spp);
  for (const Method& method : std::span(kMethods).first(long_or_short(4, 2))) {
    SCOPED_TRACE(std::string(method.driver) + ", " + method.estimator);
    const Measured m = measure(method, hard, threshold, references);
    EXPECT_LE(m.worst, 1.25) << "block " << m.where;
    EXPECT_GE(m.whole, least_error) << "twice as much work as asked for";
  }
}

TEST(NoiseThreshold, LampBehindACorner) {
  expect_error_within_threshold(lamp_behind_a_corner(), 0.012f, long_or_short(1024u, 128u), 0.5);
}

TEST(NoiseThreshold, RareDots) { expect_error_within_threshold(rare_dots(), 0.08f, 2048, 0.5); }

TEST(NoiseThreshold, NearlyBlackHalf) {
  expect_error_within_threshold(nearly_black_half(), 0.01f, long_or_short(1024u, 256u), 0.4);
}

}  // namespace
}  // namespace emberline
