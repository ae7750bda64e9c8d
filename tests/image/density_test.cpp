// Tests where adaptive samples go: to silhouettes, shadow boundaries and texture detail in the
// scenes of Painter & Sloan's figure 1 (set up as in scenes/make_heatmaps.py), and to what moves or
// is out of focus.
//
// The tests find the features in a uniform render with another seed. At a silhouette, neighbouring
// pixels show different objects, depths or faces. In texture, the albedo differs on a continuous
// surface. At a shadow boundary, the light differs on a flat surface, but the albedo does not. A
// pixel is blurred if an instant through a pinhole shows another surface or another light. Flat
// pixels are far from all of these features.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "renderer/engine/frame_scene.h"
#include "renderer/scene/build_scene.h"
#include "support/load_scene.h"
#include "support/long_tests.h"
#include "support/render.h"

namespace emberline {
namespace {

using namespace test;

const int kDensityWidth = long_or_short(256, 128), kDensityHeight = kDensityWidth * 9 / 16;
const size_t kFewPixels = long_or_short(300, 75);

enum Feature { kSilhouette, kShadow, kTexture, kBlurred, kFlat, kFeatures };
constexpr const char* kNames[kFeatures] = {"silhouettes", "shadow boundaries", "texture", "blurred",
                                           "flat"};

struct PictureScene {
  std::unique_ptr<Scene> scene;
  CameraDescription view;
};

PictureScene load(const RenderSettings& settings) {
  SceneDescription description = load_scene(settings);
  const CameraDescription view = choose_camera(settings, description);
  return {build_scene(std::move(description), {}), view};
}

RenderSettings direct_light(const std::string& scene) {
  RenderSettings s;
  s.scene = EMBERLINE_SCENES "/" + scene + ".glb";
  s.width = kDensityWidth;
  s.height = kDensityHeight;
  s.integrator = "direct";
  s.filter = kDefaultFilter;
  s.bucket_size = 64;
  return s;
}

// First-hit channels by name.
class Surfaces {
 public:
  explicit Surfaces(const RenderedImage& image) : image_(image) {}
  float at(const char* channel, int x, int y) const {
    const auto found = std::ranges::find(image_.channels, channel);
    return image_.pixel(x, y)[found - image_.channels.begin()];
  }
  Vec3f normal(int x, int y) const {
    return Vec3f(at("N.X", x, y), at("N.Y", x, y), at("N.Z", x, y)).normalized();
  }
  Rgb albedo(int x, int y) const {
    return {at("albedo.R", x, y), at("albedo.G", x, y), at("albedo.B", x, y)};
  }
  float radiance(int x, int y) const { return luminance(image_.rgb(x, y)); }
  // Returns the incident light, estimated as radiance over albedo.
  float light(int x, int y) const {
    return radiance(x, y) / std::max(0.02f, luminance(albedo(x, y)));
  }

