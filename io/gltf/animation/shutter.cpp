#include "io/gltf/animation/shutter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "io/gltf/document/tiny_gltf_renamed.h"
#include "io/gltf/geometry/transform.h"
#include "renderer/description/transform_parts.h"

namespace emberline {
namespace {

using nlohmann::json;

// Limit on the segments (intervals between steps). It is our choice. Embree supports up to 128.
constexpr size_t kMaxSegments = 64;
constexpr size_t kMaxTransforms = size_t(1) << 22;  // limit on nodes times steps; 512 MiB
// Largest visible deviation from the path, relative to the object's radius.
constexpr double kTolerance = 1e-3;
// Largest rotation between two steps, in radians, if vertices move linearly between the steps. The
// chord of an arc of this angle deviates from the arc by kTolerance.
constexpr double kMaxJointRotation = 0.09;
constexpr double kMaxRotation = 0.8;      // limit if Embree interpolates the rotation
constexpr double kMaxKeptRotation = 1.6;  // limit between steps kept by reduce_transforms()

double angle_between(const Imath::Quatd& a, const Imath::Quatd& b) {
  return 2.0 * std::acos(std::min(1.0, std::abs(a ^ b)));
}

// Transforms `a` and `b` move each point of a ball around the origin to two positions. Returns an
// upper bound on the distance between them.
double distance_between(const Mat44d& a, const Mat44d& b, double radius) {
  double shift = 0.0, turn = 0.0;
  for (int c = 0; c < 3; ++c) {
    shift += square(a[3][c] - b[3][c]);
    for (int r = 0; r < 3; ++r) turn += square(a[r][c] - b[r][c]);
  }
  return std::sqrt(shift) + radius * std::sqrt(turn);
}

double max_scale(const Mat44d& m) {
  double sum = 0.0;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) sum += square(m[r][c]);
  }
  return std::sqrt(sum);
}

WorldBounds position_bounds(const GltfDocument& document, const json& mesh) {
  WorldBounds bounds;
  if (mesh.is_null()) return bounds;
  for (const json& primitive : mesh.at("primitives")) {
    const json* index = find_member(primitive.at("attributes"), "POSITION");
    if (!index || index->is_null()) continue;
    const json& accessor = document.array("accessors")[index->get<size_t>()];
    for (const char* name : {"min", "max"}) {
      const json* bound = accessor.is_null() ? nullptr : find_member(accessor, name);
      if (!bound || bound->size() != 3) return {};
      Vec3d corner;
      for (int c = 0; c < 3; ++c) {
        const json& number = (*bound)[size_t(c)];
        corner[c] = number.is_number() ? number.get<double>() : HUGE_VAL;
        if (!(std::abs(corner[c]) <= std::numeric_limits<float>::max())) return {};
      }
      bounds.extendBy(corner);
    }
  }
  return bounds;
}

// Returns the largest number of key frames that any track has in the interval. Motion is smooth
// between key frames.
size_t max_keys_within(const GltfAnimation& animation, double open, double close) {
  size_t most = 0;
  for (const NodeTrack& track : animation.nodes) {
    const std::vector<float>& times = *track.keys.times;
    const auto first = std::upper_bound(times.begin(), times.end(), open);
    const auto last = std::lower_bound(first, times.end(), close);
    most = std::max(most, size_t(last - first));
  }
  return most;
}

}  // namespace

GltfShutter::GltfShutter(const GltfDocument& document, const GltfAnimation& animation)
    : document_(document),
      animation_(animation),
      open_(animation.open),
      close_(animation.next_frame.value_or(animation.close)),
      memory_(document.progress->budget(), MemoryPart::kGeometry) {
  if (!animation.at_rest) {
    for (const json& mesh : document.array("meshes")) {
      bounds_.push_back(position_bounds(document, mesh));
    }
  }
  poses_.push_back(pose_at(animation, open_));
  world_ = world_transforms(document, poses_[0]);
  if (!(open_ < close_) || animation.nodes.empty()) return;
  find_moving_nodes();
  size_t most = is_instant() ? 1 : kMaxSegments;
  while (most > 2 && order_.size() * (most + 1) > kMaxTransforms) most /= 2;
  // Reserves memory for the matrices and for the poses from which they are computed.
  size_t numbers = 0;
  for (const NodeTrack& track : animation.nodes) numbers += track.keys.width;
  memory_.add(bytes_of(order_.size() * (most + 1), sizeof(Mat44d)) +
                  bytes_of(most + 1, numbers * sizeof(double) +
                                         animation.nodes.size() * 2 * sizeof(NodePose)),
              document.file);
  size_t segments = std::min(most, size_t(2));
  while (segments < most && segments < 2 * (max_keys_within(animation, open_, close_) + 1))
    segments *= 2;
  sample_poses(segments);
  while (segments < most && !is_fine_enough()) sample_poses(segments *= 2);
}

