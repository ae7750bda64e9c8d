#include "io/gltf/geometry/tangents.h"

#include <bit>
#include <unordered_map>

#include "renderer/core/frame.h"
#include "renderer/core/hash.h"

namespace emberline {
namespace {

using Triangle = std::array<uint32_t, 3>;

// Position, normal and UV of a corner. Corners whose keys are bit-identical (with -0 as 0) share a
// tangent.
using CornerKey = std::array<uint32_t, 8>;

uint32_t float_bits(float x) { return std::bit_cast<uint32_t>(x == 0.0f ? 0.0f : x); }

struct CornerKeyHash {
  size_t operator()(const CornerKey& key) const {
    uint64_t h = 0;
    for (const uint32_t word : key) h = hash64(h * 0x9e3779b97f4a7c15ull + word);
    return size_t(h);
  }
};

// Returns +1 if v decreases to the left of the direction of u, as it does on an upright image.
// Returns -1 if the texture is mirrored, and 0 if the triangle has no area in the texture.
int uv_orientation(const Vec2f& a, const Vec2f& b, const Vec2f& c) {
  const double area =
      (double(b.x) - a.x) * (double(c.y) - a.y) - (double(c.x) - a.x) * (double(b.y) - a.y);
  return area < 0.0 ? 1 : area > 0.0 ? -1 : 0;
}

// Returns the direction of increasing u in the triangle's plane.
Vec3d u_direction(const Vec3d& e1, const Vec3d& e2, const Vec2f& a, const Vec2f& b,
                  const Vec2f& c) {
  const double v1 = double(b.y) - a.y, v2 = double(c.y) - a.y;
  const double u1 = double(b.x) - a.x, u2 = double(c.x) - a.x;
  const Vec3d direction = e1 * v2 - e2 * v1;
  return u1 * v2 - u2 * v1 < 0.0 ? -direction : direction;
}

Vec3d project_to_plane(const Vec3d& v, const Vec3d& normal) {
  const Vec3d projected = v - normal * dot(normal, v);
  const double length = std::sqrt(dot(projected, projected));
  return length > 0.0 ? projected / length : Vec3d(0.0);
}

void split_per_face(MeshDescription& mesh) {
  const auto expand = [&](auto& values) {
    if (values.empty()) return;
    std::remove_reference_t<decltype(values)> expanded;
    expanded.reserve(mesh.triangles.size() * 3);
    for (const Triangle& t : mesh.triangles) {
      for (const uint32_t v : t) expanded.push_back(values[v]);
    }
    values = std::move(expanded);
  };
  for_each_vertex_array(mesh, expand);
  uint32_t next = 0;
  for (Triangle& t : mesh.triangles) {
    for (uint32_t& v : t) v = next++;
  }
}

std::vector<Vec3f> face_normals(const std::vector<Vec3f>& positions,
                                const std::vector<Triangle>& triangles) {
  std::vector<Vec3f> normals(positions.size());
  for (const Triangle& t : triangles) {
    const Vec3d a(positions[t[0]]), b(positions[t[1]]), c(positions[t[2]]);
    const Vec3d n = cross(b - a, c - a);
    const double length = std::sqrt(dot(n, n));
    for (const uint32_t v : t) normals[v] = length > 0.0 ? Vec3f(n / length) : Vec3f(0.0f);
  }
  return normals;
}

// Sums of weighted u directions, by corner key and side (UV orientation: 0 upright, 1 mirrored).
class TangentGroups {
 public:
  TangentGroups(const std::vector<Vec3f>& positions, const std::vector<Vec3f>& normals,
                const std::vector<Vec2f>& uv) {
    group_of_vertex_.resize(positions.size());
    std::unordered_map<CornerKey, uint32_t, CornerKeyHash> groups;
    groups.reserve(positions.size());
    for (size_t v = 0; v < positions.size(); ++v) {
      const Vec3f &p = positions[v], &n = normals[v];
      const CornerKey key = {float_bits(p.x),     float_bits(p.y),    float_bits(p.z),
                             float_bits(n.x),     float_bits(n.y),    float_bits(n.z),
                             float_bits(uv[v].x), float_bits(uv[v].y)};
      group_of_vertex_[v] = groups.try_emplace(key, uint32_t(groups.size())).first->second;
    }
    sums_.assign(groups.size(), {Vec3d(0.0), Vec3d(0.0)});
  }

  void add(uint32_t vertex, int side, const Vec3d& direction) {
    sums_[group_of_vertex_[vertex]][size_t(side)] += direction;
  }
  bool has(uint32_t vertex, int side) const {
    const Vec3d& sum = sums_[group_of_vertex_[vertex]][size_t(side)];
    return dot(sum, sum) > 0.0;
  }
  // Returns an arbitrary tangent if the sum has no direction.
  Vec4f tangent(uint32_t vertex, size_t side, const Vec3f& normal) const {
    const Vec3d& sum = sums_[group_of_vertex_[vertex]][side];
    const double length = std::sqrt(dot(sum, sum));
    if (!(length > 0.0 && std::isfinite(length))) return arbitrary_tangent(normal);
    const Vec3f t(sum / length);
    return Vec4f(t.x, t.y, t.z, side == 0 ? 1.0f : -1.0f);
  }

