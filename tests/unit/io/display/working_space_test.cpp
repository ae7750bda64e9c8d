// Tests rendering in ACEScg. The colours of a scene do not depend on the primaries in which it is
// rendered.
#include "io/display/working_space.h"

#include <gtest/gtest.h>

#include <cstring>

#include "io/display/display.h"
#include "support/render.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

constexpr WorkingSpace kAcesCg = WorkingSpace::kAcesCg;
const Rgb kOrange(0.9f, 0.35f, 0.05f);

TEST(WorkingSpace, MatricesAreTheAcademys) {
  const ToWorkingSpace there = to_working_space(kAcesCg), back = from_working_space(kAcesCg);
  ASSERT_TRUE(there && back);
  EXPECT_FALSE(to_working_space(WorkingSpace::kRec709));
  // The expected values adapt D65 by Bradford's method and are computed from the chromaticities in
  // double.
  const Rgb red = *there * Rgb(1, 0, 0), green = *there * Rgb(0, 1, 0);
  EXPECT_NEAR(red.x, 0.61310, 1e-4);
  EXPECT_NEAR(red.y, 0.07019, 1e-4);
  EXPECT_NEAR(red.z, 0.02062, 1e-4);
  EXPECT_NEAR(green.x, 0.33952, 1e-4);
  EXPECT_NEAR(green.y, 0.91635, 1e-4);
  EXPECT_NEAR(green.z, 0.10957, 1e-4);
  for (const Rgb& c : {Rgb(1.0f), kOrange, Rgb(0, 0, 1)}) {
    const Rgb again = *back * (*there * c);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(again[k], c[k], 2e-6f);
  }
  const Rgb grey = *there * Rgb(0.18f);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(grey[k], 0.18f, 1e-6f);
}

TEST(WorkingSpace, IsKnownByItsChromaticities) {
  for (const auto& space : working_space_table()) {
    EXPECT_EQ(working_space_of(chromaticities_of(space.value)), space.value);
  }
  EXPECT_EQ(working_space_of({}), WorkingSpace::kRec709);
}

TEST(WorkingSpace, IsDisplayedAsItself) {
  for (const char* view : {"sRGB", "ACES"}) {
    DisplaySettings settings;
    settings.view = view;
    const DisplayTransform plain(settings), from_acescg(settings, kAcesCg);
    for (const Rgb& c : {Rgb(0.5f), kOrange, Rgb(0.1f, 0.2f, 0.9f)}) {
      Rgb a = c, b = *to_working_space(kAcesCg) * c;
      plain.apply(&a.x, 1);
      from_acescg.apply(&b.x, 1);
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(a[k], b[k], 1e-5f) << view;
    }
  }
}

struct Both {
  RenderedImage plain, acescg;
};

Both rendered(SceneBuilderForTests b, const CameraDescription& view, int depth = 4) {
  RenderSettings s;
  s.width = s.height = 8;
  s.spp = 16;
  s.max_depth = depth;
  Both both;
  both.plain = render(*b.build(), view, s);
  b.description.to_working = to_working_space(kAcesCg);
  both.acescg = render(*b.build(), view, s);
  return both;
}

// Expects each pixel of `acescg` to be the converted pixel of `plain`.
void expect_converted(const Both& both, double tolerance, const std::string& what) {
  float brightest = 0;
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 8; ++x) {
      const Rgb wanted = *to_working_space(kAcesCg) * both.plain.rgb(x, y);
      const Rgb found = both.acescg.rgb(x, y);
      brightest = std::max(brightest, max_component(wanted));
      for (int k = 0; k < 3; ++k) {
        ASSERT_NEAR(found[k], wanted[k], tolerance * std::max(1.0, double(wanted[k])))
            << what << " at " << x << "," << y;
      }
    }
  }
  EXPECT_GT(brightest, 0.01f) << what;
}

std::shared_ptr<const Image> texture(TexelType type) {
  auto image = std::make_shared<Image>();
  image->width = image->height = 2;
  image->channels = 3;
  image->type = type;
  if (type == TexelType::kUint8) {
    for (const int v : {255, 30, 60, 10, 240, 90, 20, 50, 250, 200, 200, 10}) {
      image->texels.push_back(std::byte(v));
    }
  } else {
    const std::array<float, 12> v = {2, .1f, .3f, .1f, 3, .2f, .2f, .1f, 4, 1, 1, .5f};
    image->texels.resize(sizeof v);
    std::memcpy(image->texels.data(), v.data(), sizeof v);
  }
  return image;
}