void GltfShutter::find_moving_nodes() {
  std::vector<char> posed(document_.model->nodes.size(), 0);
  for (const NodeTrack& track : animation_.nodes) {
    const NodeProperty property = track.target.property;
    if (property == NodeProperty::kTranslation || property == NodeProperty::kRotation ||
        property == NodeProperty::kScale) {
      posed[track.target.node] = 1;
    }
  }
  moving_.assign(document_.model->nodes.size(), kNotMoving);
  for (const int node : document_.node_order) {
    const int parent = document_.parents[size_t(node)];
    const bool parent_moves = parent >= 0 && moving_[size_t(parent)] != kNotMoving;
    if (!posed[size_t(node)] && !parent_moves) continue;
    moving_[size_t(node)] = uint32_t(order_.size());
    order_.push_back(size_t(node));
  }
}

void GltfShutter::sample_poses(size_t segments) {
  poses_.resize(1);
  motion_.assign(1, {});
  for (const size_t node : order_) motion_[0].push_back(world_[node]);
  for (size_t step = 1; step <= segments; ++step) {
    document_.progress->check();
    const double share = double(step) / double(segments);
    poses_.push_back(pose_at(animation_, open_ + (close_ - open_) * share));
    std::vector<Mat44d>& worlds = motion_.emplace_back();
    worlds.reserve(order_.size());
    for (const size_t node : order_) {
      Mat44d m = local_transform(document_, node, poses_.back());
      const int parent = document_.parents[node];
      if (parent >= 0) {
        m = m * (moves(size_t(parent)) ? worlds[moving_[size_t(parent)]] : world_[size_t(parent)]);
      }
      check_transform(m, document_.place("/nodes/" + std::to_string(node)));
      worlds.push_back(m);
    }
  }
}

// Returns the radius of the node's mesh in world space at shutter opening. If that is 0, returns
// the largest radius of all steps. If the mesh's bounds are unknown, returns the length of the
// node's path. Without a mesh, returns 0.
double GltfShutter::node_radius(size_t i) const {
  const size_t node = order_[i];
  const int mesh = document_.model->nodes[node].mesh;
  if (mesh < 0) return 0.0;
  const double of_mesh = radius(size_t(mesh));
  if (std::isfinite(of_mesh)) {
    const double opening = max_scale(world_[node]);
    if (opening > 0.0) return of_mesh * opening;
    double largest = 0.0;
    for (const std::vector<Mat44d>& step : motion_) {
      largest = std::max(largest, max_scale(step[i]));
    }
    return of_mesh * largest;
  }
  double path_length = 0.0;
  for (size_t step = 1; step < steps(); ++step) {
    path_length += distance_between(motion_[step - 1][i], motion_[step][i], 0.0);
  }
  return path_length;
}

// Whether the object's handedness flips between two steps. Interpolation cannot reproduce this.
bool GltfShutter::flips_handedness(size_t i) const {
  double before = 0.0;
  for (size_t step = 0; step < steps(); ++step) {
    const Mat44d& m = motion_[step][i];
    if (is_singular(m)) continue;
    const double now = m.determinant();
    if (before * now < 0.0) return true;
    before = now;
  }
  return false;
}

// Whether interpolation between the even-numbered steps predicts every odd-numbered step.
bool GltfShutter::is_fine_enough() const {
  for (size_t i = 0; i < order_.size(); ++i) {
    const double radius = node_radius(i);
    const bool is_seen = radius > 0.0;
    if (is_seen && flips_handedness(i)) return false;
    const int mesh = document_.model->nodes[order_[i]].mesh;
    const double of_mesh = mesh < 0 ? 0.0 : this->radius(size_t(mesh));
    const double own = std::isfinite(of_mesh) ? of_mesh : 1.0;
    for (size_t step = 0; step + 2 < steps(); step += 2) {
      const Mat44d& middle = motion_[step + 1][i];
      // An object scaled to zero has no rotation to compare, but it may suddenly appear or vanish.
      if (is_singular(motion_[step][i]) || is_singular(motion_[step + 2][i])) {
        const Mat44d mean = (motion_[step][i] + motion_[step + 2][i]) * 0.5;
        if (is_seen && distance_between(mean, middle, own) > kTolerance * radius) {
          return false;
        }
        continue;
      }
      const TransformParts a(motion_[step][i]), b(motion_[step + 2][i]);
      if (angle_between(a.rotation, b.rotation) > (is_seen ? kMaxRotation : kMaxJointRotation))
        return false;
      const Mat44d expected = interpolate(a, b, 0.5).matrix();
      const double stretch = max_scale(middle);
      if (is_seen && stretch > 0.0 &&
          distance_between(expected, middle, radius / stretch) > kTolerance * radius) {
        return false;
      }
    }
  }
  return true;
}

