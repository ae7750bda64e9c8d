// Motion while the shutter is open: coverage over time (case 23), rays that stay inside (E44),
// light from moving emitters (E45), views of moving surfaces (E46), and blur as the mean of many
// instants (E47).
#include "lamp_over_floor.h"

#include "renderer/core/moments.h"
#include "renderer/core/warps.h"
#include "renderer/shading/shading_normal.h"
#include "support/chi_square.h"
#include "support/moving_scenes.h"

namespace emberline {
namespace {

using namespace test;

constexpr int kSide = 32;
constexpr double kHalf = 1;  // half size of the view
constexpr double kPixel = 2 * kHalf / kSide;

// Looks straight down the Z axis at the plane z = 0. Pixel column i starts at x = -1 + i / 16.
CameraDescription front_view() { return orthographic({0, 0, 5}, {0, 0, 0}, kHalf); }

RenderSettings settings_for(const CaseName& name, uint32_t spp = 256) {
  RenderSettings s = direct_light_settings(spp);
  s.width = s.height = kSide;
  s.max_depth = 4;
  s.seed = seed_of(name);
  return s;
}

double left_of(int column) { return -kHalf + column * kPixel; }

// Compares a column of pixels, which all have the expected value `exact`.
void expect_column(const RenderedImage& image, int column, double exact, double tolerance,
                   const std::string& number, const std::string& what, const RenderSettings& s) {
  Moments values;
  for (int y = 0; y < kSide; ++y) values.add(double(image.rgb(column, y).y));
  expect_case({number, what + ", column " + std::to_string(column)},
              {exact, values.mean(), values.standard_error(), tolerance}, replay(s));
}

// Returns how much of the pixel that starts at `left` is covered by a bar [x0, x1] that moves right
// by `way`. The value is the mean over the pixel and over the shutter time.
double bar_coverage(double x0, double x1, double way, double left) {
  double sum = 0;
  constexpr int kTimes = 2000;
  for (int i = 0; i < kTimes; ++i) {
    const double shift = way * (i + .5) / kTimes;
    sum += std::max(0.0, std::min(left + kPixel, x1 + shift) - std::max(left, x0 + shift));
  }
  return sum / (kTimes * kPixel);
}

MeshDescription bar(int material, float x0, float x1, float half = 3) {
  MeshDescription mesh;
  mesh.name = "bar";
  mesh.positions = {{x0, -half, 0}, {x1, -half, 0}, {x1, half, 0}, {x0, half, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.material = material;
  return mesh;
}

// Case 23: a bar moves by a transform of two or five steps, or by its vertices. Or the camera moves
// the other way, or the camera and the bar each move half of the way.
TEST(Motion, BarCrossesPixels) {
  constexpr double kFrom = -.523, kTo = -.211, kWay = .8;
  const struct {
    std::string what;
    double object, camera;
    int steps;
    bool vertices;
  } cases[] = {{"bar that moves", 1, 0, 2, false},
               {"bar that moves in five steps", 1, 0, 5, false},
               {"bar whose vertices move", 1, 0, 2, true},
               {"bar whose vertices move in four steps", 1, 0, 4, true},
               {"camera that passes a bar", 0, 1, 2, false},
               {"camera and bar that move", .5, .5, 3, false}};
  for (const auto& c : cases) {
    SceneBuilderForTests b;
    MeshDescription mesh = bar(b.add_material(emitter(Rgb(1.0f))), float(kFrom), float(kTo));
    CameraDescription view = front_view();
    const Mat44d look = view.to_world;
    std::vector<Mat44d> transforms;
    for (int i = 1; i < c.steps; ++i) {
      const double share = double(i) / (c.steps - 1);
      const double way = kWay * c.object * share;
      transforms.push_back(translation(way, 0, 0));
      if (c.vertices) {
        MeshStep step{mesh.positions, {}, {}};
        for (Vec3f& p : step.positions) p.x += float(way);
        mesh.motion.push_back(step);
      }
      if (c.camera > 0) view.motion.push_back(look * translation(-kWay * c.camera * share, 0, 0));
    }
    b.place(b.add_mesh(mesh));
    if (!c.vertices && c.object > 0) b.description.instances[0].motion = transforms;
    const CaseName name{"23", c.what};
    const RenderSettings s = settings_for(name, 64);
    const RenderedImage image = render(*b.build(), view, s);
    for (const int column : {4, 8, 12, 16, 24, 28}) {
      // The tolerance of 1e-5 covers the midpoint rule over time.
      expect_column(image, column, bar_coverage(kFrom, kTo, kWay, left_of(column)), 1e-5, "23",
                    c.what, s);
    }
  }
}

// A wedge rotates around its tip. It covers every part of the disc for the same time, so the disc
// is uniform. If vertices moved along chords, a star would appear.
TEST(Motion, BladeIsADisc) {
  constexpr double kWedge = kPiD / 6;  // radians
  for (const int steps_of_turn : {3, 8}) {
    SceneBuilderForTests b;
    MeshDescription blade;
    blade.name = "blade";
    blade.positions = {{0, 0, 0}, {3, 0, 0}, {3, float(3 * std::tan(kWedge)), 0}};
    blade.triangles = {{0, 1, 2}};
    blade.material = b.add_material(emitter(Rgb(1.0f)));
    b.place(b.add_mesh(blade));
    constexpr int kTurns = 3;
    for (int i = 1; i <= kTurns * steps_of_turn; ++i) {
      b.description.instances[0].motion.push_back(turned(2 * kPiD * i / steps_of_turn));
    }
    const std::string what =
        "blade, three turns in " + std::to_string(kTurns * steps_of_turn) + " steps";
    RenderSettings s = settings_for({"23", what}, 256);
    const RenderedImage image = render(*b.build(), front_view(), s);
    Moments values;
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        if (std::abs(x - kSide / 2 + .5) > 2 || std::abs(y - kSide / 2 + .5) > 2) {
          values.add(double(image.rgb(x, y).y));
        }
      }
    }
    // The tolerance is 1e-5, since Embree approximates arcs by a short polynomial.
    expect_case({"23", what}, {kWedge / (2 * kPiD), values.mean(), values.standard_error(), 1e-5},
                replay(s));
    // Pixels differ only by noise. Each sample is inside or outside the wedge, and 256 stratified
    // samples vary less than random ones.
    const double chance = kWedge / (2 * kPiD) * (1 - kWedge / (2 * kPiD)) / 256;
    EXPECT_LT(values.variance(), chance);
  }
}

// The wedge makes a quarter turn. It covers a point from the arrival of its first edge until its
// second edge has passed.
TEST(Motion, SectorIsLinearInAngle) {
  constexpr double kWedge = kPiD / 12, kTurn = kPiD / 2;
  SceneBuilderForTests b;
  MeshDescription blade;
  blade.positions = {{0, 0, 0}, {3, 0, 0}, {3, float(3 * std::tan(kWedge)), 0}};
  blade.triangles = {{0, 1, 2}};
  blade.material = b.add_material(emitter(Rgb(1.0f)));
  b.place(b.add_mesh(blade));
  b.description.instances[0].motion = {turned(kTurn / 2), turned(kTurn)};
  const auto scene = b.build();
  for (const double angle : {.1, .3, .8, 1.5, 1.7}) {
    const std::string what = "sector at " + format_value(angle) + " rad";
    RenderSettings s = settings_for({"23", what}, 1024);
    s.width = s.height = 8;
    const Vec3d at(.7 * std::cos(angle), .7 * std::sin(angle), 0);
    const RenderedImage image = render(*scene, orthographic(at + Vec3d(0, 0, 5), at, 1e-4), s);
    // The part of the turn from the arrival of the first edge at `angle` to that of the second
    // edge.
    const double covered =
        std::max(0.0, std::min(kTurn, angle) - std::max(0.0, angle - kWedge)) / kTurn;
    // The tolerance of 2e-4 covers the polynomial arc, and the view's width of 3e-4 radians.
    expect_case({"23", what}, compared(image, covered, 2e-4), replay(s));
  }
}

// ---- light from moving emitters ----------------------------------------------------------------

// Tests a white floor under a square lamp that moves by `pose`. The exact E is the mean of
// Lambert's formula at many times.
template <class Pose>
void expect_moving_lamp(const std::string& what, const Pose& pose, int steps, bool vertices,
                        bool two_sided) {
  const Vec3d corners[] = {{-.3, 0, .2}, {.1, 0, .2}, {.1, 0, -.2}, {-.3, 0, -.2}};
  SceneBuilderForTests b = white_floor();
  MaterialDescription shining = emitter(Rgb(5.0f));
  shining.double_sided = two_sided;
  MeshDescription lamp;
  lamp.material = b.add_material(shining);
  lamp.name = "lamp";
  lamp.triangles = {{0, 2, 1}, {0, 3, 2}};  // faces down
  for (int i = 0; i < steps; ++i) {
    const Mat44d m = pose(double(i) / (steps - 1));
    std::vector<Vec3f> positions;
    for (const Vec3d& c : corners) {
      positions.push_back(Vec3f(vertices ? transform_point(m, c) : c));
    }
    if (i == 0) {
      lamp.positions = positions;
    } else if (vertices) {
      lamp.motion.push_back({positions, {}, {}});
    }
  }
  b.place(b.add_mesh(lamp), vertices ? Mat44d() : pose(0));
  for (int i = 1; i < steps && !vertices; ++i) {
    b.description.instances.back().motion.push_back(pose(double(i) / (steps - 1)));
  }
  double exact = 0;
  constexpr int kTimes = 2000;
  for (int i = 0; i < kTimes; ++i) {
    const double time = (i + .5) / kTimes;
    std::vector<Vec3d> down;
    for (int c = 3; c >= 0; --c) down.push_back(transform_point(pose(time), corners[c]));
    const Vec3d point(.3, 0, .1), up(0, 1, 0);
    const double e = polygon_irradiance(down, point, up);
    const Vec3d face = cross(down[1] - down[0], down[2] - down[0]);
    if (two_sided || dot(face, point - down[0]) > 0) exact += 5 * std::abs(e) / kTimes;
  }
  // The tolerance of 2e-5 covers floats and the midpoint rule over time.
  expect_irradiance_at("E45", b, exact, 2e-5, what);
}

TEST(Motion, LampsThatMove) {
  const auto shift = [](double t) { return translation(-.5 + 1.4 * t, .8, .3 * t); };
  expect_moving_lamp("lamp that passes", shift, 2, false, false);
  expect_moving_lamp("lamp that passes, two-sided", shift, 3, false, true);
  expect_moving_lamp("lamp whose vertices pass", shift, 2, true, false);
  const auto turn = [](double t) { return turned(1.5 * t) * translation(.2, .9, 0); };
  expect_moving_lamp("lamp that tilts", turn, 3, false, false);
  const auto around = [](double t) { return turned(2 * kPiD * t) * translation(.2, .9, 0); };
  expect_moving_lamp("lamp that turns over", around, 5, false, false);
  expect_moving_lamp("lamp that turns over, two-sided", around, 4, false, true);
  const auto grow = [](double t) { return scaling(.5 + t) * translation(.2, .7, 0); };
  expect_moving_lamp("lamp that grows", grow, 2, false, false);
}

TEST(Motion, PointLightsThatMoveAndBlink) {
  SceneBuilderForTests b = white_floor();
  b.add_point_light({-.4, .5, .1}, Rgb(1.0f));
  PunctualLightDescription& light = b.description.lights[0];
  const Vec3d stops[] = {{-.4, .5, .1}, {.4, .8, .1}, {.6, .5, -.3}};
  const double strengths[] = {1, 0, 3};
  for (int i = 1; i < 3; ++i) {
    light.motion.push_back(translation(stops[i].x, stops[i].y, stops[i].z));
  }
  light.intensity = Rgb(3.0f);
  light.share = over_time<Rgb>({0, .5f, 1}, {Rgb(1 / 3.0f), Rgb(0.0f), Rgb(1.0f)});
  double exact = 0;
  constexpr int kTimes = 20000;
  for (int i = 0; i < kTimes; ++i) {
    const double scaled = 2 * (i + .5) / kTimes;
    const int step = scaled < 1 ? 0 : 1;
    const double share = scaled - step;
    const Vec3d at = stops[step] + (stops[step + 1] - stops[step]) * share;
    const double strength = strengths[step] + (strengths[step + 1] - strengths[step]) * share;
    const Vec3d to = at - Vec3d(.3, 0, .1);
    exact += strength * to.y / std::pow(to.length(), 3) / kTimes;
  }
  expect_irradiance_at("E45", b, exact, 1e-5, "point light that moves and blinks");
}

TEST(Motion, ASunThatTurns) {
  SceneBuilderForTests b = white_floor();
  PunctualLightDescription sun;
  sun.type = PunctualType::kDirectional;
  sun.intensity = Rgb(2.0f);
  constexpr int kSteps = 32;
  for (int i = 0; i <= kSteps; ++i) {
    // The sun turns from -80 to 80 degrees from the vertical. It shines along its -Z axis.
    const double angle = (-80 + 160.0 * i / kSteps) * kPiD / 180;
    const Mat44d m =
        look_at_matrix({std::sin(angle), std::cos(angle), 0}, {0, 0, 0}, Vec3d(0, 0, 1));
    if (i == 0) {
      sun.to_world = m;
    } else {
      sun.motion.push_back(m);
    }
  }
  b.description.lights.push_back(sun);
  const double edge = 80 * kPiD / 180;
  // The tolerance is 5e-4, since the sun follows normalised chords of 5 degrees instead of arcs.
  // The error is at most 1 - cos of half that angle.
  expect_irradiance_at("E45", b, 2 * std::sin(edge) / edge, 5e-4, "sun that turns");
}

// ---- views of moving surfaces ------------------------------------------------------------------

// A floor that tilts under a light straight above shows the cosine of its angle. It moves by a
// transform, or by vertices, whose paths are straight. It has vertex normals or none.
TEST(Motion, NormalsAreThoseOfTheTime) {
  constexpr double kAngle = 1.2;
  for (const bool vertices : {false, true}) {
    for (const bool normals : {false, true}) {
      SceneBuilderForTests b;
      MeshDescription floor;
      const float wide = 100;
      floor.positions = {{-wide, 0, wide}, {wide, 0, wide}, {wide, 0, -wide}, {-wide, 0, -wide}};
      floor.triangles = {{0, 1, 2}, {0, 2, 3}};
      floor.material = b.add_material(lambert(Rgb(1.0f)));
      if (normals) floor.normals.assign(4, Vec3f(0, 1, 0));
      if (vertices) {
        MeshStep step{floor.positions, floor.normals, {}};
        for (Vec3f& p : step.positions) p.y = p.x * float(std::tan(kAngle));
        for (Vec3f& n : step.normals)
          n = Vec3f(float(-std::sin(kAngle)), float(std::cos(kAngle)), 0);
        floor.motion = {step};
      }
      b.place(b.add_mesh(floor));
      if (!vertices) b.description.instances[0].motion = {turned(kAngle)};
      PunctualLightDescription light;
      light.type = PunctualType::kDirectional;
      light.to_world = look_at_matrix({0, 1, 0}, {0, 0, 0});
      b.description.lights.push_back(light);
      double exact = 0;
      constexpr int kTimes = 20000;
      for (int i = 0; i < kTimes; ++i) {
        const double t = (i + .5) / kTimes;
        const double flat = vertices ? std::atan(t * std::tan(kAngle)) : kAngle * t;
        // Vertex normals are also interpolated linearly, and then normalised.
        const double smooth = vertices && normals
                                  ? std::atan2(t * std::sin(kAngle), 1 - t + t * std::cos(kAngle))
                                  : flat;
        const auto alpha2 = terminator_alpha2(float(std::cos(flat - smooth)));
        const double cosine =
            std::cos(smooth) * double(terminator_factor(float(std::cos(flat)), alpha2));
        exact += cosine / kPiD / kTimes;
      }
      const std::string what = std::string(vertices ? "floor of vertices" : "floor") +
                               " that tilts" + (normals ? ", with normals" : "");
      RenderSettings s = settings_for({"E46", what}, 1024);
      s.width = s.height = 8;
      const auto view = orthographic({0, 1000, 0}, {0, 0, 0}, 1e-3);
      expect_exact(render(*b.build(), view, s), exact, 2e-5, s, {"E46", what});
    }
  }
}

// A mirror at 45 degrees that approaches by kWay shifts its reflection by kWay.
TEST(Motion, AMirrorThatMoves) {
  constexpr double kWay = .6;
  SceneBuilderForTests b;
  const int mirror = b.add_material(metal(Rgb(1.0f), 0));
  // The mirror passes through the origin and faces (-1, 0, 1), so a ray along -Z leaves along -X.
  MeshDescription glass;
  glass.positions = {{-3, -3, -3}, {3, -3, 3}, {3, 3, 3}, {-3, 3, -3}};
  glass.triangles = {{0, 1, 2}, {0, 2, 3}};
  glass.material = mirror;
  b.place(b.add_mesh(glass));
  b.description.instances[0].motion = {translation(0, 0, kWay)};
  // A wall at x = -4 emits above z = .1.
  b.add_quad({-4, -3, .1f}, {-4, 3, .1f}, {-4, 3, 9}, {-4, -3, 9},
             b.add_material(emitter(Rgb(1.0f))));
  const auto scene = b.build();
  // At time t, a ray at x hits the mirror at z = x + kWay t.
  for (const double x : {-.6, -.3, 0.0, .05, .2}) {
    const std::string what = "mirror that moves, seen at " + format_value(x);
    RenderSettings s = settings_for({"E46", what}, 1024);
    s.width = s.height = 8;
    const auto view = orthographic({x, 0, 8}, {x, 0, 0}, 1e-4);
    const double exact = std::clamp(1 - (.1 - x) / kWay, 0.0, 1.0);
    // The tolerance is 2e-4, since the view is 2e-4 wide and the mirror moves by 0.6.
    expect_case({"E46", what}, compared(render(*scene, view, s), exact, 2e-4), replay(s));
  }
}

// ---- rays that stay inside ---------------------------------------------------------------------

// A moving ball with flat faces, seen from inside. Its vertices lie on a sphere, so no ray from a
// face can hit that face.
struct MovingShell {
  std::string what;
  std::vector<Mat44d> transforms;
  float grow;  // factor by which the vertices grow
};

// Counts what goes wrong on paths that bounce randomly from face to face, each path at its own
// time.
struct Bounces {
  double escaped = 0, self_hits = 0;
};
Bounces bounce_within(const Scene& scene, const MovingShell& shell) {
  Bounces result;
  const auto steps = double(shell.transforms.size() - 1);
  for (uint64_t path = 0; path < 4000; ++path) {
    TestRandom random(44, path);
    const float time = random.next();
    const double scaled = double(time) * steps;
    const auto step = size_t(std::min(scaled, steps - 1));
    const auto middle = [&](size_t i) {
      const Mat44d& m = shell.transforms[i];
      return (Vec3d(m[3][0], m[3][1], m[3][2]) - scene.origin()) * scene.scale();
    };
    const Vec3d from = middle(step) + (middle(step + 1) - middle(step)) * (scaled - double(step));
    Ray ray{Vec3f(from), square_to_sphere(random.vec2()), kInfinity, time};
    SurfaceHit last{.instance = ~0u}, hit;
    for (int i = 0; i < 50; ++i) {
      if (!scene.intersect(ray, {}, &hit)) {
        ++result.escaped;
        break;
      }
      result.self_hits += hit.instance == last.instance && hit.primitive == last.primitive;
      last = hit;
      SurfaceInteraction s;
      scene.interaction(hit, time, &s);
      Vec3f direction = square_to_sphere(random.vec2());
      if (dot(direction, s.geometric_normal) < 0) direction = -direction;
      ray = {offset_ray_origin(s.position, s.geometric_normal, s.offset, direction), direction,
             kInfinity, time};
    }
  }
  return result;
}

TEST(Motion, RaysLeaveMovingFacesOnTheirSide) {
  const Mat44d far = translation(500, -30, 7);
  const MovingShell shells[] = {
      {"turning", {Mat44d(), turned(2), turned(4)}, 1},
      {"passing far away", {far, turned(.5) * far * translation(40, 9, 0)}, 1},
      {"growing a thousandfold", {scaling(1e-3), Mat44d()}, 1},
      {"tiny", {scaling(1e-6), turned(1) * scaling(1e-6) * translation(1e-6, 0, 0)}, 1},
      {"huge", {scaling(1e6), turned(1) * scaling(1e6) * translation(3e5, 0, 0)}, 1},
      {"of vertices that go outwards", {Mat44d(), Mat44d()}, 3},
  };
  for (const MovingShell& shell : shells) {
    SceneBuilderForTests b;
    MeshDescription ball =
        SceneBuilderForTests::sphere(1, 12, b.add_material(lambert(Rgb(.5f))), true);
    if (shell.grow != 1) {
      ball.motion.push_back({ball.positions, {}, {}});
      for (Vec3f& p : ball.motion[0].positions) p *= shell.grow;
    }
    b.place(b.add_mesh(ball), shell.transforms[0]);
    if (shell.grow == 1) {
      b.description.instances[0].motion.assign(shell.transforms.begin() + 1,
                                               shell.transforms.end());
    }
    b.set_environment(Rgb(1.0f));
    const Bounces bounces = bounce_within(*b.build(), shell);
    const std::string replay = "TestRandom(44, path)";
    expect_case({"E44", "rays lost from a shell, " + shell.what}, {0, bounces.escaped, 0, 0},
                replay);
    expect_case({"E44", "rays that met the face they left, " + shell.what},
                {0, bounces.self_hits, 0, 0}, replay);
  }
}

// ---- blur is the mean of instants ---------------------------------------------------------------

// Everything moves: instances, vertices, lamps, lights and the camera. The scene contains glass,
// coverage and a mirror.
TEST(Motion, BlurIsTheMeanOfInstants) {
  constexpr int kInstants = 64;
  const MovingScene moving;
  const CaseName name{"E47", "everything moves, whole frame"};
  RenderSettings s = settings_for(name, long_or_short(256u, 64u));
  s.max_depth = 6;
  const MeasuredMean blurred = mean_of(*moving.at_all_times().build(), moving.view(), s);
  double sum = 0, variance = 0;
  for (int i = 0; i < kInstants; ++i) {
    const double time = (i + .5) / kInstants;
    s.seed++;
    s.spp = long_or_short(32u, 8u);
    const MeasuredMean still = mean_of(*moving.at(time).build(), moving.view_at(time), s);
    sum += still.mean / kInstants;
    variance += square(still.standard_error / kInstants);
  }
  // The tolerance is 1e-3, since the instants are the middles of 64 intervals, and their means vary
  // by a third.
  expect_case(
      name,
      {sum, blurred.mean, std::hypot(blurred.standard_error, std::sqrt(variance)), 1e-3 * sum},
      replay(s));
}

}  // namespace
}  // namespace emberline
