// A matt floor under a lamp fills the frame. Stratification works so well here that two streams,
// each with half of the samples, have one and a half times the error of one stream. All pixels need
// equally many samples.
#pragma once

#include <memory>

#include "support/render.h"
#include "support/scenes.h"

namespace emberline::test {

inline std::unique_ptr<Scene> lit_floor() {
  SceneBuilderForTests b;
  b.add_floor(8, 0, b.add_material(lambert(Rgb(0.5f))));
  const int lamp = b.add_material(emitter(Rgb(4.0f)));
  b.add_quad({-1, 4, -1}, {1, 4, -1}, {1, 4, 1}, {-1, 4, 1}, lamp);
  return b.build();
}

inline CameraDescription lit_floor_view() { return perspective({0, 2.5, 3}, {0, 0, 0}, 40); }

inline RenderSettings lit_floor_settings() {
  RenderSettings s;
  s.width = 48;
  s.height = 32;
  s.max_depth = 3;
  return s;
}

}  // namespace emberline::test
