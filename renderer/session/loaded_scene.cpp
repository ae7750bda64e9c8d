#include "renderer/session/loaded_scene.h"

#include <utility>

#include "io/files/input_file.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/name_or_index.h"
#include "renderer/description/framing.h"
#include "renderer/engine/frame_scene.h"

namespace emberline {
namespace {

// The field of view that choose_camera() uses by default for `look-from`, in degrees.
constexpr double kLookFromFov = 40.0;

// Copies only the lists that edits refer to by index. Instances and meshes, of which there may be
// hundreds of thousands, are left out. They would only be needed to add the default light and
// material, which the outline already has.
SceneDescription copy_edit_lists(const SceneDescription& outline) {
  SceneDescription lists;
  static_cast<SceneLists&>(lists) = outline;
  lists.may_be_dark = true;
  return lists;
}

// Returns the edit of the light, whether that edit refers to the light by name or by index. If
// there is none, adds one.
LightEdit& edit_of(std::vector<LightEdit>& edits, EditedLight kind, size_t index,
                   const SceneDescription& lists) {
  for (LightEdit& edit : edits) {
    if (edit.kind == kind && edited_light_index(edit, lists) == index) return edit;
  }
  LightEdit& fresh = edits.emplace_back();
  fresh.kind = kind;
  fresh.target.index = int(index);
  return fresh;
}

// Applies the edits only to the scene's lists. An environment's file is read only for rendering,
// so an empty image stands in for it here.
SceneDescription apply_to_lists(SceneEdits edits, const LoadedScene& scene) {
  if (!edits.environment.file.empty() && !edits.environment.image) {
    edits.environment.image = std::make_shared<const Image>();
  }
  SceneDescription lists = scene.edit_lists;
  apply(edits, lists);
  return lists;
}

// Moves the options' lens into the edits. There, the artist can change the lens and save it, and it
// keeps its f-number when the angle of view changes.
void move_lens_to_edits(RenderOptions& options, CameraEdit& edit) {
  const bool has_lens = options.f_stop || options.focus_distance;
  if (has_lens && edit.place.empty()) edit.place = "`f-stop`";
  if (options.f_stop) edit.f_stop = std::exchange(options.f_stop, std::nullopt);
  if (options.focus_distance) {
    edit.focus_distance = std::exchange(options.focus_distance, std::nullopt);
  }
}

// Moves the options' time and animation into the edits, where the artist can change them and where
// they are saved.
void move_time_to_edits(RenderOptions& options, AnimationEdit& edit) {
  const AnimationEdit before = edit;
  if (const std::optional<double> time = pose_time(options); time || !options.animation.empty()) {
    edit.name = std::exchange(options.animation, "");
    edit.time = time;
    options.time.reset();
    options.frame.reset();
  }
  if (const auto shutter = std::exchange(options.shutter, std::nullopt)) {
    edit.shutter_open = shutter->open;
    edit.shutter_close = shutter->close;
    edit.fps = options.fps;
  }
  if (options.fps != RenderOptions().fps) edit.fps = options.fps;
  if (edit.place.empty() && edit != before) edit.place = "`time`";
}

void check_animation(const AnimationEdit& edit, const ListedScene& open) {
  if (edit.name.empty() || (edit.name == "all" && !open.animations.empty())) return;
  try {
    find_name_or_index("animation", edit.name, open.animations);
  } catch (const UsageError& error) {
    throw InputError(edit.place, error.what());
  }
}

}  // namespace

CameraDescription LoadedScene::camera(int width, int height) const {
  if (!open->camera_frames_scene) return view;
  CameraDescription fitted = framing_camera(open->bounds, double(width) / height);
  fitted.fov_y = open->camera.fov_y;
  return fitted;
}

bool LoadedScene::needs_repose(const SceneEdits& target_edits) const {
  return scene->can_pose() && target_edits.animation != current_animation;
}

void LoadedScene::pose(const SceneEdits& target_edits) {
  LoadLimits limits;
  limits.memory = budget;
  LoadProgress progress({}, {}, limits);
  ReadScene read = scene->read(options, target_edits, progress);
  CameraDescription now = choose_camera(options, read.description());
  scene->pose(std::move(read), progress);
  view = std::move(now);
  current_animation = target_edits.animation;
  memory.release();
  memory.add(budget->newly_reserved(), options.scene);
}

namespace {

ListedScene describe(const SceneDescription& description, const RenderOptions& options) {
  ListedScene open;
  open.camera = choose_camera(options, description);
  open.camera_frames_scene = description.cameras.empty() && !options.look_from;
  open.inputs = description.files;
  if (const auto environment = file_identity(options.environment)) {
    open.inputs.push_back({options.environment, *environment});
  }
  open.animations = description.animations;
  open.bounds = framed_bounds(description);
  if (!open.bounds.isEmpty()) open.center = open.bounds.center();
  if (open.bounds.radius() > 0.0) open.radius = open.bounds.radius();
  return open;
}

}  // namespace

std::shared_ptr<LoadedScene> load_session_scene(RenderOptions options, LoadProgress& progress) {
  const size_t warnings_before = warnings_so_far().size();
  options.catcher_plane.reset();  // may come from --settings; a session records no shadows
  SceneEdits edits = load_edits(options, progress);
  move_time_to_edits(options, edits.animation);
  // Texture coordinates are kept, since the user may switch to an integrator that shows them.
  const SceneBuildOptions build{
      .show_backfaces = options.show_backfaces, .unread_uv = true, .isa = options.isa};
  ReadScene read(options, std::move(edits), {.build = build, .edits = true, .poses = true},
                 progress);
  edits = read.edits();
  options.variant.clear();
  move_lens_to_edits(options, edits.camera);
  auto open = std::make_shared<ListedScene>(describe(read.description(), options));
  auto loaded = std::make_shared<LoadedScene>();
  loaded->scene = std::move(read).build(progress);
  open->outline = loaded->scene->editable().original();
  const std::vector<std::string> warnings = warnings_so_far();
  open->warnings.assign(warnings.begin() + std::ptrdiff_t(warnings_before), warnings.end());
  loaded->edit_lists = copy_edit_lists(open->outline);
  loaded->current_animation = edits.animation;
  loaded->view = open->camera;
  loaded->open = std::move(open);
  loaded->edits = std::move(edits);
  loaded->options = std::move(options);
  loaded->budget = progress.budget();
  check_edits(loaded->edits, *loaded);
  return loaded;
}

void check_edits(const SceneEdits& edits, const LoadedScene& scene) {
  apply_to_lists(edits, scene);
  check_animation(edits.animation, *scene.open);
  edited_camera(edits, scene.edit_lists, scene.open->camera);
}

SceneEdits with_solo(const SceneEdits& edits, const LightEdit& solo, const LoadedScene& scene) {
  SceneEdits result = edits;
  const SceneDescription lit = apply_to_lists(edits, scene);
  const size_t chosen = edited_light_index(solo, lit);
  const auto switch_light = [&](EditedLight kind, size_t index) {
    edit_of(result.lights, kind, index, scene.edit_lists).on = kind == solo.kind && index == chosen;
  };
  for (size_t i = 0; i < lit.lights.size(); ++i) switch_light(EditedLight::kPunctual, i);
  for (size_t i = 0; i < lit.materials.size(); ++i) {
    const bool emits = !is_black(scene.edit_lists.materials[i].emission);
    if (emits || !is_black(lit.materials[i].emission)) switch_light(EditedLight::kMaterial, i);
  }
  if (lit.environment) switch_light(EditedLight::kEnvironment, 0);
  return result;
}

SceneEdits with_view(const SceneEdits& edits, const RenderOptions& options,
                     const LoadedScene& scene) {
  SceneEdits result = edits;
  CameraEdit& view = result.camera;
  if (view.camera) return result;  // the edits' camera replaces the options' view
  const CameraDescription& base = scene.open->camera;
  const std::vector<CameraDescription>& cameras = scene.open->outline.cameras;
  if (!options.camera.empty()) {
    const std::vector<size_t> matching = matching_cameras(options.camera, cameras);
    if (!matching.empty())
      view.camera = EditTarget{cameras[matching[0]].name, int(matching[0]), {}};
  }
  if (options.look_from && !view.look_from) {
    view.look_from = options.look_from;
    view.look_at = options.look_at;
  }
  if (view.fov_y_degrees || view.orthographic_height) return result;
  if (options.look_from && base.orthographic) {
    view.orthographic_height = 2.0 * base.y_mag;
  } else if (options.fov_y) {
    view.fov_y_degrees = options.fov_y;
  } else if (options.look_from && options.camera.empty()) {
    view.fov_y_degrees = kLookFromFov;
  }
  return result;
}

}  // namespace emberline
