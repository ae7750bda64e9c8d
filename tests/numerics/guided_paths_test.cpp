// Paths that are guided to indirect light (integrators/indirect_survey.h). Their light agrees with
// that of paths that are not guided, and rooms have less noise. (enclosure_test.cpp and
// furnace_test.cpp compare with closed forms.)
#include "closed_form.h"
#include "receiver.h"
#include "renderer/core/errors.h"
#include "renderer/core/memory_budget.h"
#include "renderer/scene/indirect_guide.h"
#include "support/float_map.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

RenderSettings with_guiding(RenderSettings s, Guiding guiding) {
  s.guiding = guiding;
  return s;
}

// A room of 4 x 3 x 4 units at the origin, whose lamp shines on the ceiling from behind a screen.
class GuidedRoomBuilder : public SceneBuilderForTests {
 public:
  explicit GuidedRoomBuilder(const MaterialDescription& walls, double size = 1) : size_(size) {
    const int wall = add_material(walls);
    quad({-2, 0, -2}, {4, 0, 0}, {0, 0, 4}, wall);
    quad({-2, 3, -2}, {4, 0, 0}, {0, 0, 4}, wall);
    for (const double side : {-2.0, 2.0}) {
      quad({side, 0, -2}, {0, 3, 0}, {0, 0, 4}, wall);
      quad({-2, 0, side}, {4, 0, 0}, {0, 3, 0}, wall);
    }
    quad({0, 0, -1.5}, {0, 2, 0}, {0, 0, 2}, wall);
    MaterialDescription lamp = emitter(Rgb(20.0f));
    quad({1.4, 1, -1}, {.3, 0, 0}, {0, 0, -.3}, add_material(lamp));
  }
  void quad(const Vec3d& p, const Vec3d& u, const Vec3d& v, int material) {
    const auto corner = [&](const Vec3d& c) { return Vec3f(c * size_); };
    add_quad(corner(p), corner(p + u), corner(p + u + v), corner(p + v), material);
  }
  CameraDescription view() const {
    return perspective(Vec3d(-1.7, 1.6, 1.7) * size_, Vec3d(0.5, 0.7, -1) * size_, 60);
  }

 private:
  double size_;
};

MaterialDescription plaster() {
  MaterialDescription m = lambert(Rgb(0.7f));
  m.double_sided = true;
  return m;
}

RenderSettings room_settings() {
  RenderSettings s;
  s.width = 48;
  s.height = 32;
  s.spp = 64;
  return s;
}

bool has_guide(const Scene& scene, const CameraDescription& view, const RenderSettings& s) {
  const Camera camera(view, s.width, s.height, scene.origin(), scene.scale());
  return plan_of(s).frame(scene, camera).indirect.guide != nullptr;
}

// The mean with a guide is that without one. The false-alarm rate is 6e-7 for each comparison.
TEST(GuidedPaths, HaveTheMeanOfPathsThatAreNot) {
  for (const std::string with : {"", "gloss", "metal", "layers", "pane", "solid", "card", "sky",
                                 "sun", "leaf", "coat", "tiny", "huge"}) {
    MaterialDescription walls = plaster();
    if (with == "gloss") {
      walls.specular = 1.0f;
      walls.roughness = 0.3f;
    } else if (with == "metal") {
      walls = metal(Rgb(0.7f), 0.5f);
      walls.double_sided = true;
    } else if (with == "layers") {
      walls.clearcoat = 0.5f;
      walls.sheen_color = Rgb(0.3f);
      walls.sheen_roughness = 0.5f;
    }
    GuidedRoomBuilder b(walls, with == "tiny" ? 1e-6 : with == "huge" ? 1e6 : 1);
    if (with == "pane" || with == "solid") {
      MaterialDescription glass;
      glass.metallic = 0.0f;
      glass.transmission = 1.0f;
      glass.roughness = 0.0f;
      glass.double_sided = with == "pane";
      glass.thin_walled = with == "pane";
      if (with == "pane") {
        b.quad({-1.2, 0.2, 1}, {1, 0, 0.4}, {0, 2, 0}, b.add_material(glass));
      } else {
        b.place(b.add_mesh(SceneBuilderForTests::sphere(0.4f, 16, b.add_material(glass))));
      }
    } else if (with == "card" || with == "leaf" || with == "coat") {
      MaterialDescription m = plaster();
      if (with == "coat") {
        m.clearcoat = 1.0f;
      } else if (with == "card") {
        m.alpha_mode = AlphaMode::kBlend;
        m.alpha = 0.5f;
      } else {
        m.diffuse_transmission = 0.5f;
      }
      b.quad({-1.2, 0.2, 1}, {1, 0, 0.4}, {0, 2, 0}, b.add_material(m));
    } else if (with == "sky" || with == "sun") {
      b.set_environment(
          with == "sky" ? float_map(32, 16, [](int, int row) { return Rgb(row < 8 ? 2.0f : 0.1f); })
                        : float_map(32, 16, [](int column, int row) {
                            return Rgb(column == 9 && row == 3 ? 300.0f : 0.1f);
                          }));
      // Removes the wall at z = 2, which the camera does not see.
      b.description.instances.erase(b.description.instances.begin() + 5);
    }
    const auto scene = b.build();
    RenderSettings on = with_guiding(room_settings(), Guiding::kOn);
    on.spp = long_or_short(256u, 128u);
    on.max_depth = 6;
    const CameraDescription view = b.view();
    ASSERT_TRUE(has_guide(*scene, view, on)) << with;
    const MeasuredMean guided = mean_of(*scene, view, on);
    on.seed = 77;
    const MeasuredMean plain = mean_of(*scene, view, with_guiding(on, Guiding::kOff));
    const double error = std::hypot(guided.standard_error, plain.standard_error);
    EXPECT_NEAR(guided.mean, plain.mean, 5 * error) << with;
    EXPECT_LT(error, 0.02 * plain.mean) << with;
  }
}

