// Case 22: a sky of radiance 1 with one texel of 1e6, the sun of a low-resolution map.
#include <cstring>

#include "closed_form.h"
#include "renderer/lights/environment_light.h"
#include "support/chi_square.h"
#include "support/light_scenes.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

constexpr int kWidth = 64, kHeight = 32, kColumn = 40, kRow = 9;
constexpr float kPeak = 1e6f;

std::shared_ptr<const Image> sky() {
  auto image = std::make_shared<Image>();
  image->width = kWidth;
  image->height = kHeight;
  image->channels = 3;
  image->type = TexelType::kFloat;
  std::vector<float> texels(kWidth * kHeight * 3, 1.0f);
  for (size_t c = 0; c < 3; ++c) texels[(kRow * kWidth + kColumn) * 3 + c] = kPeak;
  image->texels.resize(texels.size() * sizeof(float));
  std::memcpy(image->texels.data(), texels.data(), image->texels.size());
  return image;
}

// The map is interpolated bilinearly, so the texel is a product of two tents of half widths a = 2
// pi / W and b = pi / H around theta0, entirely above the horizon. Its irradiance on a level floor
// is
//   (P - 1) a int tent((t - theta0) / b) cos t sin t dt = (P - 1) a b sin(2 theta0) / 2 (sin b/b)^2
// since the tent's transform at frequency 2 is b (sin b / b)^2. The rest of the sky gives pi.
double exact_irradiance() {
  const double a = 2 * kPiD / kWidth, b = kPiD / kHeight, theta0 = kPiD * (kRow + .5) / kHeight;
  return kPiD + (double(kPeak) - 1) * a * b * std::sin(2 * theta0) / 2 * square(std::sin(b) / b);
}

std::unique_ptr<Scene> floor_under_it() {
  SceneBuilderForTests b;
  b.add_floor(100, 0, b.add_material(lambert(Rgb(1.0f))));
  b.set_environment(sky());
  return b.build();
}

// The map's look-ups are in float.
constexpr double kTolerance = 1e-5;

TEST(BrightTexel, LightAndBsdfSampling) {
  RenderSettings s;
  s.width = s.height = 32;
  s.spp = 64;
  s.max_depth = 1;
  const RenderedImage image = render(*floor_under_it(), orthographic({0, 1, 0}, {0, 0, 0}, 1), s);
  expect_exact(image, exact_irradiance() / kPiD, kTolerance, s, {"22", "both samplings"});
  // This is the error of one pixel with 64 samples. The mean of 1024 pixels has 1/32 of it.
  const double relative = image.standard_error * 32 / image.mean;
  expect_case({"22", "relative standard error at 64 spp, below 0.01"}, {0, relative, 0, 0.01},
              replay(s));
}

TEST(BrightTexel, BsdfSamplingAlone) {
  RenderSettings s;
  s.width = s.height = 16;
  s.spp = long_or_short(16384u, 4096u);
  s.max_depth = 1;
  s.light_samples = 0;
  expect_exact(render(*floor_under_it(), orthographic({0, 1, 0}, {0, 0, 0}, 1), s),
               exact_irradiance() / kPiD, kTolerance, s, {"22", "BSDF sampling"});
}

// Tests light sampling alone. MIS compensation is off, since it would leave the dim part to BSDF
// sampling.
TEST(BrightTexel, LightSamplingAlone) {
  const LightSampler lights = make_light_sampler(
      {}, {},
      std::make_shared<EnvironmentLight>(sky(), 1.0f, 0.0f,
                                         EnvironmentLightSettings{.mis_compensation = 0.0f}));
  const Moments m = estimate(lights, {Vec3f(0.0f), Vec3f(0, 1, 0)}, 2'000'000, 22);
  expect_case({"22", "light sampling"},
              {exact_irradiance(), m.mean(), m.standard_error(), kTolerance * exact_irradiance()},
              "TestRandom(22, draw), 2e6 draws");
}

}  // namespace
}  // namespace emberline
