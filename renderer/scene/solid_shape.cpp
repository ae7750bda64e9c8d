#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "renderer/core/hash.h"
#include "renderer/core/load_progress.h"
#include "renderer/core/log.h"
#include "renderer/core/shortened.h"
#include "renderer/scene/geometry.h"
#include "renderer/scene/solids.h"

namespace emberline::scene_detail {
namespace {

// Represents the boundary of a mesh as a sum over its directed edges. Each edge contributes a hash
// of its corners, with a sign for its direction, so that the edges of a closed mesh cancel. The sum
// of an open mesh is 0 by chance once in 2^64. Corners in the same grid cell count as one; the
// edges of a closed mesh then still cancel.
class Boundary {
 public:
  Boundary(const Imath::Box3f& bounds, float shift)
      : origin_(to_double(bounds.min)),
        per_cell_(kCells / std::max(1e-300, double(max_component(bounds.size())))),
        shift_(shift) {}
  void add(const std::array<Vec3f, 3>& corners) {
    uint64_t h[3];
    for (size_t c = 0; c < 3; ++c) h[c] = corner(corners[c]);
    sum_ += edge(h[0], h[1]) + edge(h[1], h[2]) + edge(h[2], h[0]);
  }
  bool empty() const { return sum_ == 0; }

 private:
  static constexpr double kCells = 1 << 16;  // cells along the longest side; chosen by us

  uint64_t corner(const Vec3f& p) const {
    uint64_t h = 0;
    for (int c = 0; c < 3; ++c) {
      h = hash_combine64(h, uint64_t((double(p[c]) - origin_[c]) * per_cell_ + shift_));
    }
    return h;
  }
  static uint64_t edge(uint64_t from, uint64_t to) {
    if (from == to) return 0;
    return from < to ? hash_combine64(from, to) : 0 - hash_combine64(to, from);
  }

  const Vec3d origin_;
  const double per_cell_, shift_;
  uint64_t sum_ = 0;
};

std::array<Vec3f, 3> corners_of(const Mesh& mesh, size_t triangle) {
  const auto& index = mesh.triangles[triangle];
  return {mesh.positions[index[0]], mesh.positions[index[1]], mesh.positions[index[2]]};
}

// Nearly identical corners may be in different cells of one grid, so several shifted grids are
// tried.
bool is_closed(std::span<const Mesh* const> meshes, const Imath::Box3f& bounds,
               LoadProgress& progress) {
  for (const float shift : {0.5f, 0.25f, 0.75f, 0.1f}) {
    Boundary boundary(bounds, shift);
    for (const Mesh* mesh : meshes) {
      for (size_t i = 0; i < mesh->triangles.size(); ++i) {
        if (i % 65536 == 0) progress.check();
        boundary.add(corners_of(*mesh, i));
      }
    }
    if (boundary.empty()) return true;
  }
  return false;
}

}  // namespace

SolidShape shape_of(std::span<const Mesh* const> meshes, const std::string* name,
                    LoadProgress& progress) {
  SolidShape shape;
  double volume = 0.0;
  const Vec3d origin = to_double(meshes[0]->positions[0]);
  Imath::Box3f bounds;
  for (const Mesh* mesh : meshes) {
    for (size_t i = 0; i < mesh->triangles.size(); ++i) {
      const std::array<Vec3f, 3> p = corners_of(*mesh, i);
      for (const Vec3f& corner : p) bounds.extendBy(corner);
      volume +=
          dot(to_double(p[0]) - origin, cross(to_double(p[1]) - origin, to_double(p[2]) - origin));
    }
    for (size_t step = 0; step <= mesh->motion.size(); ++step) {
      shape.bounds.extendBy(bounds_of(positions_at(*mesh, step)));
    }
  }
  shape.closed = is_closed(meshes, bounds, progress);
  shape.volume = std::abs(volume) / 6;
  if (name && shape.closed && volume < 0.0) {
    log_warning(fmt::format(
        "'{}' is glass whose faces point inwards: the space around it is treated as its inside",
        shortened(*name)));
  }
  return shape;
}

}  // namespace emberline::scene_detail
