// Scenes with every kind of light, mainly for tests of light groups and layers.
#pragma once

#include "support/edited_scene.h"
#include "support/glass_scenes.h"
#include "support/scenes.h"

namespace emberline::test {

// The materials of both scenes, by index.
enum Part { kMatt, kRed, kTube, kPane, kGlass };

// A scene with matt surfaces, three point lights, an emissive tube and a sky. One of the point
// lights is dark, and one emissive material is not used.
inline SceneDescription lit_scene() {
  SceneBuilderForTests b;
  const auto add = [&](const char* name, MaterialDescription m) {
    m.name = name;
    return b.add_material(m);
  };
  add("matt", lambert(Rgb(0.7f, 0.6f, 0.5f)));
  add("red", lambert(Rgb(0.8f, 0.1f, 0.1f)));
  add("tube", emitter(Rgb(3.0f, 2.5f, 2.0f)));
  add("stored away", emitter(Rgb(1.0f)));
  b.add_floor(4, 0, kMatt);
  b.add_quad({-1.5f, 0, -1}, {1.5f, 0, -1}, {1.5f, 1.5f, -1}, {-1.5f, 1.5f, -1}, kRed);
  b.place(b.add_mesh(SceneBuilderForTests::sphere(0.2f, 8, kTube)), translation(-0.8, 0.6, 0.3));
  b.place(b.add_mesh(SceneBuilderForTests::sphere(0.4f, 8, kMatt)), translation(0.7, 0.4, 0.2));
  b.add_point_light({2, 2.5, 1}, {5, 4, 3});
  b.add_point_light({0, 1, 3}, Rgb(0.0f));
  b.add_point_light({-2, 2, 2}, {1, 2, 4});
  b.description.lights[0].name = "key";
  b.description.lights[1].name = "dark";
  b.description.lights[2].name = "fill";
  b.set_environment(patterned_sky(1.5f));
  return b.description;
}

inline CameraDescription lit_view() { return perspective({0.3, 1.3, 4.0}, {0, 0.5, 0}, 45); }

// lit_scene() seen through a pane of glass, with a glass ball.
inline SceneDescription glazed_scene() {
  SceneBuilderForTests b;
  b.description = lit_scene();
  b.description.materials[3] = glass(1.5f, 0.0f, false);
  b.add_material(glass(1.5f, 0.0f));
  b.add_quad({-3, 0, 1.5f}, {3, 0, 1.5f}, {3, 3, 1.5f}, {-3, 3, 1.5f}, kPane);
  b.place(b.add_mesh(SceneBuilderForTests::sphere(0.35f, 12, kGlass, false, true)),
          translation(0, 0.35, 0.8));
  return b.description;
}

}  // namespace emberline::test
