// A scene with many features, for tests of properties that every scene must have.
#pragma once

#include <memory>

#include "support/scenes.h"

namespace emberline::test {

// The scene has enough area lights for a light BVH, a point light, an environment, metal and
// dielectric, instances (one of them mirrored) and alpha coverage.
inline std::unique_ptr<Scene> busy_scene() {
  SceneBuilderForTests b;
  MaterialDescription coat;
  coat.base_color = {0.7f, 0.5f, 0.3f};
  coat.metallic = 0.0f;
  coat.roughness = 0.3f;
  b.add_floor(4, 0, b.add_material(coat));
  MaterialDescription veil = lambert({0.2f, 0.7f, 0.3f});
  veil.alpha = 0.4f;
  veil.alpha_mode = AlphaMode::kBlend;
  veil.double_sided = true;
  b.add_quad({-1, 0, 1}, {1, 0, 1}, {1, 1.5f, 1}, {-1, 1.5f, 1}, b.add_material(veil));
  const int ball = b.add_mesh(
      SceneBuilderForTests::sphere(0.5f, 12, b.add_material(metal({0.9f, 0.6f, 0.3f}, 0.35f))));
  b.place(ball, translation(-0.8, 0.5, 0));
  Mat44d mirrored = translation(0.8, 0.5, 0);
  mirrored[0][0] = -1;
  b.place(ball, mirrored);
  b.place(b.add_mesh(SceneBuilderForTests::sphere(0.1f, 6, b.add_material(emitter(Rgb(20.0f))))),
          translation(0, 2, -0.5));
  b.add_point_light({2, 3, 1}, {3, 4, 5});
  b.set_environment({0.2f, 0.25f, 0.3f});
  return b.build();
}

inline CameraDescription busy_view() { return perspective({0.5, 1.2, 4}, {0, 0.5, 0}, 45); }

}  // namespace emberline::test
