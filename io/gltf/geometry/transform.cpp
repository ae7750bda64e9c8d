#include "io/gltf/geometry/transform.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include "io/gltf/document/tiny_gltf_renamed.h"

#include "renderer/core/errors.h"
#include "renderer/core/log.h"

namespace emberline {
namespace {

using nlohmann::json;

// Returns the node's pose, or an empty one if the node is not animated.
const NodePose& pose_of(const GltfPose& pose, int node) {
  static const NodePose at_rest;
  const auto found = pose.find(size_t(node));
  return found == pose.end() ? at_rest : found->second;
}

Quaternion rotation_of(const tinygltf::Node& node, const NodePose& pose) {
  Quaternion own = {0.0, 0.0, 0.0, 1.0};
  if (node.rotation.size() == own.size()) std::ranges::copy(node.rotation, own.begin());
  return pose.rotation.value_or(own);
}

}  // namespace

Mat44d compose_transform(const Vec3d& translation, const Quaternion& rotation, const Vec3d& scale) {
  double x = rotation[0], y = rotation[1], z = rotation[2], w = rotation[3];
  const double length = std::sqrt(x * x + y * y + z * z + w * w);
  if (length > 0.0 && std::isfinite(length)) {
    x /= length, y /= length, z /= length, w /= length;
  } else {
    x = y = z = 0.0;
    w = 1.0;
  }
  // The rows are the images of the coordinate axes.
  const Vec3d rows[3] = {
      {1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)},
      {2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)},
      {2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)}};
  Mat44d m;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) m[r][c] = rows[r][c] * scale[r];
    m[3][r] = translation[r];
  }
  return m;
}

bool is_singular(const Mat44d& m) {
  const Vec3d r0 = row(m, 0), r1 = row(m, 1), r2 = row(m, 2);
  const double l0 = std::sqrt(dot(r0, r0)), l1 = std::sqrt(dot(r1, r1)),
               l2 = std::sqrt(dot(r2, r2));
  // The matrix is singular if an axis rounds to 0 in float, or if the axes span no volume except
  // for rounding errors.
  constexpr double kMinScale = 1e-30;
  if (!(l0 > kMinScale && l1 > kMinScale && l2 > kMinScale)) return true;
  return !(std::abs(dot(r0 / l0, cross(r1 / l1, r2 / l2))) > 1e-12);
}

std::optional<Vec3d> flattened_axis(const Mat44d& m) {
  Vec3d rows[3];
  double largest = 0.0;
  for (int r = 0; r < 3; ++r) {
    rows[r] = row(m, r);
    largest = std::max(largest, rows[r].length());
  }
  if (!(largest > 1e-30)) return {};
  for (Vec3d& r : rows) r /= largest;
  const Vec3d crosses[3] = {cross(rows[1], rows[2]), cross(rows[2], rows[0]),
                            cross(rows[0], rows[1])};
  const Vec3d* normal = &crosses[0];
  for (const Vec3d& c : crosses) {
    if (c.length2() > normal->length2()) normal = &c;
  }
  // This is the threshold of is_singular(), applied to the two rows that span the plane.
  if (!(normal->length() > 1e-12)) return {};
  const Vec3d n = normal->normalized();
  return Vec3d(dot(n, crosses[0]), dot(n, crosses[1]), dot(n, crosses[2])).normalized();
}

Mat44d thickened(const Mat44d& flat, const Vec3d& axis, double thickness, const Vec3d& center,
                 bool mirrored) {
  const Vec3d r0 = row(flat, 0), r1 = row(flat, 1), r2 = row(flat, 2);
  // The area vector of a unit square perpendicular to `axis` after the transform.
  const Vec3d area = cross(r1, r2) * axis.x + cross(r2, r0) * axis.y + cross(r0, r1) * axis.z;
  const double size = std::sqrt(area.length());
  const Vec3d normal = area / area.length() * (mirrored ? -thickness * size : thickness * size);
  Mat44d m = flat;
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) m[r][c] += axis[r] * normal[c];
    m[3][c] -= dot(axis, center) * normal[c];
  }
  return m;
}

