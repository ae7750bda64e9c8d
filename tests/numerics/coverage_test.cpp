// Pixels average details that are smaller than a pixel: edges, wires, a checkered plane to the
// horizon.
#include <cstring>

#include "closed_form.h"
#include "support/chi_square.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

// The camera looks straight down, and a pixel covers one unit. Radiance is 1 on a shape and 0
// elsewhere. Every pixel holds the same shape, so the pixels are independent estimates of its area.
constexpr int kCells = 16;

RenderSettings pixel_settings(uint32_t spp) {
  RenderSettings s;
  s.width = s.height = kCells;
  s.spp = spp;
  s.max_depth = 0;
  return s;
}

// Renders a parallelogram of width w in each pixel. Its left edge runs from x0 at the pixel's near
// side to x1 at the far side.
RenderedImage shapes(double x0, double x1, double w, const RenderSettings& s) {
  SceneBuilderForTests b;
  MeshDescription mesh;
  mesh.name = "shapes";
  mesh.material = b.add_material(emitter(Rgb(1.0f)));
  for (int z = 0; z < kCells; ++z) {
    for (int x = 0; x < kCells; ++x) {
      const auto first = uint32_t(mesh.positions.size());
      const double left = x - kCells / 2, top = z - kCells / 2;
      mesh.positions.emplace_back(float(left + x0), 0.0f, float(top + 1));
      mesh.positions.emplace_back(float(left + x0 + w), 0.0f, float(top + 1));
      mesh.positions.emplace_back(float(left + x1 + w), 0.0f, float(top));
      mesh.positions.emplace_back(float(left + x1), 0.0f, float(top));
      mesh.triangles.push_back({first, first + 1, first + 2});
      mesh.triangles.push_back({first, first + 2, first + 3});
    }
  }
  b.place(b.add_mesh(mesh));
  return render(*b.build(), orthographic({0, 1, 0}, {0, 0, 0}, kCells / 2), s);
}

// Case 16: the coverage of a wire is its width. The tolerance of 1e-6 pixel is the rounding of
// vertices at coordinates of 8.
TEST(PixelCoverage, WiresThinnerThanAPixel) {
  for (const double width : {.5, .05, .005}) {
    const RenderSettings s = pixel_settings(1024);
    const RenderedImage image = shapes(.113, .377, width, s);
    expect_case({"16", "wire of width " + std::to_string(width) + " px"},
                {width, image.mean, image.standard_error, 1e-6}, replay(s));
  }
}

// Renders the area to the left of a tilted edge, which covers (.21 + .67) / 2 of each pixel.
RenderedImage edge(const RenderSettings& s) {
  // The shape starts at the pixel's left side, since a wider one would cover the neighbour.
  SceneBuilderForTests b;
  MeshDescription mesh;
  mesh.name = "edge";
  mesh.material = b.add_material(emitter(Rgb(1.0f)));
  for (int z = 0; z < kCells; ++z) {
    for (int x = 0; x < kCells; ++x) {
      const auto first = uint32_t(mesh.positions.size());
      const auto left = float(x - kCells / 2), top = float(z - kCells / 2);
      mesh.positions.emplace_back(left, 0.0f, top + 1);
      mesh.positions.emplace_back(left + .21f, 0.0f, top + 1);
      mesh.positions.emplace_back(left + .67f, 0.0f, top);
      mesh.positions.emplace_back(left, 0.0f, top);
      mesh.triangles.push_back({first, first + 1, first + 2});
      mesh.triangles.push_back({first, first + 2, first + 3});
    }
  }
  b.place(b.add_mesh(mesh));
  return render(*b.build(), orthographic({0, 1, 0}, {0, 0, 0}, kCells / 2), s);
}

// Case 15: the covered fraction is exact, and the variance falls as N^-1.5. A tilted edge cuts N^.5
// of the N elementary boxes of a net, and only those boxes contribute (algorithm notes, 3.3, where
// 1.48 was measured for the sampler alone). With 256 pixels the variance is known to sqrt(2 / 256)
// = 9 %, so the slope from 2^4 to 2^12 samples is known to about .13 / sqrt(60) = .017. The
// tolerance is .1, as for the sampler.
TEST(PixelCoverage, TiltedEdge) {
  double xy = 0, xx = 0;
  for (int k = 4; k <= 12; ++k) {
    const RenderSettings s = pixel_settings(1u << k);
    const RenderedImage image = edge(s);
    const double variance = square(image.standard_error) * (kCells * kCells);
    xy += (k - 8) * std::log2(variance);
    xx += (k - 8) * (k - 8);
    if (k == 12) {
      expect_case({"15", "pixel with a tilted edge"}, {.44, image.mean, image.standard_error, 1e-6},
                  replay(s));
    }
  }
  expect_case({"15", "order of convergence at a tilted edge"}, {1.5, -xy / xx, 0, .1},
              "16 to 4096 spp, 16 x 16, seed 1");
}

// A checkered plane of 2e4 x 2e4 squares with radiances 0 and 1 is seen from 1.5 above. Rows of
// pixels that cover many squares show the mean. A row can differ from the mean only by the squares
// that its outline cuts.
TEST(PixelCoverage, CheckerToTheHorizon) {
  SceneBuilderForTests b;
  auto image = std::make_shared<Image>();
  image->width = image->height = 2;
  image->channels = 3;
  const uint8_t texels[12] = {255, 255, 255, 0, 0, 0, 0, 0, 0, 255, 255, 255};
  image->texels.resize(sizeof texels);
  std::memcpy(image->texels.data(), texels, sizeof texels);
  b.description.images.push_back(image);
  MaterialDescription m = emitter(Rgb(1.0f));
  m.emission_texture.image = 0;
  m.emission_texture.nearest = true;
  const float half = 1e4f;
  b.add_quad({-half, 0, half}, {half, 0, half}, {half, 0, -half}, {-half, 0, -half},
             b.add_material(m));
  for (Vec2f& uv : b.description.meshes.back().uv_sets[0]) uv *= half;
  const auto scene = b.build();
  // All slopes here are tangents, measured downwards from the middle of the picture. The far end of
  // the plane is at 1.5e-4, and row 52 spans .02 to .03.
  RenderSettings s;
  s.width = 64;
  s.height = 100;
  s.crop = {0, 52, 64, 53};
  s.spp = 4096;
  s.max_depth = 0;
  // Since tan(fov / 2) = .5, a pixel is 1/100 high. Row 52 looks down by .02 to .03, so it sees the
  // plane 50 to 75 away.
  const CameraDescription view = perspective({.3, 1.5, 0}, {.3, 1.5, -1}, 53.13010235);
  // Row 52 covers 25 squares in depth and, over its 64 columns, 38 to 48 squares in width. Its mean
  // differs only by the squares that it cuts: 1 / (2 x 25 x 38).
  const RenderedImage near = render(*scene, view, s);
  expect_case({"15", "checker, row of 25 x 43 squares"},
              {.5, near.mean, near.standard_error, 1.0 / (2 * 25 * 38)}, replay(s));
  // Row 50, at the horizon, looks down by 0 to .01, so it sees the plane from 150 away to its end.
  // The plane ends at 1.5e-4 of that .01, so 1.5 % of the row are black. The rest of the row is
  // 9850 squares deep.
  s.crop = {0, 50, 64, 51};
  const RenderedImage far = render(*scene, view, s);
  const double share = 1 - (1.5 / 1e4) / .01;
  expect_case({"15", "checker, row at the horizon"},
              {.5 * share, far.mean, far.standard_error, 1.0 / (2 * 9850)}, replay(s));
}

}  // namespace
}  // namespace emberline
