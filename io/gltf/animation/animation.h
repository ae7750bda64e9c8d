// Reads the animations of a file: what they change, and the values at a given time.
//
// Nodes are posed by separate values (GltfPose), which are cheap to evaluate at many times. The
// values of all other targets of KHR_animation_pointer are written into the document's JSON. From
// there, materials, lights and cameras are read as usual. gltf/animation/animated_values.h follows
// some of these values while the shutter is open.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/gltf/animation/target.h"
#include "io/gltf/document/document.h"
#include "io/gltf/gltf_file.h"
#include "renderer/core/vector.h"
#include "renderer/description/animation.h"
#include "renderer/description/scene_description.h"

namespace emberline {

struct NodeTrack {
  NodeTarget target;
  KeyFrames keys;
};

// Animates one or more numbers of the document.
struct PointerTrack {
  std::string pointer;
  const schema::Property* property = nullptr;
  KeyFrames keys;
  // Set if sample_value() clamped a value since the last write_values_at(). Not thread-safe.
  mutable bool was_clamped = false;
};

// The animations that pose the scene. Without any animation, the scene is at rest.
struct GltfAnimation {
  bool at_rest = true;
  double time = 0.0;                 // requested time in seconds
  double open = 0.0, close = 0.0;    // shutter interval in seconds; equal for an instant
  std::optional<double> next_frame;  // time of the next frame in seconds; set only for an instant
  double duration = 0.0;             // of the longest animation
  // Tracks in file order. If two tracks have the same target, the later one is used.
  std::vector<NodeTrack> nodes;            // tracks of everything except visibility
  std::map<size_t, KeyFrames> visibility;  // by node
  std::vector<PointerTrack> pointers;
  // For each node with animated weights: the weights that the file states for it.
  std::map<size_t, std::vector<double>> weights;
  MemoryReservation memory;

  float shutter_fraction(double seconds) const {
    return open < close ? float((seconds - open) / (close - open)) : 0.0f;
  }
};

// Animated values of a node. An absent value stays as in the file.
struct NodePose {
  std::optional<Vec3d> translation, scale;
  std::optional<Quaternion> rotation;
  std::vector<double> weights;  // of all morph targets; absent if empty
};
using GltfPose = std::map<size_t, NodePose>;  // by node; empty: at rest

// Validates the JSON of each animation. Broken animations are noted (gltf/document/faults.h).
void check_gltf_animations(GltfDocument& document);

// Returns the name, duration and targets of every animation. Reads only the last key times.
std::vector<AnimationDescription> describe_animations(const GltfDocument& document);

// Reads the animations that the options choose from `list`, without channels that have no effect.
// Call set_time() next. Throws UsageError if there is no such animation, and InputError if the
// animation is broken.
GltfAnimation read_animation(const GltfDocument& document, const GltfOptions& options,
                             const std::vector<AnimationDescription>& list);

// Sets time and shutter from the options. Logs if the time is outside the animation.
void set_time(const GltfDocument& document, const GltfOptions& options, GltfAnimation& animation);

// Returns, for each node, whether its visibility or transform, or that of an ancestor, depends on
// time.
std::vector<char> nodes_that_may_move(const GltfDocument& document, const GltfAnimation& animation);

// Returns the nodes' poses without visibility, which is in gltf/animation/visibility.h. Takes
// logarithmic time in the number of keys per track.
GltfPose pose_at(const GltfAnimation& animation, double time);
// Returns the times of shutter opening, of the key frames while the shutter is open, and of shutter
// closing, in ascending order. If the shutter interval is an instant, returns only the time of the
// instant.
std::vector<double> shutter_key_times(const GltfAnimation& animation,
                                      std::span<const KeyFrames* const> keys);
// Samples the track. Clamps each number to its range in the glTF specification, since splines may
// overshoot.
void sample_value(const PointerTrack& track, double time, std::span<double> value);
// Writes to `document` the values that the pointers' targets have at `time`. Overwrites the values
// of an earlier call.
void write_values_at(const GltfAnimation& animation, double time, nlohmann::json& document);
// Warns about values that sample_value() has clamped.
void report_clamped_values(const GltfDocument& document, const GltfAnimation& animation);

}  // namespace emberline
