#include "renderer/engine/frame_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "io/json/edits_file.h"
#include "renderer/core/constants.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/name_or_index.h"
#include "renderer/core/names.h"
#include "renderer/core/setting_names.h"
#include "renderer/core/shortened.h"
#include "renderer/description/framing.h"
#include "renderer/engine/setting_rules.h"
#include "renderer/film/film.h"
#include "renderer/scene/build_scene.h"

namespace emberline {
namespace {

// Throws InputError if the chosen camera is invalid. Warns if other cameras are invalid.
void check_cameras(const SceneDescription& scene, const CameraDescription* chosen) {
  if (chosen && chosen->fault) throw InputError(*chosen->fault);
  const auto broken = [](const CameraDescription& camera) { return camera.fault != nullptr; };
  const auto first = std::ranges::find_if(scene.cameras, broken);
  if (first == scene.cameras.end()) return;
  const auto more = std::count_if(first + 1, scene.cameras.end(), broken);
  log_warning(fmt::format("{}; camera '{}'{} cannot be used", first->fault->what(),
                          shortened(first->name),
                          more > 0 ? fmt::format(" and {} more", more) : ""));
}

// Returns the index of the first camera that matches. Warns if several match.
size_t find_camera(const std::string& requested, const std::vector<CameraDescription>& cameras) {
  const std::vector<size_t> matching = matching_cameras(requested, cameras);
  std::string listed;
  constexpr size_t kMaxListed = 100;
  const auto list = [&](size_t i) {
    const CameraDescription& camera = cameras[i];
    listed += fmt::format("{}{} '{}'", listed.empty() ? "" : ", ", i, shortened(camera.name));
    if (!camera.node.empty() && camera.node != camera.name) {
      listed += fmt::format(" (node '{}')", shortened(camera.node));
    }
  };
  if (matching.empty()) {
    std::vector<std::string_view> names;
    for (const CameraDescription& camera : cameras) names.push_back(camera.name);
    const bool few = cameras.size() <= kMaxListedNames;
    if (few) {
      for (size_t i = 0; i < cameras.size(); ++i) list(i);
    } else {
      for (const size_t i : nearest_indices(requested, names)) list(i);
    }
    throw UsageError(fmt::format("`camera`: no camera '{}'; the file has {}{}",
                                 shortened(requested),
                                 few ? "" : fmt::format("{} cameras, such as ", cameras.size()),
                                 cameras.empty() ? "none" : listed));
  }
  if (matching.size() > 1) {
    for (size_t i = 0; i < std::min(matching.size(), kMaxListed); ++i) list(matching[i]);
    log_warning(fmt::format(
        "`camera`: '{}' matches several cameras: {}{}; using {} (give an index to choose another)",
        shortened(requested), listed, matching.size() > kMaxListed ? " and more" : "",
        matching.front()));
  }
  return matching.front();
}

CameraDescription choose_view(const FrameSettings& settings, const SceneDescription& scene) {
  const double aspect = double(settings.width) / settings.height;
  CameraDescription camera;
  if (!settings.camera.empty()) {
    camera = scene.cameras[find_camera(settings.camera, scene.cameras)];
    check_cameras(scene, &camera);
  } else if (settings.look_from || scene.cameras.empty()) {
    check_cameras(scene, nullptr);
    camera = framing_camera(framed_bounds(scene), aspect);
    if (!settings.look_from) log_info("the file has no camera; framing the whole scene");
  } else {
    camera = scene.cameras.front();
    check_cameras(scene, &camera);
  }
  if (settings.look_from) {
    camera.name = spell_setting_names("`look-from`");
    if (settings.fov_y) camera.orthographic = false;
    const Vec3d ahead = *settings.look_from + Vec3d(0, 0, -1);
    camera.to_world = look_at_matrix(*settings.look_from, settings.look_at.value_or(ahead));
    camera.motion.clear();
    camera.next_frame.reset();
    if (settings.camera.empty()) camera.fov_y = 40.0 * kPiD / 180.0;
  }
  if (camera.aspect && !settings.look_from && !settings.panorama &&
      std::abs(*camera.aspect / aspect - 1.0) > 0.01) {
    // As in glTF, the frame's aspect ratio changes only the horizontal extent of the view.
    const double width = std::clamp(settings.height * *camera.aspect, 1.0, 1e6);
    log_info(fmt::format(
        "camera '{}' has an aspect ratio of {:.3g}, but the frame has {:.3g}; `size` {}x{} would "
        "match",
        shortened(camera.name), *camera.aspect, aspect, std::lround(width), settings.height));
  }
  if (settings.fov_y) {
    if (camera.orthographic) {
      throw UsageError("`fov-y`: camera '" + shortened(camera.name) +
                       "' is orthographic and has no field of view");
    }
    camera.fov_y = *settings.fov_y * kPiD / 180.0;
    camera.zoom.reset();
  }
  if (settings.look_from && settings.look_at) {
    camera.focus_distance = (*settings.look_at - *settings.look_from).length();
  }
  return camera;
}

void apply_lens(const FrameSettings& settings, CameraDescription& camera) {
  if (settings.focus_distance) camera.focus_distance = *settings.focus_distance;
  if (!settings.f_stop) return;
  if (camera.orthographic) {
    throw UsageError("`f-stop`: camera '" + shortened(camera.name) +
                     "' is orthographic and has no lens");
  }
  if (!(camera.focus_distance > 0)) {
    throw UsageError(
        "`f-stop` requires `focus-distance` or `look-at`: the lens needs a distance to focus on");
  }
  camera.lens_radius = lens_radius(*settings.f_stop, camera.fov_y);
}

// Applies lens, panorama and turntable settings to a camera from the file or the edits.
CameraDescription apply_settings(const FrameSettings& settings, const SceneDescription& scene,
                                 CameraDescription camera) {
  apply_lens(settings, camera);
  camera.panorama = settings.panorama;
  if (!settings.turntable) return camera;
  return apply_turntable(std::move(camera), settings, framed_bounds(scene));
}

// Returns whether positions one frame later must be read, too. The velocity channel needs them if
// the shutter interval is empty.
bool needs_next_frame(const FrameSettings& settings) {
  return is_instant(settings) && AovSet::parse(settings.aovs).contains(Aov::kVelocity);
}

// Rotates the camera by `frames` frames of a turn that has `count` frames.
Mat44d rotate_about_vertical(Mat44d m, int64_t frames, int64_t count, const Vec3d& center) {
  const int64_t place = (frames % count + count) % count;
  if (place == 0) return m;
  // Rotates exactly by whole quarter turns, and by `angle` for the rest. For example, 9 of 36
  // frames are one quarter turn, so `angle` is 0.
  const double angle = double(4 * place % count) / double(count) * kPiD / 2;
  double c = std::cos(angle), s = std::sin(angle);
  for (int64_t quarter = 0; quarter < 4 * place / count; ++quarter) {
    c = -std::exchange(s, c);
  }
  for (int row = 0; row < 4; ++row) {
    const double x = m[row][0] - (row == 3 ? center.x : 0.0);
    const double z = m[row][2] - (row == 3 ? center.z : 0.0);
    m[row][0] = (row == 3 ? center.x : 0.0) + (x * c + z * s);
    m[row][2] = (row == 3 ? center.z : 0.0) + (z * c - x * s);
  }
  return m;
}

}  // namespace

void warn_about_repaired(const std::string& file, uint64_t texels) {
  if (texels == 0) return;
  log_warning(fmt::format("{}: {} texel values were NaN, infinite or negative and count as black",
                          file, texels));
}

SceneEdits load_edits(const FrameSettings& settings, const LoadProgress& progress) {
  if (settings.edits.empty()) return {};
  SceneEdits edits = read_edits(settings.edits, progress);
  warn_about_repaired(edits.environment.file, edits.environment.repaired_texels);
  return edits;
}

std::optional<double> pose_time(const FrameSettings& settings) {
  check_rules(settings, "time");
  if (settings.frame) return *settings.frame / settings.fps;
  return settings.time;
}

bool is_instant(const FrameSettings& settings) {
  return !settings.shutter || settings.shutter->open >= settings.shutter->close;
}

void apply_animation(const AnimationEdit& edit, FrameSettings& settings) {
  if (edit == AnimationEdit()) return;
  if (settings.animation.empty() && !settings.time && !settings.frame) {
    settings.animation = edit.name;
    settings.time = edit.time;
  } else {
    log_info("the time comes from the command line and not from " + edit.place);
  }
  if (!settings.shutter && edit.shutter_open && edit.shutter_close) {
    const double frames = settings.fps / edit.fps.value_or(settings.fps);
    settings.shutter = Shutter{*edit.shutter_open * frames, *edit.shutter_close * frames};
  }
}

void hint_at_rest(const FrameSettings& settings, const SceneDescription& scene) {
  if (is_instant(settings) || !settings.animation.empty() || pose_time(settings)) return;
  log_info(
      scene.animations.empty()
          ? "`shutter` has no effect: the file has no animation"
          : "`shutter` has no effect while the animation is not played; add `animation` or `time`");
}

GltfOptions load_options(const FrameSettings& settings) {
  GltfOptions options = {.lenient = settings.lenient,
                         .variants = !settings.variant.empty(),
                         .resource_root = settings.resource_root,
                         .animation = settings.animation,
                         .time = pose_time(settings)};
  if (settings.shutter) {
    options.shutter = {settings.shutter->open / settings.fps,
                       settings.shutter->close / settings.fps};
  }
  options.nodes =
      !settings.cryptomattes.empty() || has_catchers(settings) || !settings.holdouts.empty();
  if (needs_next_frame(settings)) options.next_frame = 1.0 / settings.fps;
  return options;
}

void choose_variant(const FrameSettings& settings, const SceneDescription& scene,
                    SceneEdits& edits) {
  if (settings.variant.empty()) return;
  if (edits.variant) {
    log_info("the variant comes from the command line and not from " + edits.variant->place);
  }
  const size_t index = find_name_or_index("variant", settings.variant, scene.variants);
  edits.variant = EditTarget{scene.variants[index].name, int(index), "`variant`"};
}

std::vector<size_t> matching_cameras(const std::string& requested,
                                     const std::vector<CameraDescription>& cameras) {
  std::vector<size_t> matching;
  for (size_t i = 0; i < cameras.size(); ++i) {
    if (cameras[i].name == requested) matching.push_back(i);
  }
  for (size_t i = 0; i < cameras.size(); ++i) {
    if (cameras[i].node == requested && cameras[i].name != requested) matching.push_back(i);
  }
  if (!matching.empty()) return matching;
  if (const std::optional<size_t> index = parse_index(requested, cameras.size())) return {*index};
  return {};
}

CameraDescription choose_camera(const FrameSettings& settings, const SceneDescription& scene) {
  return apply_settings(settings, scene, choose_view(settings, scene));
}

CameraDescription choose_camera(const FrameSettings& settings, const SceneDescription& scene,
                                const SceneEdits& edits) {
  const bool edited = edits.camera != CameraEdit{};
  const bool view_is_set = !settings.camera.empty() || settings.look_from || settings.fov_y;
  if (!edited || view_is_set) {
    if (edited) {
      log_info("the view comes from the command line and not from " + edits.camera.place);
    }
    return choose_camera(settings, scene);
  }
  const double aspect = double(settings.width) / settings.height;
  CameraDescription camera = edited_camera(
      edits, scene,
      scene.cameras.empty() ? framing_camera(framed_bounds(scene), aspect) : scene.cameras.front());
  check_cameras(scene, &camera);
  return apply_settings(settings, scene, std::move(camera));
}

CameraDescription apply_turntable(CameraDescription camera, const FrameSettings& settings,
                                  const WorldBounds& bounds) {
  if (!settings.turntable) return camera;
  const Turntable& turn = *settings.turntable;
  const int64_t frame = turn.frame.value_or(1);
  const bool looks_at = settings.turntable_center == TurntableCenter::kLookAt;
  const Vec3d center = looks_at           ? settings.look_at.value()
                       : bounds.isEmpty() ? Vec3d(0.0)
                                          : bounds.center();
  if (needs_next_frame(settings)) {
    camera.next_frame = rotate_about_vertical(camera.next_frame.value_or(camera.to_world), frame,
                                              turn.count, center);
  }
  camera.to_world = rotate_about_vertical(camera.to_world, frame - 1, turn.count, center);
  for (Mat44d& step : camera.motion)
    step = rotate_about_vertical(step, frame - 1, turn.count, center);
  return camera;
}

Camera create_camera(const FrameSettings& settings, const CameraDescription& camera,
                     const Scene& scene) {
  try {
    return {camera,         settings.width, settings.height,
            scene.origin(), scene.scale(),  scene.max_origin()};
  } catch (const InputError& error) {
    if (settings.look_from || settings.fov_y || settings.f_stop || settings.focus_distance) {
      throw UsageError(error.what());
    }
    throw;
  }
}

}  // namespace emberline
