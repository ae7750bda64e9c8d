// Cameras, lights and instances beyond the range of float are refused by name, or they are safe to
// trace. Embree aborts on rays that it cannot handle.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "renderer/core/errors.h"
#include "renderer/scene/camera.h"
#include "support/render.h"
#include "support/scenes.h"

namespace emberline::test {
namespace {

Mat44d scaling(double s) {
  Mat44d m;
  m.setScale(Vec3d(s));
  return m;
}

// Returns a scene with a ball, and with two instances of another mesh, which they scale by
// `shrunk`.
std::unique_ptr<Scene> scene_of(double size, double shrunk) {
  SceneBuilderForTests b;
  const int material = b.add_material(lambert(Rgb(0.5f)));
  b.place(b.add_mesh(b.sphere(float(size), 4, material)));
  const int mesh = b.add_mesh(b.sphere(float(size / shrunk), 4, material));
  b.place(mesh, scaling(shrunk));
  b.place(mesh, scaling(shrunk) * translation(2 * size, 0, 0));
  b.description.environment = EnvironmentDescription{};
  return b.build();
}

// Traces rays across the frame. Returns false if the camera was refused.
bool trace_views(const Scene& scene, const CameraDescription& view, std::mt19937& random) {
  std::optional<Camera> camera;
  try {
    camera.emplace(view, 1280, 720, scene.origin(), scene.scale(), scene.max_origin());
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).find("camera 'extreme': "), 0u);
    return false;
  }
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  Vec2f film[kRayBatch], lens[kRayBatch];
  for (Vec2f& p : film) p = Vec2f(1280 * unit(random), 720 * unit(random));
  film[0] = Vec2f(640, 360);
  for (Vec2f& p : lens) p = Vec2f(unit(random), unit(random));
  Ray rays[kRayBatch];
  if (camera->has_lens()) {
    camera->rays(film, lens, rays);
  } else {
    camera->rays(film, rays);
  }
  for (const Ray& ray : rays) {
    EXPECT_TRUE(is_finite(ray.origin) && is_finite(ray.direction));
    EXPECT_NEAR(double(dot(ray.direction, ray.direction)), 1.0, 1e-3);
    SurfaceHit hit;
    if (!scene.intersect(ray, {}, &hit)) continue;
    SurfaceInteraction surface;
    scene.interaction(hit, 0, &surface);
    EXPECT_TRUE(is_finite(surface.position));
    scene.transmittance(surface.position, ray.origin, 0, {});
  }
  return true;
}

TEST(ExtremeCameras, AreRefusedOrTraced) {
  std::mt19937 random(1);
  const auto unit = [&] { return std::uniform_real_distribution<double>(-1, 1)(random); };
  // Returns a number of any magnitude. In a third of the cases the magnitude is ordinary.
  const auto any = [&] {
    const double exponent = random() % 3 == 0 ? 2 * unit()
                            : random() % 2    ? 25 * unit()
                                              : 320 * unit();
    return std::copysign(std::pow(10.0, exponent), unit());
  };
  int traced = 0, refused = 0;
  for (const double size : {1e-6, 1e-3, 1.0, 1e3, 1e6}) {
    for (const double shrunk : {1e-9, 1e-3, 1.0, 1e6}) {
      if (size == 1e6 && shrunk == 1e-9) continue;  // refused, as the instances below are
      const auto scene = scene_of(size, shrunk);
      for (int i = 0; i < 300; ++i) {
        CameraDescription view;
        view.name = "extreme";
        view.orthographic = i % 2 == 0;
        view.y_mag = std::abs(any());
        view.fov_y = std::min(std::abs(any()), 3.14159265358979);
        if (i % 3 == 0) {
          view.lens_radius = std::abs(any());
          view.focus_distance = std::abs(any());
        }
        for (int r = 0; r < 3; ++r) {
          for (int c = 0; c < 3; ++c) view.to_world[r][c] = i % 5 == 0 ? any() : unit();
        }
        const double away = any();
        for (int c = 0; c < 3; ++c) view.to_world[3][c] = i % 7 == 0 ? any() : away * unit();
        ++(trace_views(*scene, view, random) ? traced : refused);
        if (HasFailure()) FAIL() << "size " << size << ", shrunk " << shrunk << ", camera " << i;
      }
    }
  }
  EXPECT_GT(traced, 1500);
  EXPECT_GT(refused, 1500);
}

TEST(ExtremeCameras, NotANumberIsRefused) {
  const auto scene = scene_of(1, 1);
  std::mt19937 random(2);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 5; ++i) {
    CameraDescription view = orthographic({0, 0, 5}, {0, 0, 0}, 1);
    view.name = "extreme";
    if (i == 0) view.y_mag = nan;
    if (i == 1) view.to_world[3][0] = nan;
    if (i == 2) view.to_world[2][1] = nan;
    if (i >= 3) view.orthographic = false;
    if (i == 3) view.fov_y = nan;
    if (i == 4) view.lens_radius = 1, view.focus_distance = nan;
    EXPECT_FALSE(trace_views(*scene, view, random)) << i;
  }
}

std::string rejection_message(SceneBuilderForTests& b) {
  try {
    b.build();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ExtremeInstances, AreRefusedIfRaysCannotEnter) {
  for (const double scale : {1e-25, 1e-13}) {
    SceneBuilderForTests b;
    const int material = b.add_material(lambert(Rgb(0.5f)));
    b.place(b.add_mesh(b.sphere(1, 4, material)));
    const int mesh = b.add_mesh(b.sphere(1, 4, material));
    for (int i = 0; i < 2; ++i) b.place(mesh, scaling(scale));
    b.description.environment = EnvironmentDescription{};
    EXPECT_NE(
        rejection_message(b).find("has a scale that is too large or too small to trace rays in it"),
        std::string::npos)
        << scale;
  }
}

TEST(ExtremeLights, TooFarFromASmallSceneAreRefused) {
  SceneBuilderForTests b;
  b.place(b.add_mesh(b.sphere(1e-9f, 4, b.add_material(lambert(Rgb(0.5f))))));
  PunctualLightDescription light;
  light.name = "far";
  light.to_world = translation(0, 1e18, 0);
  b.description.lights.push_back(light);
  EXPECT_NE(rejection_message(b).find("light 'far' is too far"), std::string::npos);
}

}  // namespace
}  // namespace emberline::test
