// The animations of a file: what moves, and where it is at a time.
//
// Nodes are posed by values of their own (GltfPose), which cost little at any number of times.
// Everything else that a KHR_animation_pointer leads to is written into the document's JSON, from
// which materials, lights and cameras are then read as ever; of some of it gltf/animation/changes.h
// says how it goes on from there.
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

// Of a number, or numbers, of the document.
struct PointerTrack {
  std::string pointer;
  const schema::Property* property = nullptr;
  KeyFrames keys;
  // Whether sample_value clamped a value since write_values_at began. Reading is one thread's.
  mutable bool goes_beyond = false;
};

// The animations that pose the scene, or none: it is at rest.
struct GltfAnimation {
  bool at_rest = true;
  double time = 0.0;               // seconds: the pose that was asked for
  double open = 0.0, close = 0.0;  // when the shutter is: the same, for an instant
  std::optional<double> later;     // of an instant: GltfOptions::later
  double duration = 0.0;           // of the longest
  // In the file's order: of two that move the same the later counts.
  std::vector<NodeTrack> nodes;            // but for their visibility
  std::map<size_t, KeyFrames> visibility;  // by node
  std::vector<PointerTrack> pointers;
  // Of nodes whose weights are animated: as the file has them.
  std::map<size_t, std::vector<double>> weights;
  MemoryReservation memory;

  float share_of_shutter(double seconds) const {
    return open < close ? float((seconds - open) / (close - open)) : 0.0f;
  }
};

// What animations make of a node; what is absent is as the file has it.
struct NodePose {
  std::optional<Vec3d> translation, scale;
  std::optional<Quaternion> rotation;
  std::vector<double> weights;  // of every morph target; empty: absent
};
using GltfPose = std::map<size_t, NodePose>;  // by node; empty: at rest

// Looks at what the JSON says of each animation: what is broken is noted (gltf/document/faults.h).
void check_gltf_animations(GltfDocument& document);

// Of every animation: name, duration, what it moves. Their key frames are not read.
std::vector<AnimationDescription> describe_animations(const GltfDocument& document);

// Reads the animations that the options choose, of those that `list` names. Channels without effect
// are left out; set_time follows. Throws UsageError where there is no such animation, InputError
// where it is broken.
GltfAnimation read_animation(const GltfDocument& document, const GltfOptions& options,
                             const std::vector<AnimationDescription>& list);

// When, as the options say. A time outside of it is told.
void set_time(const GltfDocument& document, const GltfOptions& options, GltfAnimation& animation);

// Per node: whether another time may find it, or a node above it, elsewhere; or hidden, or not.
std::vector<char> nodes_that_may_move(const GltfDocument& document, const GltfAnimation& animation);

// Where the nodes are (gltf/animation/visibility.h says whether they are seen). Pure; takes, for
// each track, the logarithm of its keys.
GltfPose pose_at(const GltfAnimation& animation, double time);
// When the shutter opens, the key frames while it is open, and when it closes: growing, and of an
// instant that alone.
std::vector<double> times_within(const GltfAnimation& animation,
                                 std::span<const KeyFrames* const> keys);
// What a pointer's value is: within what the specification allows, beyond which splines may swing.
void sample_value(const PointerTrack& track, double time, std::span<double> value);
// Writes what else is animated, as it is at the time; what was written for another is overwritten.
void write_values_at(const GltfAnimation& animation, double time, nlohmann::json& document);
// Warns of the values that were clamped.
void report_clamped_values(const GltfDocument& document, const GltfAnimation& animation);

}  // namespace emberline
