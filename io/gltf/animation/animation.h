// The animations of a file: what moves, and where it is at a given time.
//
// Nodes are posed by separate values (GltfPose), which are cheap to evaluate at any number of
// times. All other targets of KHR_animation_pointer are written into the document's JSON, from
// which materials, lights and cameras are then read as usual; gltf/animation/animated_values.h follows some
// of them during the shutter.
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
  // Set if sample_value clamped a value since the last write_values_at. Not thread-safe.
  mutable bool was_clamped = false;
};

// The animations that pose the scene; or none, and the scene is at rest.
struct GltfAnimation {
  bool at_rest = true;
  double time = 0.0;                 // requested time in seconds
  double open = 0.0, close = 0.0;    // shutter interval in seconds; equal for an instant
  std::optional<double> next_frame;  // GltfOptions::later, for an instant
  double duration = 0.0;             // of the longest animation
  // In file order; if two tracks have the same target, the later wins.
  std::vector<NodeTrack> nodes;            // without visibility
  std::map<size_t, KeyFrames> visibility;  // by node
  std::vector<PointerTrack> pointers;
  // The file's own weights, for nodes whose weights are animated.
  std::map<size_t, std::vector<double>> weights;
  MemoryReservation memory;

  float shutter_fraction(double seconds) const {
    return open < close ? float((seconds - open) / (close - open)) : 0.0f;
  }
};

// Animated values of a node; absent values stay as in the file.
struct NodePose {
  std::optional<Vec3d> translation, scale;
  std::optional<Quaternion> rotation;
  std::vector<double> weights;  // of all morph targets; empty: absent
};
using GltfPose = std::map<size_t, NodePose>;  // by node; empty: at rest

// Validates the JSON of each animation; broken ones are noted (gltf/document/faults.h).
void check_gltf_animations(GltfDocument& document);

// Name, duration and targets of every animation. Does not read key frames.
std::vector<AnimationDescription> describe_animations(const GltfDocument& document);

// Reads the animations that the options choose from `list`, without ineffective channels. Call
// set_time next. Throws UsageError if there is no such animation, InputError if it is broken.
GltfAnimation read_animation(const GltfDocument& document, const GltfOptions& options,
                             const std::vector<AnimationDescription>& list);

// Sets time and shutter from the options. Logs a time outside the animation.
void set_time(const GltfDocument& document, const GltfOptions& options, GltfAnimation& animation);

// Per node: whether its transform, an ancestor's transform, or its visibility depends on time.
std::vector<char> nodes_that_may_move(const GltfDocument& document, const GltfAnimation& animation);

// The nodes' poses; visibility is in gltf/animation/visibility.h. Pure. Takes logarithmic time in
// the number of keys per track.
GltfPose pose_at(const GltfAnimation& animation, double time);
// Shutter opening, the key times in between, and shutter closing, ascending; one for an instant.
std::vector<double> shutter_key_times(const GltfAnimation& animation,
                                      std::span<const KeyFrames* const> keys);
// The pointer's value, clamped to the range of the specification, since splines may overshoot.
void sample_value(const PointerTrack& track, double time, std::span<double> value);
// Writes all other animated values at this time, overwriting earlier ones.
void write_values_at(const GltfAnimation& animation, double time, nlohmann::json& document);
// Warns about clamped values.
void report_clamped_values(const GltfDocument& document, const GltfAnimation& animation);

}  // namespace emberline
