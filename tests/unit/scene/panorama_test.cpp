// Panoramas are environment maps. They reproduce a sky, and the light of a room.
#include <gtest/gtest.h>

#include <cstring>

#include "renderer/lights/environment_light.h"
#include "support/long_tests.h"
#include "support/render.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

CameraDescription panorama(const Vec3d& from, const Vec3d& at = Vec3d(0.3, -0.4, 0.2)) {
  CameraDescription camera = perspective(from, from + at, 40);
  camera.panorama = true;
  return camera;
}

std::shared_ptr<const Image> image_of(int width, int height, const std::vector<float>& rgb) {
  auto image = std::make_shared<Image>();
  image->width = width;
  image->height = height;
  image->channels = 3;
  image->type = TexelType::kFloat;
  image->texels.resize(rgb.size() * sizeof(float));
  std::memcpy(image->texels.data(), rgb.data(), image->texels.size());
  return image;
}

std::shared_ptr<const Image> image_of(const RenderedImage& picture) {
  std::vector<float> rgb;
  for (int y = picture.crop.y0; y < picture.crop.y1; ++y) {
    for (int x = picture.crop.x0; x < picture.crop.x1; ++x) {
      for (size_t c = 0; c < 3; ++c) rgb.push_back(picture.pixel(x, y)[c]);
    }
  }
  return image_of(picture.crop.width(), picture.crop.height(), rgb);
}

RenderSettings settings_of(int width, uint32_t spp) {
  RenderSettings s;
  s.width = width;
  s.height = width / 2;
  s.spp = spp;
  return s;
}

// Only a sky is visible, but a scene must contain geometry.
SceneBuilderForTests under(std::shared_ptr<const Image> sky) {
  SceneBuilderForTests b;
  b.add_floor(1e-3f, -50, b.add_material(lambert(Rgb(0.5f))));
  b.set_environment(std::move(sky));
  return b;
}

// Every texel has its own colour and is seen through its centre. The filter is a hundredth of a
// pixel wide and mixes in a hundredth of the next texel.
TEST(Panorama, PanoramaOfASkyEqualsTheSky) {
  constexpr int kWidth = 32, kHeight = 16;
  std::vector<float> rgb;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) rgb.insert(rgb.end(), {float(x), float(y), float(x % 3)});
  }
  RenderSettings s = settings_of(kWidth, 64);
  s.filter_radius = 0.01f;
  const RenderedImage seen =
      render(*under(image_of(kWidth, kHeight, rgb)).build(), panorama(Vec3d(2, 3, 4)), s);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const size_t at = size_t(y * kWidth + x) * 3;
      // Across the seam, neighbouring texels differ by 31.
      const double step = x == 0 || x == kWidth - 1 ? 0.16 : 0.006;
      EXPECT_NEAR(seen.pixel(x, y)[0], rgb[at], step) << x << "," << y;
      EXPECT_NEAR(seen.pixel(x, y)[1], rgb[at + 1], 0.006) << x << "," << y;
      EXPECT_NEAR(seen.pixel(x, y)[2], rgb[at + 2], 0.012) << x << "," << y;
    }
  }
}

// A room of six colours with a lamp off its centre.
SceneBuilderForTests room() {
  SceneBuilderForTests b;
  const auto wall = [&](const Rgb& colour) { return b.add_material(lambert(colour)); };
  b.add_floor(1, -1, wall(Rgb(0.7f, 0.7f, 0.2f)));
  b.add_floor(1, 1, wall(Rgb(0.8f)), false);
  b.add_quad({-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, wall(Rgb(0.1f, 0.2f, 0.8f)));
  b.add_quad({1, -1, 1}, {-1, -1, 1}, {-1, 1, 1}, {1, 1, 1}, wall(Rgb(0.8f, 0.5f, 0.1f)));
  b.add_quad({-1, -1, 1}, {-1, -1, -1}, {-1, 1, -1}, {-1, 1, 1}, wall(Rgb(0.8f, 0.1f, 0.1f)));
  b.add_quad({1, -1, -1}, {1, -1, 1}, {1, 1, 1}, {1, 1, -1}, wall(Rgb(0.1f, 0.7f, 0.1f)));
  const int lamp = b.add_material(emitter(Rgb(8.0f)));
  b.add_quad({.1f, .95f, -.5f}, {.6f, .95f, -.5f}, {.6f, .95f, .1f}, {.1f, .95f, .1f}, lamp);
  return b;
}

// Returns the colour of a white speck at the origin that faces `normal`, seen from straight ahead.
Rgb speck(SceneBuilderForTests b, const Vec3d& normal, int depth) {
  constexpr float kHalf = 1e-3f;
  const CameraDescription view = orthographic(normal * 0.01, Vec3d(0.0), 0.8 * double(kHalf));
  const auto axis = [&](int i) {
    const double* row = view.to_world[i];
    return to_float(Vec3d(row[0], row[1], row[2]));
  };
  const Vec3f right = axis(0), up = axis(1);
  const auto corner = [&](float s, float t) { return (right * s + up * t) * kHalf; };
  b.add_quad(corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1),
             b.add_material(lambert(Rgb(1.0f))));
  RenderSettings s = settings_of(16, long_or_short(512u, 256u));
  s.height = s.width;
  s.max_depth = depth;
  const RenderedImage image = render(*b.build(), view, s);
  Vec3d sum(0.0);
  for (int py = 0; py < s.height; ++py) {
    for (int px = 0; px < s.width; ++px) sum += to_double(image.rgb(px, py));
  }
  return to_float(sum / double(s.width * s.height));
}