 private:
  const RenderedImage& image_;
};

// Returns the feature between two neighbouring pixels.
Feature between(const Surfaces& s, int x0, int y0, int x1, int y1) {
  const float z0 = s.at("Z", x0, y0), z1 = s.at("Z", x1, y1);
  const float turn = s.normal(x0, y0).dot(s.normal(x1, y1));
  if (s.at("id", x0, y0) != s.at("id", x1, y1) || std::abs(z0 - z1) > 0.1f * std::min(z0, z1) ||
      !(turn > 0.8f)) {
    return kSilhouette;
  }
  const float albedo = max_abs_component(s.albedo(x0, y0) - s.albedo(x1, y1));
  if (albedo > 0.1f) return kTexture;
  const float a = s.light(x0, y0), b = s.light(x1, y1);
  const bool level = albedo < 0.02f && turn > 0.999f;
  return level && std::abs(a - b) > 0.25f * std::max(a, b) ? kShadow : kFlat;
}

// Returns whether the pixel's surface or light differs from that in the picture without blur.
bool is_blurred(const Surfaces& blurred, const Surfaces& sharp, int x, int y) {
  const auto differs = [](float a, float b, float share) {
    return std::abs(a - b) > share * std::max(a, b);
  };
  return differs(blurred.at("Z", x, y), sharp.at("Z", x, y), 0.1f) ||
         max_abs_component(blurred.albedo(x, y) - sharp.albedo(x, y)) > 0.1f ||
         differs(blurred.radiance(x, y), sharp.radiance(x, y), 0.25f);
}

// Returns the feature of every pixel, or kFeatures for a pixel too close to a feature to be flat.
// `sharp` is an instant through a pinhole.
std::vector<Feature> find_features(const RenderedImage& image, const RenderedImage& sharp) {
  const Surfaces s(sharp), blurred(image);
  std::vector<Feature> found(size_t(kDensityWidth) * kDensityHeight, kFlat);
  const auto at = [&](int x, int y) -> Feature& {
    return found[size_t(y) * kDensityWidth + size_t(x)];
  };
  for (int y = 0; y + 1 < kDensityHeight; ++y) {
    for (int x = 0; x + 1 < kDensityWidth; ++x) {
      for (const auto& [dx, dy] : {std::pair(1, 0), std::pair(0, 1)}) {
        const Feature feature = between(s, x, y, x + dx, y + dy);
        at(x, y) = std::min(at(x, y), feature);
        at(x + dx, y + dy) = std::min(at(x + dx, y + dy), feature);
      }
    }
  }
  for (int y = 0; y < kDensityHeight; ++y) {
    for (int x = 0; x < kDensityWidth; ++x) {
      if (is_blurred(blurred, s, x, y)) at(x, y) = kBlurred;
    }
  }
  const int kFar = long_or_short(4, 3);
  const std::vector<Feature> edges = found;
  for (int y = 0; y < kDensityHeight; ++y) {
    for (int x = 0; x < kDensityWidth; ++x) {
      for (int v = std::max(0, y - kFar); v <= std::min(kDensityHeight - 1, y + kFar); ++v) {
        for (int u = std::max(0, x - kFar); u <= std::min(kDensityWidth - 1, x + kFar); ++u) {
          const bool near = edges[size_t(v) * kDensityWidth + size_t(u)] != kFlat;
          if (near && at(x, y) == kFlat) at(x, y) = kFeatures;
        }
      }
    }
  }
  return found;
}

// Returns the mean samples of each feature's pixels, divided by the mean samples of flat pixels, or
// 0 for a feature with few pixels. The entry for flat pixels is their mean itself.
std::array<double, kFeatures> densities(const std::vector<Feature>& features,
                                        const RenderedImage& image) {
  std::array<double, kFeatures> mean{};
  std::array<size_t, kFeatures> pixels{};
  for (size_t i = 0; i < features.size(); ++i) {
    if (features[i] == kFeatures) continue;
    mean[features[i]] += double(image.pixel(int(i % kDensityWidth), int(i / kDensityWidth))[4]);
    pixels[features[i]]++;
  }
  EXPECT_GT(pixels[kFlat], kFewPixels) << "too few are flat to say anything of them";
  mean[kFlat] /= double(pixels[kFlat]);
  for (size_t f = 0; f < kFlat; ++f) {
    mean[f] = pixels[f] > kFewPixels ? mean[f] / double(pixels[f]) / mean[kFlat] : 0.0;
    std::printf("  %-18s %5zu pixels, %.2f times the density of flat ones\n", kNames[f], pixels[f],
                mean[f]);
  }
  return mean;
}

RenderedImage render_adaptively(const PictureScene& picture, RenderSettings s, float threshold,
                                uint32_t budget) {
  s.driver = "adaptive";
  s.streams = StreamCount::kTwo;
  s.adaptive.threshold = threshold;
  s.adaptive.budget = budget;
  s.adaptive.max_samples = threshold > 0 ? 4096 : 0;
  return render(*picture.scene, picture.view, s);
}

using Bounds =
    std::array<double, kFlat>;  // least density of each feature; 0 if the picture lacks it

// `reference_spp` is so high that noise does not count as shadow or blur.
void expect_densities(const RenderSettings& settings, uint32_t reference_spp, float threshold,
                      const Bounds& of_threshold, const Bounds& of_budget) {
  const PictureScene picture = load(settings);
  RenderSettings s = settings;
  s.spp = reference_spp;
  s.seed = 0x5eedu;
  s.aovs = "albedo,N,Z,id";
  const RenderedImage reference = render(*picture.scene, picture.view, s);
  const bool blurs = s.shutter || s.f_stop;
  s.shutter.reset();
  s.f_stop.reset();
  const PictureScene instant = load(s);
  const RenderedImage sharp = blurs ? render(*instant.scene, instant.view, s) : reference;
  const std::vector<Feature> features = find_features(reference, sharp);
  const auto expect = [&](const RenderedImage& image, const Bounds& bounds) {
    const auto measured = densities(features, image);
    for (size_t f = 0; f < kFlat; ++f) EXPECT_GE(measured[f], bounds[f]) << kNames[f];
  };
  expect(render_adaptively(picture, settings, threshold, 0), of_threshold);
  expect(render_adaptively(picture, settings, 0.0f, 32), of_budget);
  for (const double one : densities(features, reference)) {
    EXPECT_TRUE(one == 0.0 || one == 1.0 || one == double(reference_spp)) << "is not uniform";
  }
}

// With --noise-threshold .01 the measured densities are 3.7, 2.4 and 3.1 times that of flat pixels.
// With a budget of 32 samples a pixel, which is allocated by standard deviations instead of
// variances, they are 2.1, 2.1 and 1.9 times that of flat pixels. The bounds are a fifth lower.
TEST(Density, SpheresAreHighestAtFeatures) {
  expect_densities(direct_light("spheres"), 64, 0.01f, {2.9, 1.95, 2.5}, {1.6, 1.6, 1.5});
}

// The measured densities are 3.6, 2.8 and 3.6 with the threshold, and 1.9, 1.7 and 2.0 with the
// budget.
TEST(Density, TeapotIsHighestAtFeatures) {
  expect_densities(direct_light("teapot"), 256, 0.01f, {2.9, 2.25, 2.9}, {1.52, 1.38, 1.6});
}

// The blades turn by 30 degrees. The measured density is 8.1 with a threshold of .04, and 2.5 with
// the budget. With a threshold of .01, which takes minutes, it is 8.4.
TEST(Density, MovingBladeIsHighestWhereItMoves) {
  RenderSettings s = direct_light("moving_blade");
  s.time = 0;
  s.shutter = Shutter{0, 0.5};
  expect_densities(s, 128, 0.04f, {3.8, 0, 0, 6.5}, {1.54, 0, 0, 2.0});
}

// The measured density is 6.2 with a threshold of .04, and 4.2 with the budget. With a threshold of
// .01 it is 13. The white king is in focus.
TEST(Density, ShallowFocusIsHighestOutOfFocus) {
  RenderSettings s = direct_light("shallow_focus");
  s.f_stop = 1.4;
  s.focus_distance = 0.64;
  expect_densities(s, 128, 0.04f, {0, 0, 0, 5.0}, {0, 0, 0, 3.3});
}

}  // namespace
}  // namespace emberline