const CameraDescription kAbove = orthographic({0, 1, 0}, {0, 0, 0}, 0.9);

// A square from -1 to 1, seen from above.
SceneBuilderForTests square_of(const MaterialDescription& m) {
  SceneBuilderForTests b;
  if (m.base_color_texture.image >= 0 || m.emission_texture.image >= 0) {
    b.description.images.push_back(texture(TexelType::kUint8));
  }
  b.add_floor(1, 0, b.add_material(m));
  return b;
}

// A single coloured interaction is converted exactly. It may be coloured light, or a coloured
// surface in white light, and the colour may come from anywhere.
TEST(WorkingSpace, OneColourIsItself) {
  expect_converted(rendered(square_of(emitter(kOrange)), kAbove), 1e-6, "emission");
  MaterialDescription m = emitter(kOrange);
  m.emission_texture.image = 0;
  expect_converted(rendered(square_of(m), kAbove), 1e-6, "emission, textured");
  m = lambert(kOrange);
  m.unlit = true;
  expect_converted(rendered(square_of(m), kAbove), 1e-6, "unlit");
  m.base_color_texture.image = 0;
  expect_converted(rendered(square_of(m), kAbove), 1e-6, "unlit, textured");

  const auto under_white = [](MaterialDescription material, const std::string& what) {
    SceneBuilderForTests b = square_of(material);
    b.set_environment(Rgb(1.0f));
    expect_converted(rendered(b, kAbove, 1), 2e-5, what);
  };
  under_white(lambert(kOrange), "base colour");
  m = lambert(kOrange);
  m.base_color_texture.image = 0;
  under_white(m, "base colour, textured");
  under_white(metal(kOrange, 0.0f), "metal");
  m = lambert(Rgb(0.0f));
  m.diffuse_transmission = 1.0f;
  m.diffuse_transmission_color = kOrange;
  under_white(m, "diffuse transmission");
}

TEST(WorkingSpace, LightsKeepTheirColours) {
  const auto lit = [] { return square_of(lambert(Rgb(0.8f))); };
  SceneBuilderForTests b = lit();
  b.set_environment(kOrange);
  b.description.environment->tint = Rgb(0.2f, 0.9f, 1.0f);
  expect_converted(rendered(b, kAbove), 2e-5, "constant environment");
  b = lit();
  b.set_environment(texture(TexelType::kFloat));
  b.description.environment->tint = Rgb(0.2f, 0.9f, 1.0f);
  expect_converted(rendered(b, kAbove), 2e-5, "environment map");
  b.description.environment->sun =
      std::make_shared<const SunDisc>(SunDisc{Vec3f(0, 1, 0), 0.005f, kOrange * 10.0f});
  expect_converted(rendered(b, kAbove), 2e-5, "sun");
  b = lit();
  b.add_point_light({0.3, 2, 0.1}, kOrange * 5.0f);
  expect_converted(rendered(b, kAbove), 2e-5, "point light");
  // The light changes from its red part to its blue part while the shutter is open.
  TimeCurve<Rgb> share{{0, 1}, {Rgb(1, 0, 0), Rgb(0, 0, 1)}};
  b.description.lights[0].share = std::make_shared<const TimeCurve<Rgb>>(share);
  expect_converted(rendered(b, kAbove), 2e-5, "light that changes");
  b = lit();
  const int lamp = b.add_material(emitter(kOrange * 9.0f));
  b.add_quad({-.2f, .5f, -.2f}, {.2f, .5f, -.2f}, {.2f, .5f, .2f}, {-.2f, .5f, .2f}, lamp);
  expect_converted(rendered(b, kAbove, 1), 2e-5, "lamp");
}

// Grey light with many bounces in a grey room is the same up to rounding.
TEST(WorkingSpace, GreyIsGrey) {
  SceneBuilderForTests b = square_of(metal(Rgb(0.7f), 0.4f));
  b.add_floor(1, 0.6f, b.add_material(lambert(Rgb(0.6f))), false);
  b.set_environment(Rgb(2.0f));
  b.add_point_light({0.1, 0.3, 0}, Rgb(0.5f));
  const Both both = rendered(b, orthographic({0, 0.5, 0}, {0, 0, 0}, 0.9), 8);
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 8; ++x) {
      for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(both.acescg.rgb(x, y)[k], both.plain.rgb(x, y)[k], 1e-5);
      }
    }
  }
}

}  // namespace
}  // namespace emberline
