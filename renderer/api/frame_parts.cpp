#include "renderer/api/frame_parts.h"

#include "renderer/core/errors.h"
#include "renderer/engine/frame_scene.h"
#include "renderer/scene/embree_isa.h"

namespace emberline::api {

bool is_load_setting(SettingGroup group) {
  return group == SettingGroup::kLoading || group == SettingGroup::kEdits ||
         group == SettingGroup::kLight;
}

namespace {

// Throws UsageError for frame settings that conflict with those of the scene.
void check_matches_scene(const FrameSettings& settings, const Access::SceneState& scene) {
  const SceneBuildOptions& built = scene.build;
  const auto check_same = [](bool same, const char* name) {
    if (same) return;
    throw emberline::UsageError(
        "`{}`: the scene was loaded with another value of this setting; load the scene again with "
        "this value",
        name);
  };
  check_same(settings.catchers == scene.settings.catchers, "catcher");
  check_same(settings.catcher_plane == scene.settings.catcher_plane, "catcher-plane");
  check_same(settings.holdouts == scene.settings.holdouts, "holdout");
  check_same(settings.show_backfaces == built.show_backfaces, "backfaces");
  check_same(settings.isa.value_or(widest_isa()) == built.isa.value_or(widest_isa()), "isa");
  check_same(settings.working_space == scene.settings.working_space, "working-space");
  if (!settings.cryptomattes.empty() && !load_options(scene.settings).nodes) {
    throw emberline::UsageError(
        "`cryptomatte`: this setting needs the names of the nodes, which were not loaded; load "
        "the scene with this setting");
  }
  const FrameSettings posed = scene.open->posed(settings);
  const bool animated = !scene.open->editable().original().animations.empty();
  if (animated && pose_time(posed) && load_options(posed).next_frame &&
      !load_options(scene.open->settings()).next_frame) {
    throw emberline::UsageError(
        "`aov` velocity: the channel needs the positions of the next frame, which were not loaded; "
        "load the scene with this setting");
  }
  const bool shows_uv =
      find_integrator(settings.integrator).shows_uv || aovs_of(settings).contains(Aov::kUv);
  if (shows_uv && !built.unread_uv) {
    throw emberline::UsageError(
        "`integrator`, `aov`: these settings show texture coordinates, which were not loaded; load "
        "the scene with these settings");
  }
}

// Returns the camera that the settings and the scene's edits choose.
Camera camera_of(const Access::SceneState& state, const FrameSettings& settings) {
  SceneDescription views;
  views.cameras = state.open->editable().original().cameras;
  if (views.cameras.empty()) {
    const double aspect = double(settings.width) / settings.height;
    views.cameras.push_back(framing_camera(state.bounds, aspect));
  }
  FrameSettings without_turntable = settings;
  without_turntable.turntable.reset();
  const CameraDescription camera =
      choose_camera(without_turntable, views, state.open->editable().edits());
  return create_camera(settings, apply_turntable(camera, state.open->posed(settings), state.bounds),
                       state.open->scene());
}

}  // namespace

RenderOptions options_of(const Access::SceneState& scene, const FrameSettings& settings) {
  RenderOptions options;
  for (const Setting& row : setting_table()) {
    const std::string text = row.text(is_load_setting(row.group) ? scene.settings : settings);
    if (!text.empty()) row.read(options, text);
  }
  options.scene = scene.settings.scene;
  if (scene.edited) {
    options.edits.clear();
    options.variant.clear();
  }
  options.outputs = {"picture.exr"};
  check_matches_scene(settings, scene);
  return options;
}

std::string pose_override(const Access::SceneState& scene, const RenderOptions& options) {
  const auto text_of = [](const FrameSettings& settings) {
    std::string text;
    for (const std::string_view name : {"animation", "time", "frame", "fps", "shutter"}) {
      text += find_setting(name)->text(settings) + ";";
    }
    return text;
  };
  FrameSettings expected = options;
  if (!options.edits.empty()) apply_animation(scene.animation, expected);
  const std::string pose = text_of(scene.open->settings());
  return pose == text_of(expected) ? "" : pose;
}

FrameParts::FrameParts(const Access::SceneState& scene, const FrameSettings& settings)
    : camera(camera_of(scene, settings)) {
  const EditableScene& editable = scene.open->editable();
  if (settings.light_groups) {
    lights.emplace(editable.original(), editable.edits());
  }
  if (!settings.cryptomattes.empty()) {
    SceneDescription edited = editable.original();
    apply(editable.edits(), edited);
    mattes.emplace(edited, parse_cryptomattes(settings.cryptomattes));
  }
  scene_parts = {.light_groups = lights ? &*lights : nullptr,
                 .cryptomattes = mattes ? &*mattes : nullptr,
                 .roles = scene.open->parts().roles};
  layers = scene_layers(scene_parts, camera, scene.open->scene().origin());
}

}  // namespace emberline::api