 private:
  std::vector<uint32_t> group_of_vertex_;
  std::vector<std::array<Vec3d, 2>> sums_;
};

TangentGroups accumulate(const std::vector<Vec3f>& positions, const std::vector<Vec3f>& normals,
                         const std::vector<Vec2f>& uv, const std::vector<Triangle>& triangles,
                         const std::vector<int8_t>& orientation) {
  TangentGroups groups(positions, normals, uv);
  for (size_t i = 0; i < triangles.size(); ++i) {
    if (orientation[i] == 0) continue;
    const Triangle& t = triangles[i];
    const Vec3d p[3] = {Vec3d(positions[t[0]]), Vec3d(positions[t[1]]), Vec3d(positions[t[2]])};
    const Vec3d direction = u_direction(p[1] - p[0], p[2] - p[0], uv[t[0]], uv[t[1]], uv[t[2]]);
    for (size_t k = 0; k < 3; ++k) {
      const Vec3d n(normals[t[k]]);
      const Vec3d to_next = project_to_plane(p[(k + 1) % 3] - p[k], n);
      const Vec3d to_last = project_to_plane(p[(k + 2) % 3] - p[k], n);
      const double angle = std::acos(std::clamp(dot(to_next, to_last), -1.0, 1.0));
      groups.add(t[k], orientation[i] > 0 ? 0 : 1, project_to_plane(direction, n) * angle);
    }
  }
  return groups;
}

// Appends a copy of `vertex` to every attribute.
uint32_t duplicate_vertex(MeshDescription& mesh, std::vector<Vec3f>& normals,
                          std::vector<Vec2f>& uv, uint32_t vertex) {
  const auto duplicate = [&](auto& values) {
    if (values.empty()) return;
    const auto value = values[vertex];
    values.push_back(value);
  };
  const uint32_t copy = uint32_t(mesh.positions.size());
  for_each_vertex_array(mesh, duplicate);
  duplicate(normals);
  duplicate(uv);
  return copy;
}

// Adds tangents to the motion steps. Vertices are split as in the first step, since the UV
// orientation of a triangle does not change.
void add_motion_tangents(MeshDescription& mesh, const std::vector<Vec2f>& uv,
                         const std::vector<int8_t>& orientation) {
  for (MeshStep& step : mesh.motion) {
    const std::vector<Vec3f> normals =
        step.normals.empty() ? face_normals(step.positions, mesh.triangles) : step.normals;
    const TangentGroups groups =
        accumulate(step.positions, normals, uv, mesh.triangles, orientation);
    for (uint32_t v = 0; v < mesh.tangents.size(); ++v) {
      step.tangents.push_back(groups.tangent(v, mesh.tangents[v].w > 0.0f ? 0 : 1, normals[v]));
    }
  }
}

}  // namespace

Vec4f arbitrary_tangent(const Vec3f& normal) {
  const Vec3f unit = normalize_or(normal, Vec3f(0.0f, 0.0f, 1.0f));
  const Vec3f t = ShadingFrame::from_normal(unit).tangent;
  return Vec4f(t.x, t.y, t.z, 1.0f);
}

void generate_tangents(MeshDescription& mesh, const TextureRef& layout) {
  if (mesh.triangles.empty()) return;
  const bool flat = mesh.normals.empty();
  if (flat) split_per_face(mesh);
  std::vector<Vec3f> normals =
      flat ? face_normals(mesh.positions, mesh.triangles) : std::move(mesh.normals);

  const std::array<float, 6>& m = layout.uv_transform;
  std::vector<Vec2f> uv = mesh.uv_sets.at(size_t(layout.uv_set));
  if (uv.empty()) uv.assign(mesh.positions.size(), Vec2f(0.0f));  // any direction will do then
  for (Vec2f& v : uv) {
    v = Vec2f(m[0] * v.x + m[1] * v.y + m[2], m[3] * v.x + m[4] * v.y + m[5]);
  }

  std::vector<int8_t> orientation(mesh.triangles.size());
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle& t = mesh.triangles[i];
    orientation[i] = int8_t(uv_orientation(uv[t[0]], uv[t[1]], uv[t[2]]));
  }
  const TangentGroups groups = accumulate(mesh.positions, normals, uv, mesh.triangles, orientation);

  // The first orientation found at a vertex keeps the vertex's index. The other orientation gets a
  // copy of the vertex.
  constexpr uint32_t kNone = UINT32_MAX;
  const size_t original_count = mesh.positions.size();
  std::vector<std::array<uint32_t, 2>> vertex_of_side(original_count, {kNone, kNone});
  mesh.tangents.assign(original_count, Vec4f(1.0f, 0.0f, 0.0f, 1.0f));
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (uint32_t& corner : mesh.triangles[i]) {
      const uint32_t vertex = corner;
      // At this vertex, a triangle without UV area takes the orientation of a neighbour.
      const size_t side = orientation[i] != 0
                              ? (orientation[i] > 0 ? 0 : 1)
                              : (groups.has(vertex, 0) || !groups.has(vertex, 1) ? 0 : 1);
      uint32_t& number = vertex_of_side[vertex][side];
      if (number == kNone) {
        if (vertex_of_side[vertex][1 - side] == kNone) {
          number = vertex;
        } else {
          number = duplicate_vertex(mesh, normals, uv, vertex);
        }
        mesh.tangents[number] = groups.tangent(vertex, side, normals[vertex]);
      }
      corner = number;
    }
  }
  if (!flat) mesh.normals = std::move(normals);
  add_motion_tangents(mesh, uv, orientation);
}

}  // namespace emberline
