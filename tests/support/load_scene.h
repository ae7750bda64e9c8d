// Loads the scene that the settings name, at the time that the settings name.
#pragma once

#include "renderer/engine/scene_file.h"

namespace emberline::test {

inline SceneDescription load_scene(const FrameSettings& settings,
                                   LoadProgress& progress = LoadProgress::none()) {
  return SceneFile(settings, progress, {.variants = true}).pose(settings, {}, progress);
}

}  // namespace emberline::test