double GltfShutter::radius(size_t mesh) const {
  const WorldBounds& b = bounds_[mesh];
  if (b.isEmpty()) return std::numeric_limits<double>::infinity();
  Vec3d corner;
  for (int c = 0; c < 3; ++c) corner[c] = std::max(std::abs(b.min[c]), std::abs(b.max[c]));
  return corner.length();
}

namespace {

// Thickens flattened steps. A thickened step is mirrored if the last invertible step before it is
// mirrored. If there is no such step, the first invertible step decides.
void thicken(std::vector<Mat44d>& steps, const Vec3d& center) {
  const auto first = std::ranges::find_if_not(steps, is_singular);
  bool mirrored = first != steps.end() && first->determinant() < 0.0;
  for (Mat44d& step : steps) {
    if (!is_singular(step)) {
      mirrored = step.determinant() < 0.0;
    } else if (const std::optional<Vec3d> axis = flattened_axis(step)) {
      step = thickened(step, *axis, kThickness, center, mirrored);
    }
  }
}

}  // namespace

std::vector<Mat44d> make_invertible(std::vector<Mat44d> steps, const Vec3d& center) {
  thicken(steps, center);
  std::vector<size_t> invertible;
  for (size_t i = 0; i < steps.size(); ++i) {
    if (!is_singular(steps[i])) invertible.push_back(i);
  }
  if (invertible.empty()) return {};
  size_t next = 0;
  for (size_t i = 0; i < steps.size(); ++i) {
    while (next + 1 < invertible.size() && invertible[next] < i) ++next;
    if (invertible[next] == i) continue;
    const bool nearer =
        next > 0 && i - invertible[next - 1] < (invertible[next] > i ? invertible[next] - i : i);
    const Mat44d& like = steps[nearer ? invertible[next - 1] : invertible[next]];
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) steps[i][r][c] = 1e-4 * like[r][c];
    }
  }
  return steps;
}

namespace {

// Returns the smallest number of segments (1, 2, 4, ... up to `segments`) for which the error of
// interpolating each step is at most `most`. error(step, before, after) is the error if `step` is
// interpolated between the kept steps `before` and `after`.
template <class Error>
size_t required_segments(size_t segments, double most, const Error& error) {
  for (size_t count = 1; count < segments; count *= 2) {
    const size_t stride = segments / count;
    bool enough = true;
    for (size_t step = 0; step <= segments && enough; ++step) {
      const size_t before = std::min(step / stride * stride, segments - stride);
      enough = error(step, before, before + stride) <= most;
    }
    if (enough) return count;
  }
  return segments;
}

template <class Step>
std::vector<Step> subsample(size_t stride, const std::vector<Step>& steps) {
  std::vector<Step> kept;
  for (size_t step = 0; step < steps.size(); step += stride) kept.push_back(steps[step]);
  return kept;
}

}  // namespace

std::vector<MeshPose> reduce_poses(std::vector<MeshPose> steps, double radius) {
  const auto blend = [](const auto& a, const auto& b, double share) { return a + (b - a) * share; };
  const auto error = [&](size_t step, size_t before, size_t after) {
    const MeshPose &a = steps[before], &b = steps[after], &at = steps[step];
    const double share = double(step - before) / double(after - before);
    double largest = 0.0;
    for (size_t j = 0; j < at.joints.size(); ++j) {
      largest = std::max(
          largest, distance_between(blend(a.joints[j], b.joints[j], share), at.joints[j], radius));
    }
    // We assume that a morph target moves no vertex further than about the mesh's radius.
    double morphed = 0.0;
    for (size_t t = 0; t < at.weights.size(); ++t) {
      morphed += std::abs(blend(a.weights[t], b.weights[t], share) - at.weights[t]);
    }
    return largest + morphed * radius;
  };
  if (!std::isfinite(radius)) return steps;
  const size_t segments = steps.size() - 1;
  return subsample(segments / required_segments(segments, kTolerance * radius, error), steps);
}

std::vector<Mat44d> reduce_transforms(std::vector<Mat44d> steps, double radius) {
  if (std::ranges::all_of(steps, [&](const Mat44d& m) { return m == steps[0]; })) return {};
  std::vector<TransformParts> parts;
  for (const Mat44d& m : steps) parts.emplace_back(m);
  double largest = 0.0;
  for (const Mat44d& m : steps) largest = std::max(largest, radius * max_scale(m));
  const auto error = [&](size_t step, size_t before, size_t after) {
    // The direction of a rotation by more than half a turn would be ambiguous.
    if (angle_between(parts[before].rotation, parts[after].rotation) > kMaxKeptRotation)
      return HUGE_VAL;
    const double share = double(step - before) / double(after - before);
    const Mat44d expected = interpolate(parts[before], parts[after], share).matrix();
    return distance_between(expected, steps[step], radius);
  };
  const size_t segments = steps.size() - 1;
  return subsample(segments / required_segments(segments, kTolerance * largest, error), steps);
}

}  // namespace emberline
