// Assembles a frame of the library: the command's options, and the lights and mattes of the scene
// as it is posed and edited.
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

// Returns the command's options for an EXR, which has the channels of a picture. Loading settings
// come from the scene. Throws UsageError for settings that conflict with the scene's.
RenderOptions options_of(const Access::SceneState& scene, const FrameSettings& settings);
// A text for the scene's pose if it differs from the one that the options and their edits give;
// otherwise empty.
std::string pose_override(const Access::SceneState& scene, const RenderOptions& options);

struct FrameParts {
  // Throws what choosing the camera and applying the scene's edits throw.
  FrameParts(const Access::SceneState& scene, const FrameSettings& settings);
  FrameParts(const FrameParts&) = delete;

  Camera camera;
  std::optional<LightGroups> lights;
  std::optional<CryptomatteIds> mattes;
  SceneParts scene_parts;  // the above, and the scene's roles
  SceneLayers layers;
};

std::vector<MatteNames> names_of(const SceneLayers& layers);

// Adds the other contents of the file, and the counts of a finished job or merge.
RenderedPicture rendered_picture(Picture picture, const OutputSettings& output,
                                 const SceneLayers& layers, const RenderCounters& counters,
                                 std::optional<double> error_estimate, bool complete);

// The settings in a checkpoint, including its input files. Throws InputError.
FrameSettings settings_in(const std::string& checkpoint);

}  // namespace emberline::api
