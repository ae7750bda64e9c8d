// Assembles what the library needs for a frame: the options of the equivalent `emberline render`
// call, and the lights and mattes of the scene in its current pose and with its edits.
#pragma once

#include <optional>

#include "renderer/api/access.h"
#include "renderer/engine/render_plan.h"
#include "renderer/engine/setting_table.h"
#include "renderer/output/render_options.h"
#include "renderer/output/scene_layers.h"

namespace emberline::api {

// Whether the group's settings only affect how a scene is loaded.
bool is_load_setting(SettingGroup group);

// Returns the options with which the command would write an EXR with the same channels as the
// library's picture. Takes the loading settings from the scene. Throws UsageError for settings that
// conflict with those of the scene.
RenderOptions options_of(const Access::SceneState& scene, const FrameSettings& settings);
// Returns an empty text if the scene is in the pose that the options and their edits select.
// Otherwise returns a text that identifies the scene's pose.
std::string pose_override(const Access::SceneState& scene, const RenderOptions& options);

struct FrameParts {
  // Throws whatever choosing the camera and applying the scene's edits may throw.
  FrameParts(const Access::SceneState& scene, const FrameSettings& settings);
  FrameParts(const FrameParts&) = delete;

  Camera camera;
  std::optional<LightGroups> lights;
  std::optional<CryptomatteIds> mattes;
  SceneParts scene_parts;  // refers to `lights`, `mattes` and the surface roles of the scene
  SceneLayers layers;
};

std::vector<MatteNames> names_of(const SceneLayers& layers);

// Combines the picture with everything else that its file contains, and with the counts of a
// finished job or merge.
RenderedPicture rendered_picture(Picture picture, const OutputSettings& output,
                                 const SceneLayers& layers, const RenderCounters& counters,
                                 std::optional<double> error_estimate, bool complete);

// Returns the settings that a checkpoint stores, including the names of its input files. Throws
// InputError.
FrameSettings settings_in(const std::string& checkpoint);

}  // namespace emberline::api
