// Compositing over a plate: shadow catchers, holdouts, and panes in front of nothing.
//
// The statistical tests have fixed seeds and are exactly reproducible.
#include <cmath>

#include "renderer/core/errors.h"
#include "renderer/description/catcher_plane.h"
#include "renderer/description/framing.h"
#include "renderer/scene/surface_roles.h"
#include "support/float_map.h"
#include "support/glass_scenes.h"
#include "support/render.h"
#include "support/scenes.h"
#include "support/schedules.h"

namespace emberline {
namespace {

using namespace test;

// A builder whose instances are named nodes. call() names those that were added since the last
// call.
struct Plate : SceneBuilderForTests {
  void call(const std::string& name) {
    for (size_t i = description.nodes.size(); i < description.instances.size(); ++i) {
      description.instances[i].node = int(i);
      description.nodes.push_back({name, int(i), true});
    }
  }
};

RenderSettings settings(const std::string& catchers, const std::string& holdouts = "") {
  RenderSettings s;
  s.width = s.height = 16;
  s.spp = 64;
  s.catchers = catchers;
  s.holdouts = holdouts;
  return s;
}

RenderedImage image_of(const Plate& plate, const CameraDescription& view, const RenderSettings& s) {
  const SurfaceRoles roles(plate.description, s.catchers, s.holdouts);
  Plate built = plate;
  return render(*built.build(), view, s, nullptr, {}, &roles);
}

// Looks down at the origin, in a view 0.02 wide.
CameraDescription from_above() { return orthographic({0, 4, 0}, {0, 0, 1e-9}, 0.01); }

size_t channel(const RenderedImage& image, const char* name) {
  return size_t(std::ranges::find(image.channels, name) - image.channels.begin());
}

double mean_of(const RenderedImage& image, const char* name) {
  double sum = 0;
  for (size_t i = channel(image, name); i < image.values.size(); i += image.channels.size()) {
    sum += double(image.values[i]);
  }
  return sum / double(image.crop.area());
}

// Returns a floor under a lamp. A board hides the half of the lamp at x > 0.
Plate lamp_half_in_view() {
  Plate p;
  p.add_floor(3, 0, p.add_material(lambert(Rgb(0.5f))));
  p.call("floor");
  const int lamp = p.add_material(emitter(Rgb(4.0f)));
  p.add_quad({-1, 2, -1}, {1, 2, -1}, {1, 2, 1}, {-1, 2, 1}, lamp);
  p.call("lamp");
  const int board = p.add_material(lambert(Rgb(0.0f)));
  p.add_quad({0, 1, -3}, {3, 1, -3}, {3, 1, 3}, {0, 1, 3}, board);
  p.call("board");
  return p;
}

CameraDescription from_below_the_board() { return orthographic({0, 0.5, 0}, {0, 0, 1e-9}, 0.001); }

TEST(ShadowCatcher, UnderHalfALamp) {
  const RenderSettings s = settings("floor");
  const RenderedImage image = image_of(lamp_half_in_view(), from_below_the_board(), s);
  for (const char* name : {"shadow.R", "shadow.G", "shadow.B"}) {
    EXPECT_NEAR(mean_of(image, name), 0.5, 0.004) << name;
  }
  EXPECT_NEAR(mean_of(image, "A"), 1.0, 1e-6) << "it is seen";
}

// `catcher-plane` catches what a floor of the scene catches, and the bounds of the scene do not
// include it.
TEST(ShadowCatcher, IsAPlaneUnderAnyScene) {
  const Plate plate = lamp_half_in_view();
  for (const double size : {1e-6, 1.0, 1e6}) {
    Plate p;
    for (const InstanceDescription& instance : plate.description.instances) {
      if (plate.description.nodes[size_t(instance.node)].name == "floor") continue;
      p.description.instances.push_back(instance);
    }
    p.description.meshes = plate.description.meshes;
    p.description.materials = plate.description.materials;
    for (InstanceDescription& instance : p.description.instances) {
      instance.node = -1;
      for (int r = 0; r < 4; ++r) {
        for (int c = 0; c < 3; ++c) instance.to_world[r][c] *= size;
      }
    }
    p.call("thing");
    const WorldBounds bounds = framed_bounds(p.description);
    add_catcher_plane(0.0, p.description);
    EXPECT_EQ(framed_bounds(p.description).min, bounds.min);
    EXPECT_EQ(framed_bounds(p.description).max, bounds.max);
    const CameraDescription view =
        orthographic({0, 0.5 * size, 0}, {0, 0, 1e-9 * size}, 0.001 * size);
    RenderSettings s = settings("");
    s.catcher_plane = CatcherPlane{0.0};
    EXPECT_NEAR(mean_of(image_of(p, view, s), "shadow.G"), 0.5, 0.004) << size;
  }
  Plate lowest;
  lowest.add_quad({-1, 2, -1}, {1, 2, -1}, {1, 5, 1}, {-1, 5, 1}, -1);
  add_catcher_plane({}, lowest.description);
  const double y = lowest.description.instances.back().to_world[3][1];
  EXPECT_LT(y, 2.0);
  EXPECT_GT(y, 1.999);
  SceneDescription nothing;
  add_catcher_plane({}, nothing);
  EXPECT_EQ(nothing.instances.size(), 1u);
}

TEST(ShadowCatcher, IsAlphaAlone) {
  RenderSettings s = settings("floor");
  s.transparent = true;
  const RenderedImage image = image_of(lamp_half_in_view(), from_below_the_board(), s);
  EXPECT_NEAR(mean_of(image, "A"), 0.5, 0.004);
  EXPECT_EQ(mean_of(image, "R"), 0.0);
  for (int i = 0; i < 256; ++i) {
    const float* p = image.pixel(i % 16, i / 16);
    EXPECT_FLOAT_EQ(p[3], 1.0f - p[channel(image, "shadow.G")]);
  }
}

// The plate is assumed to contain the shadows of its own objects already. So a catcher shows no
// shadows of other catchers or of holdouts.
TEST(ShadowCatcher, ShowsNoShadowOfThePlate) {
  EXPECT_EQ(mean_of(image_of(lamp_half_in_view(), from_below_the_board(), settings("floor,board")),
                    "shadow.G"),
            1.0);
  EXPECT_EQ(
      mean_of(image_of(lamp_half_in_view(), from_below_the_board(), settings("floor", "board")),
              "shadow.G"),
      1.0);
}

// Under a sky of radiance 1, at a distance d from a very long wall of height h, a share of (1 + d /
// sqrt(d^2 + h^2)) / 2 of the irradiance remains.
TEST(ShadowCatcher, BesideAWall) {
  for (const double d : {0.5, 1.0, 3.0}) {
    Plate p;
    p.add_floor(5000, 0, p.add_material(metal(Rgb(0.3f), 0.2f)));  // the material does not matter
    p.call("floor");
    const int wall = p.add_material(lambert(Rgb(0.2f)));
    const auto x = float(d);
    p.add_quad({x, 0, -1000}, {x, 0, 1000}, {x, 1, 1000}, {x, 1, -1000}, wall);
    p.add_quad({x, 0, 1000}, {x, 0, -1000}, {x, 1, -1000}, {x, 1, 1000}, wall);
    p.call("wall");
    p.set_environment(Rgb(1.0f));
    const RenderedImage image = image_of(p, from_above(), settings("floor"));
    EXPECT_NEAR(mean_of(image, "shadow.G"), (1 + d / std::sqrt(d * d + 1)) / 2, 0.004) << d;
  }
}

// A wall hides the darker half of a map. Light that is darker than the mean also counts.
TEST(ShadowCatcher, UnderAMapOfTwoHalves) {
  const auto image = float_map(1024, 32, [](int column, int) {
    return Rgb(column < 512 ? 0.5f : 2.0f);  // 0.5 at z < 0, 2 at z > 0
  });
  Plate p;
  p.add_floor(5000, 0, p.add_material(lambert(Rgb(0.3f))));
  p.call("floor");
  const int wall = p.add_material(lambert(Rgb(0.0f)));
  const float z = -0.02f, top = 100;  // just beside the visible part
  p.add_quad({-1000, 0, z}, {1000, 0, z}, {1000, top, z}, {-1000, top, z}, wall);
  p.call("wall");
  p.set_environment(image);
  RenderSettings s = settings("floor");
  s.spp = 256;
  const RenderedImage seen = image_of(p, from_above(), s);
  EXPECT_NEAR(mean_of(seen, "shadow.G"), 2.0 / 2.5, 0.005);
}

// A ball hides a reddish lamp but not a bluish one. Each lamp gives I cos / r^2.
TEST(ShadowCatcher, IsOfTheColourOfTheLightThatIsLeft) {
  Plate p;
  p.add_floor(3, 0, p.add_material(lambert(Rgb(0.5f))));
  p.call("floor");
  p.place(p.add_mesh(SceneBuilderForTests::sphere(0.2f, 16, p.add_material(lambert(Rgb(0.0f))))),
          translation(0.5, 0.5, 0));
  p.call("ball");
  p.add_point_light({1.5, 1.5, 0}, {3, 1, 0});
  p.add_point_light({-1, 2, 0}, {0, 1, 2});
  const RenderedImage image = image_of(p, from_above(), settings("floor"));
  const double hidden = 1.5 / std::pow(4.5, 1.5), left = 2 / std::pow(5.0, 1.5);
  EXPECT_EQ(mean_of(image, "shadow.R"), 0.0);
  EXPECT_NEAR(mean_of(image, "shadow.G"), left / (left + hidden), 0.004);
  EXPECT_EQ(mean_of(image, "shadow.B"), 1.0);
}

// A pane in front of a lamp blocks only what it reflects, so its shadow is faint.
TEST(ShadowCatcher, UnderAPane) {
  Plate p;
  p.add_floor(3, 0, p.add_material(lambert(Rgb(0.5f))));
  p.call("floor");
  p.add_quad({0.2f, 1, -1}, {2, 1, -1}, {2, 1, 1}, {0.2f, 1, 1},
             p.add_material(glass(1.5f, 0.0f, false)));
  p.call("pane");
  p.add_point_light({1.5, 1.5, 0}, Rgb(3.0f));
  const RenderedImage image = image_of(p, from_above(), settings("floor"));
  EXPECT_NEAR(mean_of(image, "shadow.G"), 1 - fresnel(std::atan(1.0), 1.5), 1e-4);
}

// Half of each pixel is a catcher and half is empty. The plate shows in both halves.
TEST(ShadowCatcher, AtAnEdge) {
  Plate p;
  p.add_quad({-3, 0, 3}, {0, 0, 3}, {0, 0, -3}, {-3, 0, -3}, p.add_material(lambert(Rgb(0.5f))));
  p.call("floor");
  p.place(p.add_mesh(SceneBuilderForTests::sphere(0.2f, 16, p.add_material(lambert(Rgb(0.0f))))),
          translation(0.5, 0.5, 0));
  p.call("ball");
  p.add_point_light({1.5, 1.5, 0}, Rgb(3.0f));
  RenderSettings s = settings("floor");
  s.transparent = true;
  const RenderedImage image = image_of(p, from_above(), s);
  EXPECT_NEAR(mean_of(image, "shadow.G"), 0.5, 0.01);
  EXPECT_NEAR(mean_of(image, "A"), 0.5, 0.01);
  s.transparent = false;
  p.set_environment(Rgb(1e-9f));  // visible, but gives almost no light
  EXPECT_NEAR(mean_of(image_of(p, from_above(), s), "A"), 1.0, 1e-6);
}

// ---- holdouts and panes, by compositing

Plate still_life() {
  Plate p;
  p.add_floor(4, 0, p.add_material(lambert(Rgb(0.5f, 0.4f, 0.3f))));
  p.call("floor");
  p.place(
      p.add_mesh(SceneBuilderForTests::sphere(0.5f, 12, p.add_material(metal(Rgb(0.9f), 0.1f)))),
      translation(-0.6, 0.5, 0));
  p.call("ball");
  p.place(p.add_mesh(SceneBuilderForTests::sphere(0.4f, 12, p.add_material(lambert(Rgb(0.7f))))),
          translation(0.6, 0.4, 0.6));
  p.call("other");
  MaterialDescription pane = glass(1.5f, 0.0f, false);
  pane.double_sided = true;
  p.add_quad({-3, 0, 1.5f}, {0.5f, 0, 1.5f}, {0.5f, 3, 1.5f}, {-3, 3, 1.5f}, p.add_material(pane));
  MaterialDescription dusty = pane;
  dusty.transmission = 0.7f;
  p.add_quad({-2, 0, 2}, {0.1f, 0, 2}, {0.1f, 3, 2}, {-2, 3, 2}, p.add_material(dusty));
  MaterialDescription veil = lambert(Rgb(0.2f, 0.7f, 0.3f));
  veil.alpha = 0.4f;
  veil.alpha_mode = AlphaMode::kBlend;
  veil.double_sided = true;
  p.add_quad({0.2f, 0.5f, 2}, {2, 0.5f, 2}, {2, 3, 2}, {0.2f, 3, 2}, p.add_material(veil));
  p.call("panes");
  p.set_environment(Rgb(0.6f));
  return p;
}

CameraDescription still_view() { return perspective({0.2, 1.0, 5.0}, {0, 1.2, 0}, 45); }

// The paths with and without the background are the same. So compositing over the background gives
// the picture with the background, up to rounding, sample by sample.
TEST(TransparentGlass, OverABackgroundIsThePictureWithIt) {
  RenderSettings s = settings("");
  s.width = s.height = 48;
  s.spp = 16;
  const RenderedImage whole = image_of(still_life(), still_view(), s);
  s.transparent = true;
  const RenderedImage cut = image_of(still_life(), still_view(), s);
  size_t partial = 0;
  for (int y = 0; y < s.height; ++y) {
    for (int x = 0; x < s.width; ++x) {
      const float alpha = cut.pixel(x, y)[3];
      partial += alpha > 0.05f && alpha < 0.95f;
      for (int c = 0; c < 3; ++c) {
        ASSERT_NEAR(cut.pixel(x, y)[c] + (1 - alpha) * 0.6f, whole.pixel(x, y)[c], 2e-6f)
            << x << "," << y;
      }
      ASSERT_NEAR(whole.pixel(x, y)[3], 1.0f, 1e-6f);
    }
  }
  EXPECT_GT(partial, 300u) << "panes before nothing";
}

// The camera looks through two panes at normal incidence. Each pane transmits 0.96.
TEST(TransparentGlass, HasTheAlphaOfWhatItKeepsBack) {
  Plate p;
  MaterialDescription pane = glass(1.5f, 0.0f, false);
  pane.double_sided = true;
  p.add_floor(2, 0, p.add_material(pane));
  p.add_floor(2, -1, p.add_material(pane));
  p.call("panes");
  p.add_point_light({0, 9, 0}, Rgb(1.0f));  // without an environment, nothing is behind the panes
  RenderSettings s = settings("");
  s.spp = 256;
  const double one = 1 - fresnel(0.0, 1.5);
  EXPECT_NEAR(mean_of(image_of(p, from_above(), s), "A"), 1 - one * one, 0.003);
}

// A holdout is a hole. Composited over what belongs in the hole, the picture looks complete.
TEST(Holdout, HidesWhatIsBehindAndLeavesNoAlpha) {
  RenderSettings s = settings("");
  s.width = s.height = 48;
  s.spp = 16;
  s.transparent = true;
  const RenderedImage without = image_of(still_life(), still_view(), s);
  s.holdouts = "ball";
  const RenderedImage with = image_of(still_life(), still_view(), s);
  size_t hidden = 0, behind_glass = 0;
  for (int i = 0; i < s.width * s.height; ++i) {
    const float* a = without.pixel(i % s.width, i / s.width);
    const float* b = with.pixel(i % s.width, i / s.width);
    EXPECT_LE(b[3], a[3] + 1e-6f);
    if (b[3] == a[3]) {
      for (int c = 0; c < 3; ++c) EXPECT_EQ(a[c], b[c]) << "other rays see it as before";
    } else {
      ++hidden;
      behind_glass += b[3] > 0.2f && b[3] < 0.7f;
    }
  }
  EXPECT_GT(hidden, 50u);
  EXPECT_GT(behind_glass, 30u) << "the panes before it are still there";

  // Without --transparent, the sky beside the holdout is visible.
  s.transparent = false;
  const RenderedImage sky = image_of(still_life(), still_view(), s);
  EXPECT_EQ(sky.pixel(0, 0)[3], 1.0f);
  s.holdouts = "ball,floor,other,panes";
  const RenderedImage all = image_of(still_life(), still_view(), s);
  const float* p = all.pixel(24, 40);
  for (int c = 0; c < 4; ++c) EXPECT_EQ(p[c], 0.0f) << "black, and no alpha";
}

// Law 2: alpha and shadows are the same for every schedule, with any other channels.
TEST(Plate, HasTheSameBitsWhoeverRenders) {
  for (const bool transparent : {false, true}) {
    RenderSettings s = settings("floor", "ball");
    s.width = 33;
    s.height = 25;
    s.spp = 20;
    s.transparent = transparent;
    s.aovs = "N,Z,direct,reflection,transmission";
    expect_same_bits_with_every_driver(s, {4, 3, 21, 17}, [](const RenderSettings& each) {
      return image_of(still_life(), still_view(), each);
    });
  }
}

// Several catchers lie behind one another, and those in front are panes. The last catcher counts.
TEST(Plate, CatchersThatArePanes) {
  Plate p = lamp_half_in_view();
  const int pane = p.add_material(glass(1.5f, 0.0f, false));
  for (const auto& [name, y] : {std::pair("low", 0.2f), std::pair("high", 0.3f)}) {
    p.add_quad({-1, y, -1}, {1, y, -1}, {1, y, 1}, {-1, y, 1}, pane);
    p.call(name);
  }
  RenderSettings s = settings("floor,low,high");
  s.width = 33;
  s.height = 25;
  s.spp = 32;
  const CameraDescription view = perspective({0.3, 0.9, 1.2}, {0, 0, 0}, 40);
  EXPECT_GT(mean_of(image_of(p, view, s), "shadow.G"), 0.1);
  expect_same_bits_with_every_driver(
      s, {4, 3, 21, 17}, [&](const RenderSettings& each) { return image_of(p, view, each); });
}

// Making a visible object a catcher changes no bit of the other channels.
TEST(Plate, CatchersChangeNoBitOfAPictureThatShowsThem) {
  RenderSettings s = settings("");
  s.width = 33;
  s.height = 25;
  const RenderedImage plain = image_of(still_life(), still_view(), s);
  s.catchers = "floor";
  const RenderedImage with = image_of(still_life(), still_view(), s);
  for (int i = 0; i < s.width * s.height; ++i) {
    for (int c = 0; c < 5; ++c) {
      ASSERT_EQ(with.pixel(i % 33, i / 33)[c], plain.pixel(i % 33, i / 33)[c]) << i;
    }
  }
}

// ---- node selection

std::string message_of(const SceneDescription& scene, const char* catchers, const char* holdouts) {
  try {
    SurfaceRoles(scene, catchers, holdouts);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

TEST(SurfaceRoles, AreOfNodesAndWhatIsBelowThem) {
  SceneDescription scene;
  scene.nodes = {{"set", 0, false},    {"floor", 0, true, 0}, {"a, b \\", 0, true, 0},
                 {"leaf", 0, true, 2}, {"leaf", 4, true},     {"lamp", 5, false}};
  for (const int node : {1, 2, 3, 4}) {
    scene.instances.emplace_back();
    scene.instances.back().node = node;
  }
  const auto roles = [&](const char* catchers, const char* holdouts) {
    const SurfaceRoles all(scene, catchers, holdouts);
    std::string text;
    for (uint32_t i = 0; i < 4; ++i) text += "-ch"[size_t(all.of(i))];
    return text;
  };
  EXPECT_EQ(roles("", ""), "----");
  EXPECT_EQ(roles("set", ""), "ccc-");
  EXPECT_EQ(roles("set", "leaf"), "cchh");
  EXPECT_EQ(roles("leaf", "a\\, b \\\\"), "-hcc");
  EXPECT_EQ(roles("1,,4", ""), "c--c") << "by number; nothing between commas";
  EXPECT_EQ(message_of(scene, "flor", ""),
            "catcher: no node 'flor'; the nearest names are 'floor', 'leaf', 'set', 'a\\, b \\\\'");
  EXPECT_EQ(
      message_of(scene, "floor", "floor"),
      "holdout: the node 'floor' is already a catcher; name it in only one of the two options");
  EXPECT_EQ(message_of(scene, "", "lamp").substr(0, 73),
            "holdout: neither the node 'lamp' nor any node below it has a mesh; the ne");
  EXPECT_EQ(message_of({}, "x", ""),
            "catcher: no node 'x'; the file has no nodes with a mesh and a name");
}

}  // namespace
}  // namespace emberline