// The tolerance of 1 % allows for the noise of the map and of two pictures of 256 pixels, and for
// texels that are partly lamp at its edges. A rotated or mirrored map is off by tens of per cent.
TEST(Panorama, PanoramaOfARoomLightsLikeTheRoom) {
  constexpr int kDepth = 4;
  RenderSettings s = settings_of(128, long_or_short(256u, 64u));
  s.max_depth = kDepth - 1;
  const auto sky = image_of(render(*room().build(), panorama(Vec3d(0.0)), s));
  for (const Vec3d& normal : {Vec3d(1, 0, 0), Vec3d(-1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, -1, 0),
                              Vec3d(0, 0, 1), Vec3d(0, 0, -1), Vec3d(.48, .6, .64)}) {
    const Rgb there = speck(room(), normal, kDepth), here = speck(under(sky), normal, 1);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(here[c], there[c], 0.01 * there[c])
          << normal.x << "," << normal.y << "," << normal.z << " channel " << c;
    }
  }
}

// Only the position of the camera matters, and depth is the distance from it.
TEST(Panorama, SeesTheSameWhicheverWayTheCameraLooks) {
  SceneBuilderForTests b;
  b.place(
      b.add_mesh(SceneBuilderForTests::sphere(2, 64, b.add_material(emitter(Rgb(1.0f))), true)));
  const auto scene = b.build();
  RenderSettings s = settings_of(16, 16);
  s.aovs = "Z,N";
  CameraDescription view = panorama(Vec3d(.1, .2, .3));
  const RenderedImage one = render(*scene, view, s);
  view.to_world = view.to_world * scaling(-3);
  for (int c = 0; c < 3; ++c) view.to_world[3][c] = .1 * (c + 1);
  view.lens_radius = 1;
  view.orthographic = true;
  expect_same_bits(render(*scene, view, s), one, "looking back through a lens");
  const auto depth = size_t(std::ranges::find(one.channels, "Z") - one.channels.begin());
  const RenderedImage middle = render(*scene, panorama(Vec3d(0.0)), s);
  for (int y = 0; y < s.height; ++y) {
    for (int x = 0; x < s.width; ++x) {
      EXPECT_NEAR(middle.pixel(x, y)[depth], 2.0, 2e-3) << x << "," << y;  // the faces are flat
    }
  }
}

// The camera may turn while the shutter is open. Only a change of its position would blur the
// picture.
TEST(Panorama, ACameraThatTurnsBlursNothing) {
  SceneBuilderForTests b = room();
  RenderSettings s = settings_of(16, 16);
  const RenderedImage still = render(*b.build(), panorama(Vec3d(0.1)), s);
  CameraDescription view = panorama(Vec3d(0.1));
  Mat44d turned;
  turned.setAxisAngle(Vec3d(1, 2, 3).normalized(), 1.0);
  for (int c = 0; c < 3; ++c) turned[3][c] = 0.1;
  view.motion = {turned};
  expect_same_bits(render(*b.build(), view, s), still, "turning");
}

TEST(Panorama, VelocityGoesTheShorterWayRound) {
  const Camera camera(panorama(Vec3d(0.0)), 200, 100, Vec3d(0.0), 1.0);
  const auto at = [](double longitude, double latitude) {
    const double u = longitude * kPiD / 180, v = latitude * kPiD / 180;
    return Vec3d(std::cos(v) * std::cos(u), std::sin(v), std::cos(v) * std::sin(u)) * 3;
  };
  const auto expect = [&](const Vec3d& from, const Vec3d& to, double right, double up) {
    const Vec2f found = camera.velocity(from, to, 2.0);
    EXPECT_NEAR(found.x, right, 1e-5);
    EXPECT_NEAR(found.y, up, 1e-5);
  };
  expect(at(10, 5), at(28, -13), 5, -5);      // 18 degrees are 10 pixels
  expect(at(171, 0), at(-171, 0) * 2, 5, 0);  // across the seam
  expect(at(-171, 0), at(171, 36), -5, 10);
  EXPECT_EQ(camera.velocity(Vec3d(1, 0, 0), 1.0), Vec2f(0.0f));
}

// All drivers give the same bits, and so does a crop.
TEST(Panorama, SameSamplesSameBits) {
  const auto scene = room().build();
  RenderSettings s = settings_of(48, 16);
  s.filter = "gaussian";
  s.aovs = "Z,velocity";
  const RenderedImage whole = render(*scene, panorama(Vec3d(0.0)), s);
  s.driver = "bisection";
  s.threads = 3;
  expect_same_bits(render(*scene, panorama(Vec3d(0.0)), s), whole, "bisection");
  s.driver = "bucket";
  s.crop = {0, 0, 7, 9};
  expect_same_bits(render(*scene, panorama(Vec3d(0.0)), s), whole, "crop");
}

}  // namespace
}  // namespace emberline
