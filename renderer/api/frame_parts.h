// What a frame of the library is made of: the command's options, and what the settings name in the
// scene as it is posed and edited.
#pragma once

#include <optional>

#include "renderer/api/access.h"
#include "renderer/engine/render_plan.h"
#include "renderer/engine/setting_table.h"
#include "renderer/output/render_options.h"
#include "renderer/output/scene_layers.h"

namespace emberline::api {

// Whether settings of the group decide how a scene is loaded, and nothing afterwards.
bool is_of_scene(SettingGroup group);

// As the command has them for an EXR, which has the channels of a picture. What decided how the
// scene was loaded is the scene's. Throws UsageError for settings that do not go with the scene's.
RenderOptions options_of(const Access::SceneState& scene, const FrameSettings& settings);
// The scene's pose, if the options and their edits would give it another one; empty otherwise.
std::string own_pose(const Access::SceneState& scene, const RenderOptions& options);

struct FrameParts {
  // Throws what the settings' camera and the scene's edits do.
  FrameParts(const Access::SceneState& scene, const FrameSettings& settings);
  FrameParts(const FrameParts&) = delete;

  Camera camera;
  std::optional<LightGroups> lights;
  std::optional<CryptomatteIds> mattes;
  SceneParts of_scene;  // these, and the scene's roles
  SceneLayers layers;
};

std::vector<MatteNames> names_of(const SceneLayers& layers);

// It with what its file has beside its pixels, and with what a finished job or merge has counted.
RenderedPicture rendered_picture(Picture picture, const OutputSettings& output,
                                 const SceneLayers& layers, const RenderCounters& counters,
                                 std::optional<double> error_estimate, bool complete);

// The settings in a checkpoint, with the files that its frame was made of. Throws InputError.
FrameSettings settings_in(const std::string& checkpoint);

}  // namespace emberline::api