TEST(GuidedPaths, RoomsHaveLessNoise) {
  for (const double size : {1e-6, 1.0, 1e6}) {
    GuidedRoomBuilder b(plaster(), size);
    const auto scene = b.build();
    const RenderSettings on = with_guiding(room_settings(), Guiding::kOn);
    // The squared difference of two frames with different seeds.
    const auto error = [&](RenderSettings s) {
      const RenderedImage one = render(*scene, b.view(), s);
      s.seed = 77;
      const RenderedImage other = render(*scene, b.view(), s);
      double sum = 0;
      for (int y = 0; y < s.height; ++y) {
        for (int x = 0; x < s.width; ++x) {
          sum += double(square(one.rgb(x, y).x - other.rgb(x, y).x));
        }
      }
      return sum;
    };
    EXPECT_LT(1.5 * error(on), error(with_guiding(on, Guiding::kOff))) << size;
  }
}

// `auto` leaves small frames, direct light and open scenes as they are.
TEST(GuidedPaths, AutoGuidesWhereItPays) {
  GuidedRoomBuilder room(plaster());
  const auto inside = room.build();
  RenderSettings s = with_guiding({}, Guiding::kAuto);
  s.width = 160;
  s.height = 104;
  EXPECT_TRUE(has_guide(*inside, room.view(), s));
  EXPECT_FALSE(has_guide(*inside, room.view(), with_guiding(s, Guiding::kOff)));
  RenderSettings direct = s;
  direct.max_depth = 1;
  EXPECT_FALSE(has_guide(*inside, room.view(), direct));
  RenderSettings small = s;
  small.height = 102;
  EXPECT_FALSE(has_guide(*inside, room.view(), small));

  SceneBuilderForTests b;
  b.add_quad({-9, 0, -9}, {-9, 0, 9}, {9, 0, 9}, {9, 0, -9}, b.add_material(plaster()));
  b.place(b.add_mesh(SceneBuilderForTests::sphere(1.0f, 16, b.add_material(plaster()))));
  b.set_environment(Rgb(1.0f));
  EXPECT_FALSE(has_guide(*b.build(), perspective({0, 3, 6}, {0, 0, 0}, 50), s));

  // A deep court has much indirect light, but rays leave through its open top.
  SceneBuilderForTests court;
  const int wall = court.add_material(lambert(Rgb(0.9f)));
  court.add_quad({-2, 0, -2}, {-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, wall);
  court.add_quad({-2, 0, -2}, {2, 0, -2}, {2, 2, -2}, {-2, 2, -2}, wall);
  court.add_quad({-2, 0, 2}, {-2, 0, -2}, {-2, 2, -2}, {-2, 2, 2}, wall);
  court.add_quad({2, 0, -2}, {2, 0, 2}, {2, 2, 2}, {2, 2, -2}, wall);
  court.set_environment(Rgb(1.0f));
  const auto open = court.build();
  const CameraDescription view = perspective({0, 2, 2.5}, {0, 0.5, -1}, 60);
  const IndirectSurvey survey =
      plan_of(s)
          .frame(*open, Camera(view, s.width, s.height, open->origin(), open->scale()))
          .indirect;
  EXPECT_GT(survey.indirect_fraction, 0.25);
  EXPECT_GT(survey.leaving_fraction, 0.25);
  EXPECT_EQ(survey.guide, nullptr);
}

TEST(GuidedPaths, NoGuideWhereThereIsNothingToServe) {
  RenderSettings s = with_guiding(room_settings(), Guiding::kOn);
  SceneBuilderForTests empty;
  empty.set_environment(Rgb(1.0f));
  EXPECT_FALSE(has_guide(*empty.build(), perspective({0, 3, 6}, {0, 0, 0}, 50), s));
  MaterialDescription unlit = plaster(), glass = plaster();
  unlit.unlit = true;
  glass.transmission = 1.0f;
  for (const MaterialDescription& m : {unlit, glass}) {
    SceneBuilderForTests b;
    b.add_quad({-9, 0, -9}, {-9, 0, 9}, {9, 0, 9}, {9, 0, -9}, b.add_material(m));
    b.set_environment(Rgb(1.0f));
    EXPECT_FALSE(has_guide(*b.build(), perspective({0, 3, 6}, {0, 0, 0}, 50), s));
  }
}

// The largest survey stays within 64 MiB, and releases them.
TEST(GuidedPaths, ReserveTheirMemory) {
  GuidedRoomBuilder b(plaster());
  const auto scene = b.build();
  RenderSettings s = with_guiding(room_settings(), Guiding::kOn);
  s.width = s.height = 1024;
  const Camera camera(b.view(), s.width, s.height, scene->origin(), scene->scale());
  const RenderPlan plan = plan_of(s);
  const auto memory = std::make_shared<MemoryBudget>(uint64_t(64) << 20);
  EXPECT_TRUE(plan.frame(*scene, camera, {}, {}, memory).indirect.guide);
  EXPECT_GT(memory->peak(), uint64_t(32) << 20);
  EXPECT_EQ(memory->reserved(), 0u);
  const auto small = std::make_shared<MemoryBudget>(uint64_t(32) << 20);
  EXPECT_THROW(plan.frame(*scene, camera, {}, {}, small), LimitError);
  EXPECT_EQ(small->reserved(), 0u);
}

// Law 1: the guide depends on the scene and the view only, not on threads, crops, buckets, drivers
// or the seed.
TEST(GuidedPaths, EqualSamplesHaveEqualBits) {
  GuidedRoomBuilder b(plaster());
  const auto scene = b.build();
  RenderSettings s = with_guiding(room_settings(), Guiding::kOn);
  s.spp = 8;
  s.threads = 1;
  const RenderedImage whole = render(*scene, b.view(), s);
  EXPECT_NE(whole.values, render(*scene, b.view(), with_guiding(s, Guiding::kOff)).values);
  s.threads = 3;
  s.bucket_size = 7;
  EXPECT_EQ(render(*scene, b.view(), s).values, whole.values);
  s.driver = "bisection";
  expect_same_bits(render(*scene, b.view(), s), whole, "bisection");
  s.driver = "bucket";
  s.crop = Rect{5, 3, 30, 20};
  expect_same_bits(render(*scene, b.view(), s), whole, "crop");

  // The guide is the same for other seeds and sample counts.
  const Camera camera(b.view(), s.width, s.height, scene->origin(), scene->scale());
  const auto cell_of = [&](const RenderSettings& settings) {
    const auto guide = plan_of(settings).frame(*scene, camera).indirect.guide;
    const GuideCell* cell = guide->find(Vec3f(0.0f), {0, 1, 0});
    if (!cell) cell = guide->find(Vec3f(0.0f), {0, 1, -0.0f});
    return cell ? std::pair(cell->direct, cell->indirect) : std::pair(-1.0f, -1.0f);
  };
  const auto cell = cell_of(s);
  EXPECT_GT(cell.second, 0.0f);
  s.seed = 99;
  s.spp = 3;
  EXPECT_EQ(cell_of(s), cell);
}

}  // namespace
}  // namespace emberline
