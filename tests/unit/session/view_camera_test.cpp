#include "renderer/session/view_camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "renderer/core/constants.h"
#include "renderer/description/framing.h"
#include "renderer/description/scene_description.h"
#include "renderer/scene/camera.h"

namespace emberline {
namespace {

CameraDescription camera_at(const Vec3d& from, const Vec3d& at, const Vec3d& up = {0, 1, 0}) {
  CameraDescription camera;
  camera.fov_y = 0.6;
  camera.to_world = look_at_matrix(from, at, up);
  return camera;
}

Vec3d row(const Mat44d& m, int i) { return {m[i][0], m[i][1], m[i][2]}; }

void expect_near(const Vec3d& a, const Vec3d& b, double tolerance, const char* what) {
  EXPECT_LE((a - b).length(), tolerance) << what << ": " << a.x << " " << a.y << " " << a.z
                                         << " against " << b.x << " " << b.y << " " << b.z;
}

// Returns the camera that a renderer makes of the edit.
CameraDescription camera_of(const CameraEdit& edit) {
  SceneEdits edits;
  edits.camera = edit;
  return edited_camera(edits, {}, {});
}

void expect_same_picture(const CameraDescription& a, const CameraDescription& b, double scale) {
  for (int i = 0; i < 3; ++i) {
    expect_near(row(a.to_world, i).normalized(), row(b.to_world, i).normalized(), 1e-9, "axis");
  }
  expect_near(row(a.to_world, 3), row(b.to_world, 3), 1e-9 * scale, "eye");
  EXPECT_EQ(a.to_world.determinant() < 0, b.to_world.determinant() < 0) << "mirroring";
  EXPECT_EQ(a.orthographic, b.orthographic);
  if (a.orthographic) {
    EXPECT_NEAR(a.y_mag, b.y_mag, 1e-12 * a.y_mag);
  } else {
    EXPECT_NEAR(a.fov_y, b.fov_y, 1e-12);
  }
}

// The kinds of camera that a file can have.
struct Kind {
  const char* name;
  bool orthographic, mirrored;
};
const Kind kKinds[] = {{"perspective", false, false},
                       {"mirrored perspective", false, true},
                       {"orthographic", true, false},
                       {"mirrored orthographic", true, true}};

CameraDescription of_kind(CameraDescription camera, const Kind& kind, double half_height) {
  camera.orthographic = kind.orthographic;
  camera.y_mag = half_height;
  // This mirrors the camera like a node that is scaled by (-1, 1, 1).
  for (int c = 0; c < 3 && kind.mirrored; ++c) camera.to_world[0][c] = -camera.to_world[0][c];
  return camera;
}

// The point at which the renderer's ray through a frame position hits the pivot's plane, relative
// to the pivot and in multiples of `unit`. Positions are in frame heights from the centre, to the
// right and down.
Vec3d point_at_pivot(const ViewCamera& view, double right, double down, double unit) {
  constexpr int kSide = 100;
  const Camera camera(camera_of(edit_of(view)), kSide, kSide, view.pivot, 1.0 / unit);
  const Ray ray = camera.ray({float(kSide * (0.5 + right)), float(kSide * (0.5 + down))});
  const Vec3d from = to_double(ray.origin), along = to_double(ray.direction);
  const Vec3d back = view.axes().back;
  return from - along * (from.dot(back) / along.dot(back));
}

// The horizontal part of a direction. Orbits and the horizon are relative to +Y.
Vec3d level_part(const Vec3d& v) { return {v.x, 0.0, v.z}; }

struct Pose {
  const char* name;
  Vec3d from, at, up;
};
const Pose kPoses[] = {
    {"level", {0, 0, 5}, {0, 0, 0}, {0, 1, 0}},
    {"oblique", {3, 2, -4}, {0.5, 0.2, 0.1}, {0, 1, 0}},
    {"behind", {0, 0, -5}, {0, 0, 0}, {0, 1, 0}},
    {"tipped", {3, 2, -4}, {0.5, 0.2, 0.1}, {0.4, 1, 0.3}},
    {"upside_down", {3, 2, -4}, {0, 0, 0}, {0, -1, 0}},
    {"down", {1, 4, 2}, {1, 0, 2}, {0, 1, 0}},
    {"down_turned", {1, 4, 2}, {1, 0, 2}, {0.6, 0, 0.8}},
    {"up", {1, -4, 2}, {1, 0, 2}, {1, 0, 0}},
    {"nearly_down", {1, 4, 2}, {1 + 1e-7, 0, 2}, {0, 0, -1}},
};

class ViewCameraTest : public ::testing::TestWithParam<Pose> {};
INSTANTIATE_TEST_SUITE_P(Poses, ViewCameraTest, ::testing::ValuesIn(kPoses),
                         [](const auto& pose) { return pose.param.name; });

// The distances are those of a room, of a micrometre and of a thousand kilometres.
TEST_P(ViewCameraTest, LooksLikeTheCameraThatItComesFrom) {
  for (const double scale : {1.0, 1e-6, 1e6}) {
    for (const Kind& kind : kKinds) {
      SCOPED_TRACE(kind.name);
      const CameraDescription camera =
          of_kind(camera_at(GetParam().from * scale, GetParam().at * scale, GetParam().up), kind,
                  1.3 * scale);
      const ViewCamera view = view_of(camera, Vec3d(0.3, 0.1, -0.2) * scale, scale);
      expect_same_picture(camera, camera_of(edit_of(view)), 10 * scale);
    }
  }
}

// Mouse moves keep an orthographic camera orthographic and a mirrored one mirrored.
TEST_P(ViewCameraTest, EveryMoveKeepsTheKind) {
  for (const Kind& kind : kKinds) {
    SCOPED_TRACE(kind.name);
    const ViewCamera view =
        view_of(of_kind(camera_at(GetParam().from, GetParam().at, GetParam().up), kind, 1.3),
                Vec3d(0.3, 0.1, -0.2), 1.0);
    const Vec3d point = view.pivot + view.axes().right * 0.2 + view.axes().up * 0.1;
    for (const ViewCamera& moved :
         {orbit(view, 0.3, 0.1), turn(view, 0.2, 0.1), pan(view, 0.1, 0.2), dolly(view, 0.7),
          fly(view, 1, 2, 3), look_towards(view, point), frame_all(view, Vec3d(0.0), 1.0, 1.5)}) {
      const CameraDescription camera = camera_of(edit_of(moved));
      EXPECT_EQ(camera.orthographic, kind.orthographic);
      EXPECT_EQ(camera.to_world.determinant() < 0, kind.mirrored);
    }
  }
}

// The dragged point stays under the cursor, and right stays right in the picture, however the
// picture is rotated, mirrored or projected.
TEST_P(ViewCameraTest, TheScenesMoveIsTheHandsInThePicture) {
  for (const double scale : {1.0, 1e-6, 1e6}) {
    for (const Kind& kind : kKinds) {
      SCOPED_TRACE(std::string(kind.name) + " at " + std::to_string(scale));
      const ViewCamera view =
          view_of(of_kind(camera_at(GetParam().from * scale, GetParam().at * scale, GetParam().up),
                          kind, 1.3 * scale),
                  Vec3d(0.3, 0.1, -0.2) * scale, scale);
      const ViewCamera panned = pan(view, 0.1, 0.2);
      const Vec3d shift = (panned.pivot - view.pivot) / scale;
      expect_near(point_at_pivot(panned, 0.15, 0.1, scale) + shift,
                  point_at_pivot(view, 0.05, -0.1, scale), 1e-4, "panned");
      const Vec3d right = point_at_pivot(view, 0.1, 0, scale).normalized();
      const Vec3d up = point_at_pivot(view, 0, -0.1, scale).normalized();
      expect_near(view.axes().right, right, 1e-4, "right");
      expect_near(view.axes().up, up, 1e-4, "up");
      const ViewCamera flown = fly(view, 0.1 * scale, 0.2 * scale, 0.0);
      expect_near((flown.eye() - view.eye()) / scale, right * 0.1 + up * 0.2, 1e-4, "flown");
      // For small angles, an orbit moves the eye to the picture's right, and a turn turns it to the
      // left. Seen from straight above, or upside down, a turntable orbits differently.
      if (level_part(view.axes().back).length() < 0.1 || view.axes().up.y < 0) continue;
      const Vec3d orbited = orbit(view, 0.01, 0.0).eye() - view.eye();
      EXPECT_GT(orbited.dot(level_part(right)), 0.0) << "orbited";
      const Vec3d turned = turn(view, 0.01, 0.0).axes().back - view.axes().back;
      EXPECT_GT(turned.dot(level_part(right)), 0.0) << "turned";
    }
  }
}

TEST_P(ViewCameraTest, OrbitingKeepsThePivotInTheMiddleAndTheDistance) {
  const CameraDescription camera = camera_at(GetParam().from, GetParam().at, GetParam().up);
  ViewCamera view = view_of(camera, Vec3d(0.0), 1.0);
  const ViewCamera before = view;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> angle(-0.7, 0.7);
  for (int i = 0; i < 1000; ++i) view = orbit(view, angle(random), angle(random));
  EXPECT_EQ(view.pivot, before.pivot);
  EXPECT_EQ(view.distance, before.distance);
  EXPECT_EQ(view.roll, before.roll);  // the horizon does not drift
  const ViewCamera::Axes axes = view.axes();
  EXPECT_NEAR(axes.right.dot(axes.up), 0.0, 1e-12);
  EXPECT_NEAR(axes.right.cross(axes.up).dot(axes.back), 1.0, 1e-12);
  const CameraDescription after = camera_of(edit_of(view));
  expect_near(row(after.to_world, 3) - row(after.to_world, 2) * view.distance, view.pivot, 1e-9,
              "pivot");
}

TEST(ViewCamera, OrbitsByTheAngle) {
  const ViewCamera view = view_of(camera_at({0, 0, 2}, Vec3d(0.0)), Vec3d(0.0), 1.0);
  expect_near(orbit(view, kPiD / 2, 0).eye(), {2, 0, 0}, 1e-12, "a quarter turn to the right");
  expect_near(orbit(view, 0, kPiD / 4).eye(), {0, std::sqrt(2.0), std::sqrt(2.0)}, 1e-12, "up");
  expect_near(orbit(view, 0, 10).eye(), {0, 2, 0}, 1e-12, "no further than straight up");
  // There the picture's right is still +X, and orbiting can continue.
  expect_near(orbit(view, 0, 10).axes().right, {1, 0, 0}, 1e-12, "right edge");
  expect_near(orbit(orbit(view, 0, 10), kPiD / 2, 0).axes().right, {0, 0, -1}, 1e-12, "turned");
  expect_near(orbit(orbit(view, 0, 10), 0, -kPiD / 2).eye(), {0, 0, 2}, 1e-12, "and back");
}

TEST(ViewCamera, TurnsInPlace) {
  const ViewCamera view = view_of(camera_at({1, 2, 3}, {1, 2, 0}), {1, 2, 0}, 1.0);
  const ViewCamera left = turn(view, kPiD / 2, 0);
  expect_near(left.eye(), {1, 2, 3}, 1e-12, "eye");
  expect_near(left.axes().back, {1, 0, 0}, 1e-12, "looks along -X");
  expect_near(turn(view, 0, kPiD / 4).axes().back, Vec3d(0, -1, 1).normalized(), 1e-12, "upwards");
}

// A point at the pivot's depth follows the cursor. It moves by a tenth of the frame if the cursor
// does.
TEST(ViewCamera, PansWithTheCursor) {
  for (const double scale : {1.0, 1e-6, 1e6}) {
    const ViewCamera view =
        view_of(camera_at(Vec3d(0, 0, 4) * scale, Vec3d(0.0)), Vec3d(0.0), scale);
    const ViewCamera moved = pan(view, 0.1, 0.2);
    // At distance 4, the height of the frame is 8 tan(0.3).
    const double height = 8 * std::tan(0.3) * scale;
    expect_near(moved.pivot, Vec3d(-0.1, 0.2, 0) * height, 1e-12 * scale, "pivot");
    expect_near(moved.eye() - moved.pivot, view.eye() - view.pivot, 1e-12 * scale, "view");
  }
}

TEST(ViewCamera, DolliesInProportion) {
  const ViewCamera view = view_of(camera_at({0, 0, 4}, Vec3d(0.0)), Vec3d(0.0), 1.0);
  expect_near(dolly(view, 0.5).eye(), {0, 0, 2}, 1e-12, "half of the way");
  ViewCamera near = view, far = view;
  for (int i = 0; i < 500; ++i) {
    near = dolly(near, 0.5);
    far = dolly(far, 2.0);
  }
  EXPECT_EQ(near.distance, view.min_distance);
  EXPECT_GT(near.distance, 0.0);
  EXPECT_EQ(far.distance, view.max_distance);
  EXPECT_TRUE(std::isfinite(far.eye().z));
}

TEST(ViewCamera, FliesAlongThePicturesAxes) {
  const ViewCamera view = view_of(camera_at({0, 1, 4}, {0, 1, 0}), Vec3d(0.0), 1.0);
  expect_near(fly(view, 1, 2, 3).eye(), {1, 3, 1}, 1e-12, "eye");
  expect_near(fly(view, 1, 2, 3).axes().back, view.axes().back, 0.0, "the view stays");
}

TEST(ViewCamera, KeepsTheAngleInItsRange) {
  const ViewCamera view;
  EXPECT_EQ(to_perspective(view, 1.0).fov_y, 1.0);
  EXPECT_EQ(to_perspective(view, -1.0).fov_y, kMinFov);
  EXPECT_EQ(to_perspective(view, 10.0).fov_y, kMaxFov);
}

TEST_P(ViewCameraTest, ChangingTheProjectionKeepsTheOrbitCentre) {
  for (const double scale : {1.0, 1e-6, 1e6}) {
    for (const bool mirrored : {false, true}) {
      const Kind kind{"perspective", false, mirrored};
      const ViewCamera view =
          view_of(of_kind(camera_at(GetParam().from * scale, GetParam().at * scale, GetParam().up),
                          kind, 0),
                  Vec3d(0.3, 0.1, -0.2) * scale, scale);
      const ViewCamera flat = to_orthographic(view);
      EXPECT_TRUE(camera_of(edit_of(flat)).orthographic);
      EXPECT_EQ(flat.eye(), view.eye());
      for (const double right : {-0.4, 0.0, 0.3}) {
        expect_near(point_at_pivot(flat, right, 0.2, scale),
                    point_at_pivot(view, right, 0.2, scale), 1e-4, "at the pivot");
      }
      const ViewCamera back = to_perspective(flat, view.fov_y);
      EXPECT_FALSE(camera_of(edit_of(back)).orthographic);
      expect_near(back.eye() / scale, view.eye() / scale, 1e-12, "and back");
      // Enlarging the picture without perspective brings the camera closer once it has perspective
      // again.
      EXPECT_NEAR(to_perspective(dolly(flat, 0.5), view.fov_y).distance, 0.5 * view.distance,
                  1e-12 * view.distance);
    }
  }
}

TEST(ViewCamera, AnOrthographicOneIsEnlargedInsteadOfComingNearer) {
  const Kind flat{"orthographic", true, false};
  const ViewCamera view =
      view_of(of_kind(camera_at({0, 0, 50}, Vec3d(0.0)), flat, 2.0), Vec3d(0.0), 1.0);
  EXPECT_EQ(view.distance, 50.0);
  ViewCamera near = view, far = view;
  EXPECT_EQ(dolly(view, 0.5).half_height, 1.0);
  EXPECT_EQ(dolly(view, 0.5).eye(), view.eye());
  for (int i = 0; i < 500; ++i) {
    near = fly(dolly(near, 0.5), 0, 0, 0.1);
    far = dolly(far, 2.0);
  }
  EXPECT_EQ(near.half_height, view.min_distance);
  EXPECT_GT(near.half_height, 0.0);
  EXPECT_EQ(far.half_height, view.max_distance);
  EXPECT_EQ(far.eye(), view.eye());
  EXPECT_LT(fly(view, 0, 0, 1.0).half_height, 2.0);
  EXPECT_EQ(fly(view, 0, 0, 1.0).eye(), view.eye());
}

// The direction of view stays, and the whole sphere is in front of the eye, wherever the eye was.
TEST(ViewCamera, FramesEverythingWithoutPerspective) {
  const Kind flat{"orthographic", true, true};
  for (const double scale : {1.0, 1e-6, 1e6}) {
    const ViewCamera view =
        view_of(of_kind(camera_at(Vec3d(0.1, 0, 0) * scale, {0, 0, 0}), flat, 0.01 * scale),
                Vec3d(0.0), 2 * scale);
    for (const double aspect : {0.5, 1.0, 16.0 / 9}) {
      const ViewCamera all = frame_all(view, {0, 0, 0}, 2 * scale, aspect);
      EXPECT_GT(all.half_height * std::min(1.0, aspect), 2.0 * scale);
      EXPECT_LT(all.half_height * std::min(1.0, aspect), 2.2 * scale);
      EXPECT_GT(all.distance, 2.0 * scale);
      expect_near(all.axes().back, view.axes().back, 1e-12, "direction");
    }
  }
}

TEST(ViewCamera, AnOrthographicOneIsShiftedToAPoint) {
  const Kind flat{"orthographic", true, false};
  const ViewCamera view =
      view_of(of_kind(camera_at({0, 0, 5}, Vec3d(0.0)), flat, 2.0), Vec3d(0.0), 1.0);
  const ViewCamera moved = look_towards(view, {0.5, 1, 2});
  EXPECT_EQ(moved.pivot, Vec3d(0.5, 1, 2));
  expect_near(moved.eye(), {0.5, 1, 5}, 1e-12, "eye");
  expect_near(moved.axes().back, {0, 0, 1}, 1e-12, "direction");
  EXPECT_EQ(moved.half_height, 2.0);
}

// An orthographic edit has no lens, and changing the kind removes the members of the other kind.
TEST(ViewCamera, AnEditSaysOneKind) {
  CameraEdit before;
  before.f_stop = 2.0;
  before.focus_distance = 3.0;
  before.fov_y_degrees = 30.0;
  ViewCamera view = to_orthographic(ViewCamera());
  const CameraEdit flat = edit_of(view, before);
  EXPECT_FALSE(flat.f_stop || flat.focus_distance || flat.fov_y_degrees);
  EXPECT_EQ(flat.orthographic_height, view.frame_height());
  const CameraEdit deep = edit_of(to_perspective(view, 0.5), flat);
  EXPECT_FALSE(deep.orthographic_height);
  EXPECT_DOUBLE_EQ(*deep.fov_y_degrees, 0.5 * 180 / kPiD);
  EXPECT_EQ(edit_of(ViewCamera(), before).f_stop, 2.0);
}

TEST(ViewCamera, LooksTowardsAPoint) {
  const ViewCamera view = view_of(camera_at({1, 2, 3}, Vec3d(0.0)), Vec3d(0.0), 1.0);
  const ViewCamera moved = look_towards(view, {1, 2, -1});
  expect_near(moved.eye(), {1, 2, 3}, 1e-12, "eye");
  expect_near(moved.axes().back, {0, 0, 1}, 1e-12, "back");
  EXPECT_NEAR(moved.distance, 4.0, 1e-12);
  const ViewCamera same = look_towards(view, view.eye());
  EXPECT_EQ(same.pivot, view.pivot);
  // Looks straight down, with the previous roll.
  ViewCamera rolled = view;
  rolled.roll = 0.3;
  const ViewCamera down = look_towards(rolled, view.eye() - Vec3d(0, 5, 0));
  EXPECT_NEAR(down.azimuth, view.azimuth, 1e-12);
  EXPECT_EQ(down.roll, 0.3);
}

// The sphere's outline is a cone about the axis with half angle asin(radius / distance).
TEST(ViewCamera, FramesEverything) {
  const ViewCamera view = view_of(camera_at({3, 1, 2}, Vec3d(0.0)), Vec3d(0.0), 1.0);
  for (const double aspect : {0.5, 1.0, 16.0 / 9}) {
    const ViewCamera all = frame_all(view, {10, 20, 30}, 2.0, aspect);
    EXPECT_EQ(all.pivot, Vec3d(10, 20, 30));
    const double outline = std::tan(std::asin(2.0 / all.distance));
    const double edge = std::tan(view.fov_y / 2) * std::min(1.0, aspect);
    EXPECT_LT(outline, edge);
    EXPECT_GT(outline, 0.9 * edge);
  }
}

TEST(ViewCamera, PivotsBeforeTheEyeWhereTheSceneIsBehindIt) {
  const ViewCamera view = view_of(camera_at({0, 0, 5}, {0, 0, 9}), Vec3d(0.0), 2.0);
  EXPECT_NEAR(view.distance, 2.0, 1e-12);
  expect_near(view.pivot, {0, 0, 7}, 1e-12, "pivot");
}

TEST(ViewCamera, KeepsTheFilesCameraInTheEdit) {
  CameraEdit before;
  before.camera = EditTarget{"main", 2, {}};
  EXPECT_EQ(edit_of(ViewCamera(), before).camera, before.camera);
}

}  // namespace
}  // namespace emberline
