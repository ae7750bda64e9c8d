// Tests the velocity channel with closed forms for objects and cameras that translate or rotate, at
// an instant and with an open shutter. The picture itself must not change.
#include <gtest/gtest.h>

#include "support/moving_scenes.h"
#include "support/render.h"

namespace emberline {
namespace {

using namespace test;
using Vec2d = Imath::V2d;

constexpr int kFrame = 16;
constexpr double kPixelWidth = 2.0 / kFrame;  // of facing_view()

// Looks straight down the Z axis at the plane z = 0. The view spans -1 to 1.
CameraDescription facing_view() { return orthographic({0, 0, 5}, {0, 0, 0}, 1); }

RenderSettings settings_of(std::optional<Shutter> shutter = {}) {
  RenderSettings s;
  s.width = s.height = kFrame;
  s.spp = 16;
  s.aovs = "Z,velocity";
  s.shutter = shutter;
  return s;
}

Vec2d velocity(const RenderedImage& image, int x, int y) {
  const auto at = std::ranges::find(image.channels, "velocity.X") - image.channels.begin();
  const float* pixel = image.pixel(x, y);
  return {double(pixel[at]), double(pixel[at + 1])};
}

Vec2d mean_velocity(const RenderedImage& image) {
  Vec2d sum(0.0);
  for (int y = 0; y < kFrame; ++y) {
    for (int x = 0; x < kFrame; ++x) sum += velocity(image, x, y);
  }
  return sum / (kFrame * kFrame);
}

void expect_velocity(const Vec2d& found, const Vec2d& exact, double tolerance,
                     const std::string& what) {
  EXPECT_NEAR(found.x, exact.x, tolerance) << what;
  EXPECT_NEAR(found.y, exact.y, tolerance) << what;
}

MeshDescription sheet(int material, float half, float z = 0) {
  MeshDescription mesh;
  mesh.positions = {{-half, -half, z}, {half, -half, z}, {half, half, z}, {-half, half, z}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.material = material;
  return mesh;
}

// A square at `to_world`. `motion` moves it one frame later (if the picture is an instant), or
// while the shutter is open for `frames`.
struct MovingSquare {
  double frames = 0.0;    // 0: an instant
  bool vertices = false;  // moves the vertices instead of the transform
  bool twice = false;     // adds a second instance of the mesh, out of sight
  Mat44d to_world;
  float half = 0.5f;

  RenderedImage seen(const Mat44d& motion, const CameraDescription& view) const {
    SceneBuilderForTests b;
    MaterialDescription material = emitter(Rgb(1.0f));
    material.double_sided = true;
    MeshDescription mesh = sheet(b.add_material(material), half);
    std::vector<Vec3f> moved;
    for (const Vec3f& p : mesh.positions) {
      // Expresses the motion in the square's own space.
      const Mat44d there = to_world * motion * to_world.inverse();
      moved.push_back(Vec3f(transform_point(there, Vec3d(p))));
    }
    if (vertices && frames == 0) mesh.next_frame = moved;
    if (vertices && frames > 0) mesh.motion = {{moved, {}, {}}};
    const int index = b.add_mesh(mesh);
    b.place(index, to_world);
    if (!vertices && frames == 0) b.description.next_frame_instances = {{0, to_world * motion}};
    if (!vertices && frames > 0) b.description.instances[0].motion = {to_world * motion};
    if (twice) b.place(index, translation(90, 0, 0));
    std::optional<Shutter> shutter;
    if (frames > 0) shutter = Shutter{-.25, frames - .25};
    return render(*b.build(), view, settings_of(shutter));
  }
};

// A pixel half covered by the square has the square's velocity, not the background's.
TEST(Velocity, OfASquareThatPasses) {
  const Mat44d way = translation(2.5 * kPixelWidth, -1.25 * kPixelWidth, 3);
  for (const double frames : {0.0, 1.0, 0.5, 2.0}) {
    const Vec2d exact = Vec2d(2.5, -1.25) / (frames > 0 ? frames : 1);
    for (const bool vertices : {false, true}) {
      for (const bool twice : {false, true}) {
        for (const Mat44d& placed :
             {Mat44d(), scaling(-.8) * turned(.3), translation(.03, .01, -.2)}) {
          const MovingSquare passing{frames, vertices, twice, placed};
          const RenderedImage image = passing.seen(way, facing_view());
          const std::string what = "shutter of " + std::to_string(frames) +
                                   (vertices ? ", vertices" : "") + (twice ? ", instanced" : "");
          int seen = 0;
          for (int y = 0; y < kFrame; ++y) {
            for (int x = 0; x < kFrame; ++x) {
              const bool hit = image.pixel(x, y)[5] < kBackgroundDepth;
              seen += hit;
              expect_velocity(velocity(image, x, y), hit ? exact : Vec2d(0.0), 2e-5, what);
            }
          }
          EXPECT_GT(seen, 36) << what;
        }
      }
    }
  }
}

// At a distance r from the axis of a rotating wheel, the velocity at an instant is the chord, which
// is omega r for small angles.
TEST(Velocity, OfAWheelThatTurns) {
  constexpr double kHalfHeight = 0.01;
  const Vec3d at(.6, .3, 0);
  const CameraDescription view = orthographic(at + Vec3d(0, 0, 5), at, kHalfHeight);
  for (const double omega : {1e-3, .2, 2.0, -1.1}) {
    for (const bool twice : {false, true}) {
      for (const double frames : {0.0, 1.0}) {
        const MovingSquare wheel{frames, false, twice, Mat44d(), 2};
        const Vec2d found = mean_velocity(wheel.seen(turned(omega), view));
        Vec3d way = transform_point(turned(omega), at) - at;
        // A point seen at time t moves from -t omega to (1 - t) omega, so the mean over t is
        // tangential.
        if (frames > 0) way = Vec3d(-at.y, at.x, 0) * (2 * (1 - std::cos(omega)) / omega);
        const double pixel = 2 * kHalfHeight / kFrame;
        // The mean over samples equals the value at the pixel's centre, and the mean over times, to
        // a thousandth.
        const double tolerance =
            2e-3 * std::abs(omega) + (frames > 0 ? 1e-3 * way.length() / pixel : 0);
        expect_velocity(found, Vec2d(way.x, way.y) / pixel, tolerance,
                        "wheel by " + std::to_string(omega));
        if (std::abs(omega) > .01) continue;
        EXPECT_NEAR(found.length(), std::abs(omega) * at.length() / pixel, 1e-3);
      }
    }
  }
}

CameraDescription straight_view() { return perspective({0, 0, 4}, {0, 0, 0}, 90); }

// When the camera moves sideways, objects move the other way, and half as far at twice the depth.
TEST(Velocity, OfACameraThatPasses) {
  for (const bool open : {false, true}) {
    for (const bool lens : {false, true}) {
      for (const double depth : {2.0, 4.0}) {
        SceneBuilderForTests b;
        b.place(b.add_mesh(sheet(b.add_material(emitter(Rgb(1.0f))), 20, float(4 - depth))));
        CameraDescription view = straight_view();
        if (lens) view.lens_radius = .1, view.focus_distance = 3;
        const Mat44d there = view.to_world * translation(.1, .2, 0);
        if (open) view.motion = {there};
        if (!open) view.next_frame = there;
        const RenderedImage image = render(
            *b.build(), view, settings_of(open ? std::optional(Shutter{0, .5}) : std::nullopt));
        // At depth 1 the picture is 2 wide.
        const Vec2d exact = Vec2d(-.1, -.2) / depth / kPixelWidth / (open ? .5 : 1);
        for (int i = 0; i < kFrame; ++i) {
          expect_velocity(velocity(image, i, 5), exact, 2e-5, "depth " + std::to_string(depth));
        }
      }
    }
  }
}

// When the camera pans left, everything moves right, at any distance. When the camera rolls, the
// picture rotates about its centre.
TEST(Velocity, OfACameraThatTurns) {
  constexpr double kAngle = .02;
  const auto turn = [](bool roll, double angle) {  // about the camera's own axis, or its +Y
    if (roll) return turned(angle);
    Mat44d left;
    left[0][0] = left[2][2] = std::cos(angle);
    left[0][2] = -std::sin(angle);
    left[2][0] = std::sin(angle);
    return left;
  };
  for (const bool wall : {false, true}) {
    SceneBuilderForTests b;
    const int material = b.add_material(emitter(Rgb(1.0f)));
    b.place(b.add_mesh(sheet(material, 20)), wall ? Mat44d() : translation(0, 0, 99));
    b.set_environment(Rgb(.5f));
    for (const bool open : {false, true}) {
      const auto shutter = open ? std::optional(Shutter{0, 1}) : std::nullopt;
      for (const bool roll : {false, true}) {
        CameraDescription view = straight_view();
        const Mat44d there = turn(roll, kAngle) * view.to_world;
        if (open) view.motion = {there};
        if (!open) view.next_frame = there;
        const RenderedImage image = render(*b.build(), view, settings_of(shutter));
        for (int i = 0; i < kFrame; ++i) {
          const Vec3d seen((i + .5) * kPixelWidth - 1, 1 - 4.5 * kPixelWidth, -1);
          // The difference between the first and the last position in camera space, averaged over
          // the times at which the point is seen.
          Vec2d exact(0.0);
          const int times = open ? 100 : 1;
          for (int t = 0; t < times; ++t) {
            const double share = open ? (t + .5) / times : 0;
            const Vec3d from = transform_point(turn(roll, kAngle * share), seen);
            const Vec3d to = transform_point(turn(roll, -kAngle), from);
            exact += Vec2d(from.x / from.z - to.x / to.z, from.y / from.z - to.y / to.z) /
                     (kPixelWidth * times);
          }
          expect_velocity(velocity(image, i, 4), exact, 2e-3, roll ? "roll" : "pan");
          EXPECT_TRUE(roll || exact.x > 0.1);
        }
      }
    }
  }
}

// The camera moves towards a wall, so that x becomes x z / (z - way).
TEST(Velocity, OfACameraThatComesNearer) {
  SceneBuilderForTests b;
  b.place(b.add_mesh(sheet(b.add_material(emitter(Rgb(1.0f))), 20)));
  const auto scene = b.build();
  // The last two come within a hundredth of the first depth, or pass the wall. Their depth counts
  // as a hundredth of the first depth.
  for (const double way : {.5, 3.0, -4.0, 3.99, 5.0}) {
    CameraDescription view = straight_view();
    view.next_frame = view.to_world * translation(0, 0, -way);
    const RenderedImage image = render(*scene, view, settings_of());
    const double growth = 4 / std::max(4 - way, .04) - 1;
    for (int i = 0; i < kFrame; ++i) {
      const Vec2d exact = Vec2d(i + .5 - kFrame / 2, kFrame / 2 - 4.5) * growth;
      expect_velocity(velocity(image, i, 4), exact, .03 * std::abs(growth),
                      "way " + std::to_string(way));
    }
  }
}

// Positions behind, beside and extremely far from the camera give velocities that fit into half
// floats.
TEST(Velocity, IsFiniteWhereverThingsAre) {
  CameraDescription description = straight_view();
  description.next_frame = turned(.5) * description.to_world * translation(0, 0, .5);
  const double places[] = {0, 4, 4.5, -4, 4 - 1e-300, 1e-30, 1e18, -1e18, 1e300, 1e308, -1e308};
  for (const bool flat : {false, true}) {
    description.orthographic = flat;
    const Camera camera(description, kFrame, kFrame, Vec3d(0.0), 1.0);
    for (const double frames : {1.0, 1e-9, 1e-300, 1e3}) {
      for (const double from : places) {
        for (const double to : places) {
          for (const double aside : {0.0, 1.0, -1e18, 1e300}) {
            const Vec2f v = camera.velocity(Vec3d(aside, 0, from), Vec3d(0, aside, to), frames);
            EXPECT_LE(std::max(std::abs(v.x), std::abs(v.y)), 65504.0f) << from << " to " << to;
          }
        }
      }
      const Vec2f sideways = camera.velocity(Vec3d(1, 0, 0), frames);
      EXPECT_LE(std::max(std::abs(sideways.x), std::abs(sideways.y)), 65504.0f);
    }
  }
  // This point is behind the camera all the time.
  description.orthographic = false;
  const Camera camera(description, kFrame, kFrame, Vec3d(0.0), 1.0);
  EXPECT_EQ(camera.velocity(Vec3d(1, 0, 9), Vec3d(2, 0, 8), 1), Vec2f(0.0f));
}

TEST(Velocity, OfWhatIsAtRestIsNothing) {
  const MovingScene moving;
  const SceneBuilderForTests b = moving.at(.3);
  RenderSettings s = settings_of();
  const RenderedImage image = render(*b.build(), moving.view_at(.3), s);
  for (int y = 0; y < kFrame; ++y) {
    for (int x = 0; x < kFrame; ++x) EXPECT_EQ(velocity(image, x, y), Vec2d(0.0));
  }
  // Objects at rest in a moving scene also have no velocity, with an open shutter.
  const RenderedImage room =
      render(*moving.at_all_times().build(), moving.view_at(0), settings_of(Shutter{0, 1}));
  EXPECT_EQ(velocity(room, 0, kFrame - 1), Vec2d(0.0));  // the floor
  EXPECT_GT(mean_velocity(room).length(), 0.01);
}

// A sharp picture blurred along its velocities nearly equals the picture with an open shutter.
// Objects emit light and the background is black, so occlusion does not matter.
TEST(Velocity, BlursASharpPictureAsTheShutterDoes) {
  constexpr int kSize = 64;
  SceneBuilderForTests b;
  MaterialDescription card = emitter(Rgb(1.0f));
  card.double_sided = true;
  MeshDescription bar = sheet(b.add_material(card), .15f);
  for (Vec3f& p : bar.positions) p.x *= 4;
  b.place(b.add_mesh(bar));
  SceneBuilderForTests open = b;
  const auto pose = [](double t) { return turned(.4 * t) * translation(.3 * t, .1 * t, .4 * t); };
  b.description.next_frame_instances = {{0, pose(1)}};
  open.description.instances[0].motion = {pose(.5), pose(1)};
  const CameraDescription view = perspective({0, 0, 4}, {0, 0, 0}, 30);
  RenderSettings s = settings_of();
  s.width = s.height = kSize;
  s.spp = 256;
  const RenderedImage sharp = render(*b.build(), view, s);
  s.shutter = Shutter{0, 1};
  const RenderedImage blurred = render(*open.build(), view, s);
  std::vector<double> drawn(kSize * kSize, 0.0);
  constexpr int kTimes = 64;
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const Vec2d v = velocity(sharp, x, y);
      for (int i = 0; i < kTimes; ++i) {
        const double share = (i + .5) / kTimes;
        const auto to_x = int(std::lround(x + v.x * share)),
                   to_y = int(std::lround(y - v.y * share));
        if (to_x < 0 || to_x >= kSize || to_y < 0 || to_y >= kSize) continue;
        drawn[size_t(to_y * kSize + to_x)] += double(sharp.rgb(x, y).y) / kTimes;
      }
    }
  }
  double error = 0, without = 0;
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const double exact = double(blurred.rgb(x, y).y);
      error += square(drawn[size_t(y * kSize + x)] - exact);
      without += square(double(sharp.rgb(x, y).y) - exact);
    }
  }
  RecordProperty("rmse_of_sharp", std::to_string(std::sqrt(without / (kSize * kSize))));
  RecordProperty("rmse_of_drawn", std::to_string(std::sqrt(error / (kSize * kSize))));
  EXPECT_LT(std::sqrt(error), .25 * std::sqrt(without));
}

