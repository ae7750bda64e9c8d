// Finds the scene and the view that a frame's settings ask for.
#pragma once

#include <optional>
#include <string>

#include "io/gltf/gltf_file.h"
#include "renderer/core/load_progress.h"
#include "renderer/description/framing.h"
#include "renderer/description/scene_description.h"
#include "renderer/description/scene_edits.h"
#include "renderer/engine/frame_settings.h"
#include "renderer/scene/camera.h"
#include "renderer/scene/scene.h"

namespace emberline {

// Loads the settings' edits, if any. Throws InputError.
SceneEdits load_edits(const FrameSettings& settings, const LoadProgress& progress);

// The time that the scene is posed for, in seconds; nullopt if no animation is chosen. Throws
// UsageError if `time` and `frame` are both given.
std::optional<double> pose_time(const FrameSettings& settings);

// Whether the shutter interval is empty.
bool is_instant(const FrameSettings& settings);

// Fills in animation, time and shutter from the edits where the settings have none.
void apply_animation(const AnimationEdit& edit, FrameSettings& settings);

// Says what to add if the shutter is open but the scene is at rest.
void hint_at_rest(const FrameSettings& settings, const SceneDescription& scene);

// The options for reading the scene file, without those that edits need. Throws UsageError.
GltfOptions load_options(const FrameSettings& settings);

// Warns, once per file, that texels of a picture had to be repaired.
void warn_about_repaired(const std::string& file, uint64_t texels);

// Replaces the variant of `edits` by the settings' variant, if any. Throws UsageError that lists
// the file's variants.
void choose_variant(const FrameSettings& settings, const SceneDescription& scene,
                    SceneEdits& edits);

// The camera and lens that the settings choose. Throws UsageError that lists the file's cameras.
CameraDescription choose_camera(const FrameSettings& settings, const SceneDescription& scene);
// The cameras that match --camera: by name, then by node name, else by index.
std::vector<size_t> matching_cameras(const std::string& requested,
                                     const std::vector<CameraDescription>& cameras);
// The edits' camera, unless the settings choose a view; a lens of the settings applies to either.
// Throws InputError for edits that do not fit the scene.
CameraDescription choose_camera(const FrameSettings& settings, const SceneDescription& scene,
                                const SceneEdits& edits);

// Moves the camera to its frame of the turntable: to its right on a circle around the vertical axis
// through the centre of the bounds, or the point that the settings choose. choose_camera() calls it
// with the scene's bounds. Without a turntable the camera is unchanged.
CameraDescription apply_turntable(CameraDescription camera, const FrameSettings& settings,
                                  const WorldBounds& bounds);

// Creates the camera for the frame's size. Throws UsageError if the settings' view or lens cannot
// be rendered, InputError if the file's cannot.
Camera create_camera(const FrameSettings& settings, const CameraDescription& camera,
                     const Scene& scene);

}  // namespace emberline
