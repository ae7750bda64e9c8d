// The scene that a RenderSession has open, as a window lists it, and how far a loading one is.
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
  std::string path;     // of the scene that is loading, or was last
  std::string stage;    // "images", "BVH": for people
  double fraction = 0;  // in [0, 1]
  std::string error;    // kFailed; the scene of before stays
};

// Immutable. Indices of edits count in its lists.
struct ListedScene {
  // As the file has it in the pose that it was opened in: names, lights, materials, cameras,
  // instances. Without vertices; with the light and the material that a file may leave to its
  // reader.
  SceneDescription outline;
  // The camera without edits, for the frame size that the scene was opened for.
  CameraDescription camera;
  bool camera_frames_scene =
      false;                      // it is fitted to scene and frame: neither file nor user has one
  WorldBounds bounds;             // of the geometry; empty (min > max) without any
  Vec3d center = Vec3d(0.0);      // of those bounds
  double radius = 1.0;            // > 0, without geometry too
  std::vector<NamedFile> inputs;  // that it was read from, an environment of its own too
  std::vector<AnimationDescription> animations;
  std::vector<std::string> features;  // what was built and why
  std::vector<std::string> warnings;  // that loading and building it gave
};

}  // namespace emberline
