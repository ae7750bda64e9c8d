// The lists of a RenderSession's open scene, which a window shows, and the progress of loading.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "renderer/core/file_identity.h"
#include "renderer/core/vector.h"
#include "renderer/description/framing.h"
#include "renderer/description/scene_description.h"

namespace emberline {

struct LoadStatus {
  enum class State : uint8_t { kNone, kLoading, kReady, kFailed, kCancelled };
  State state = State::kNone;
  std::string path;     // file of the scene that is loading, or was loaded last
  std::string stage;    // shown to the user, for example "images" or "BVH"
  double fraction = 0;  // in [0, 1]
  std::string error;    // for kFailed; the previous scene is kept
};

// Immutable. Indices in edits refer to the lists of `outline`.
struct ListedScene {
  // The file's names, lights, materials, cameras and instances, without vertices, in the pose in
  // which it was opened. Includes the default light and material if the file relies on them.
  SceneDescription outline;
  // The camera without edits, for the frame size that the scene was opened for.
  CameraDescription camera;
  bool camera_frames_scene = false;  // no camera was chosen, so `camera` fits the bounds
  WorldBounds bounds;                // bounds of the geometry; empty (min > max) without geometry
  Vec3d center = Vec3d(0.0);         // centre of the bounds
  double radius = 1.0;               // > 0, even without geometry
  std::vector<NamedFile> inputs;     // input files, including a separate environment
  std::vector<AnimationDescription> animations;
  std::vector<std::string> warnings;  // from loading and building
};

}  // namespace emberline
