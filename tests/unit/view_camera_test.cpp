#include "renderer/app/view/view_camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "renderer/core/constants.h"
#include "renderer/scene/camera.h"
#include "renderer/scene/scene_description.h"

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

// The camera that a renderer makes of the edit.
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
  EXPECT_NEAR(a.fov_y, b.fov_y, 1e-12);
}

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

// At the size of a room, of a micrometre and of a thousand kilometres.
TEST_P(ViewCameraTest, LooksLikeTheCameraThatItComesFrom) {
  for (const double scale : {1.0, 1e-6, 1e6}) {
    const CameraDescription camera =
        camera_at(GetParam().from * scale, GetParam().at * scale, GetParam().up);
    const ViewCamera view = view_of(camera, Vec3d(0.3, 0.1, -0.2) * scale, scale);
    expect_same_picture(camera, camera_of(edit_of(view)), 10 * scale);
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
  EXPECT_EQ(view.roll, before.roll);  // the horizon does not creep
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
  // There the picture's right is still +X, and one can turn on.
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

// A point at the pivot's depth follows the cursor: by a tenth of the frame for a tenth.
TEST(ViewCamera, PansWithTheCursor) {
  for (const double scale : {1.0, 1e-6, 1e6}) {
    const ViewCamera view =
        view_of(camera_at(Vec3d(0, 0, 4) * scale, Vec3d(0.0)), Vec3d(0.0), scale);
    const ViewCamera moved = pan(view, 0.1, 0.2);
    // The height of the frame at distance 4: 8 tan(0.3).
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
  EXPECT_EQ(near.distance, view.least_distance);
  EXPECT_GT(near.distance, 0.0);
  EXPECT_EQ(far.distance, view.most_distance);
  EXPECT_TRUE(std::isfinite(far.eye().z));
}

TEST(ViewCamera, FliesAlongThePicturesAxes) {
  const ViewCamera view = view_of(camera_at({0, 1, 4}, {0, 1, 0}), Vec3d(0.0), 1.0);
  expect_near(fly(view, 1, 2, 3).eye(), {1, 3, 1}, 1e-12, "eye");
  expect_near(fly(view, 1, 2, 3).axes().back, view.axes().back, 0.0, "the view stays");
}

TEST(ViewCamera, KeepsTheAngleInItsRange) {
  const ViewCamera view;
  EXPECT_EQ(with_fov(view, 1.0).fov_y, 1.0);
  EXPECT_EQ(with_fov(view, -1.0).fov_y, kLeastFov);
  EXPECT_EQ(with_fov(view, 10.0).fov_y, kMostFov);
}

TEST(ViewCamera, LooksTowardsAPoint) {
  const ViewCamera view = view_of(camera_at({1, 2, 3}, Vec3d(0.0)), Vec3d(0.0), 1.0);
  const ViewCamera moved = look_towards(view, {1, 2, -1});
  expect_near(moved.eye(), {1, 2, 3}, 1e-12, "eye");
  expect_near(moved.axes().back, {0, 0, 1}, 1e-12, "back");
  EXPECT_NEAR(moved.distance, 4.0, 1e-12);
  const ViewCamera same = look_towards(view, view.eye());
  EXPECT_EQ(same.pivot, view.pivot);
}

TEST(ViewCamera, TakesAPivotWithoutMoving) {
  const ViewCamera view = view_of(camera_at({0, 0, 5}, Vec3d(0.0)), Vec3d(0.0), 1.0);
  const ViewCamera moved = with_pivot_at(view, {0.7, -0.4, 2});
  expect_near(moved.eye(), view.eye(), 1e-12, "eye");
  expect_near(moved.pivot, {0, 0, 2}, 1e-12, "at the point's depth, on the axis");
}

// The sphere's outline is a cone about the axis of half angle asin(radius / distance).
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

// Its extent at the scene's centre is that of the camera that has no perspective.
TEST(ViewCamera, GivesAnOrthographicCameraAPerspective) {
  CameraDescription camera = camera_at({0, 0, 50}, Vec3d(0.0));
  camera.orthographic = true;
  camera.y_mag = 1.5;
  const ViewCamera view = view_of(camera, {0, 0, 1}, 2.0);
  expect_near(view.pivot, {0, 0, 1}, 1e-12, "pivot");
  EXPECT_NEAR(view.distance * std::tan(view.fov_y / 2), 1.5, 1e-12);
  expect_near(view.axes().back, {0, 0, 1}, 1e-12, "back");
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