// The positions in the next frame do not change the picture.
TEST(Velocity, LeavesThePictureItsBits) {
  const MovingScene moving;
  const SceneBuilderForTests plain = moving.at(.3);
  SceneBuilderForTests b = moving.at(.3);
  CameraDescription view = moving.view_at(.3);
  for (uint32_t i = 1; i < b.description.instances.size(); ++i) {
    const Mat44d& now = b.description.instances[i].to_world;
    b.description.next_frame_instances.push_back({i, turned(.2) * now * translation(.1, .05, 0)});
  }
  MeshDescription& wave = b.description.meshes.back();
  wave.next_frame = wave.positions;
  for (Vec3f& p : wave.next_frame) p.y += .1f;
  for (const NamedValue<Aov>& aov : aov_table()) {
    RenderSettings s = settings_of();
    s.aovs = aov.name;
    if (aov.value == Aov::kClamped) s.clamp_indirect = 0.1f;
    if (aov.value == Aov::kShadow) s.catchers = "none here";
    if (aov.value == Aov::kDenoising) s.streams = StreamCount::kTwo;
    const RenderedImage without = render(*plain.build(), view, s);
    s.aovs += ",velocity";
    CameraDescription moved = view;
    moved.next_frame = view.to_world * translation(0, .1, 0);
    const RenderedImage with = render(*b.build(), moved, s);
    if (aov.value == Aov::kTime) continue;
    for (int y = 0; y < kFrame; ++y) {
      for (int x = 0; x < kFrame; ++x) {
        for (size_t c = 0; c < without.channels.size(); ++c) {
          if (without.channels[c].find("velocity") != std::string::npos) continue;
          const auto same = std::ranges::find(with.channels, without.channels[c]);
          ASSERT_EQ(with.pixel(x, y)[same - with.channels.begin()], without.pixel(x, y)[c])
              << without.channels[c] << " beside " << aov.name;
        }
      }
    }
    EXPECT_GT(mean_velocity(with).length(), .1);
  }
  const auto scene = b.build();
  EXPECT_FALSE(scene->moves());
  EXPECT_GT(scene->memory().geometry_bytes, plain.build()->memory().geometry_bytes);
}

}  // namespace
}  // namespace emberline