Mat44d flattened(const Mat44d& m, const Vec3d& axis, const Vec3d& center) {
  Mat44d flat = m;
  for (int c = 0; c < 3; ++c) {
    const double along = axis.x * m[0][c] + axis.y * m[1][c] + axis.z * m[2][c];
    for (int r = 0; r < 3; ++r) flat[r][c] -= axis[r] * along;
    flat[3][c] += dot(axis, center) * along;
  }
  return flat;
}

std::optional<Mat44d> restore_directions(const Mat44d& m) {
  if (!is_singular(m)) return m;
  const std::optional<Vec3d> axis = flattened_axis(m);
  if (!axis) return {};
  return thickened(m, *axis, 1.0);
}

void check_transform(const Mat44d& m, const std::string& place) {
  // The limit is our choice. It is well below 1.8e19, whose square overflows float.
  constexpr double kLargest = 1e18;
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 4; ++c) {
      if (!(std::abs(m[r][c]) <= kLargest)) {
        throw InputError(place, "the node's world transform is not finite or exceeds 1e18");
      }
    }
  }
}

Mat44d local_transform(const GltfDocument& document, size_t index, const GltfPose& posed) {
  const tinygltf::Node& node = document.model->nodes[index];
  const NodePose& pose = pose_of(posed, int(index));
  if (node.matrix.size() == 16) {
    // A column-major matrix for column vectors has the same layout as a row-major matrix for row
    // vectors.
    Mat44d m;
    for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = node.matrix[size_t(i)];
    if (m[0][3] != 0.0 || m[1][3] != 0.0 || m[2][3] != 0.0 || m[3][3] != 1.0) {
      log_warning(document.file +
                  ": the last row of a node's matrix is not 0 0 0 1; it is replaced by 0 0 0 1");
    }
    m[0][3] = m[1][3] = m[2][3] = 0.0;
    m[3][3] = 1.0;
    for (int c = 0; c < 3 && pose.translation; ++c) m[3][c] = (*pose.translation)[c];
    return m;
  }
  const auto vector = [](const std::vector<double>& v, double fallback) {
    return v.size() == 3 ? Vec3d(v[0], v[1], v[2]) : Vec3d(fallback);
  };
  return compose_transform(pose.translation.value_or(vector(node.translation, 0.0)),
                           rotation_of(node, pose), pose.scale.value_or(vector(node.scale, 1.0)));
}

std::optional<Mat44d> aimed_transform(const GltfDocument& document, size_t node,
                                      const GltfPose& pose, const Mat44d& world) {
  if (const std::optional<Mat44d> directed = restore_directions(world)) return directed;
  Mat44d aimed;
  for (int at = int(node); at >= 0; at = document.parents[size_t(at)]) {
    const tinygltf::Node& source = document.model->nodes[size_t(at)];
    std::optional<Mat44d> turned =
        compose_transform(Vec3d(0.0), rotation_of(source, pose_of(pose, at)), Vec3d(1.0));
    if (source.matrix.size() == 16) {
      turned = restore_directions(local_transform(document, size_t(at), pose));
    }
    if (!turned) return {};
    aimed = aimed * *turned;
  }
  for (int c = 0; c < 3; ++c) aimed[3][c] = world[3][c];
  return aimed;
}

std::vector<Mat44d> world_transforms(const GltfDocument& document, const GltfPose& pose) {
  std::vector<Mat44d> world(document.model->nodes.size());
  for (const int node : document.node_order) {
    Mat44d m = local_transform(document, size_t(node), pose);
    const int parent = document.parents[size_t(node)];
    if (parent >= 0) m = m * world[size_t(parent)];
    const std::string pointer = "/nodes/" + std::to_string(node);
    try {
      if (parent >= 0) document.faults->require("/nodes/" + std::to_string(parent));
      check_transform(m, document.place(pointer));
      world[size_t(node)] = m;
    } catch (const InputError& error) {
      document.faults->note_broken(pointer, error);
    }
  }
  return world;
}

}  // namespace emberline
