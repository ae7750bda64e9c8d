#include "io/gltf/geometry/deform.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "renderer/core/errors.h"

namespace emberline {
namespace {

using nlohmann::json;

template <class Vector>
void add_scaled(const std::vector<float>& delta, int components, float weight,
                std::vector<Vector>& values) {
  if (delta.empty()) return;
  for (size_t i = 0; i < values.size(); ++i) {
    for (int c = 0; c < components; ++c) {
      values[i][c] += weight * delta[i * size_t(components) + size_t(c)];
    }
  }
}

// Returns the matrix for normals (row vectors, n' = n * result). Its upper 3x3 has the cofactors of
// the upper 3x3 of `m`, which exist even if `m` is singular. The cofactors are the inverse
// transpose times the determinant. Multiplying them by the determinant's sign keeps normals on
// their side of the surface.
Mat44d normal_matrix(const Mat44d& m) {
  const Vec3d r0 = row(m, 0), r1 = row(m, 1), r2 = row(m, 2);
  const Vec3d c0 = cross(r1, r2), c1 = cross(r2, r0), c2 = cross(r0, r1);
  const double sign = dot(r0, c0) < 0.0 ? -1.0 : 1.0;
  return Mat44d(sign * c0.x, sign * c0.y, sign * c0.z, 0, sign * c1.x, sign * c1.y, sign * c1.z, 0,
                sign * c2.x, sign * c2.y, sign * c2.z, 0, 0, 0, 0, 1);
}

Vec3f transform_direction(const Vec3f& v, const Mat44d& m) {
  Vec3d out;
  m.multDirMatrix(Vec3d(v), out);
  const double length = std::sqrt(dot(out, out));
  return length > 0.0 && std::isfinite(length) ? Vec3f(out / length) : Vec3f(0.0f);
}

}  // namespace

void apply_morph_targets(const PrimitiveReader& reader, const GltfDocument& document,
                         const json& primitive, const std::string& pointer,
                         std::span<const double> weights, MeshDescription& mesh) {
  const json* targets = find_member(primitive, "targets");
  const size_t target_count = targets ? targets->size() : 0;
  if (target_count == 0) return;
  if (weights.size() > target_count) {
    throw InputError(document.place(pointer + "/targets"),
                     "found {} weights, but only {} morph targets", weights.size(), target_count);
  }
  for (size_t t = 0; t < weights.size(); ++t) {
    const float weight = float(weights[t]);
    if (weight == 0.0f) continue;
    add_scaled(reader.target_floats(t, "POSITION", 3), 3, weight, mesh.positions);
    if (!mesh.normals.empty()) {
      add_scaled(reader.target_floats(t, "NORMAL", 3), 3, weight, mesh.normals);
    }
    // Tangent displacements have no w, because the handedness does not morph.
    if (!mesh.tangents.empty()) {
      add_scaled(reader.target_floats(t, "TANGENT", 3), 3, weight, mesh.tangents);
    }
    for (size_t set = 0; set < mesh.uv_sets.size(); ++set) {
      const std::string name = "TEXCOORD_" + std::to_string(set);
      if (!mesh.uv_sets[set].empty() && reader.has(name)) {
        add_scaled(reader.target_floats(t, name, 2), 2, weight, mesh.uv_sets[set]);
      }
    }
    if (!mesh.colors.empty()) {
      const int components = reader.components("COLOR_0") == 3 ? 3 : 4;
      add_scaled(reader.target_floats(t, "COLOR_0", components), components, weight, mesh.colors);
    }
  }
  for (auto& uv_set : mesh.uv_sets) {
    for (Vec2f& uv : uv_set) {
      if (!std::isfinite(uv.x) || !std::isfinite(uv.y)) uv = Vec2f(0.0f);
    }
  }
}

void apply_skin(const PrimitiveReader& reader, const GltfDocument& document,
                const std::string& pointer, std::span<const Mat44d> joints, MeshDescription& mesh) {
  if (joints.empty()) return;
  std::vector<Mat44d> blended(mesh.positions.size(), Mat44d(0.0));
  std::vector<double> sums(mesh.positions.size(), 0.0);
  for (int set = 0;; ++set) {
    const std::string suffix = std::to_string(set);
    if (!reader.has("JOINTS_" + suffix) || !reader.has("WEIGHTS_" + suffix)) break;
    const std::vector<float> indices = reader.floats("JOINTS_" + suffix, 4);
    const std::vector<float> weights = reader.floats("WEIGHTS_" + suffix, 4);
    for (size_t i = 0; i < indices.size(); ++i) {
      const float weight = weights[i];
      if (weight == 0.0f) continue;
      if (!(indices[i] >= 0.0f && indices[i] < float(joints.size()))) {
        throw InputError(document.place(pointer + "/attributes/JOINTS_" + suffix),
                         "vertex {} uses a joint outside the skin's {} joints",
                         reader.file_vertex(i / 4), joints.size());
      }
      blended[i / 4] += joints[size_t(indices[i])] * double(weight);
      sums[i / 4] += double(weight);
    }
  }
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    // Quantised weights may not add up to 1, so they are divided by their sum. A vertex without
    // weights follows the first joint.
    const Mat44d matrix = sums[v] != 0.0 ? blended[v] * (1.0 / sums[v]) : joints[0];
    Vec3d position;
    matrix.multVecMatrix(Vec3d(mesh.positions[v]), position);
    mesh.positions[v] = Vec3f(position);
    if (!mesh.normals.empty()) {
      mesh.normals[v] = transform_direction(mesh.normals[v], normal_matrix(matrix));
    }
    if (!mesh.tangents.empty()) {
      Vec4f& t = mesh.tangents[v];
      const Vec3f turned = transform_direction(Vec3f(t.x, t.y, t.z), matrix);
      t = Vec4f(turned.x, turned.y, turned.z, t.w);
    }
  }
}

}  // namespace emberline
