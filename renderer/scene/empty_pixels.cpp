#include "renderer/scene/empty_pixels.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <span>

#include "renderer/core/parallel.h"
#include "renderer/scene/camera.h"
#include "renderer/scene/geometry.h"

namespace emberline {
namespace {

using Vec2d = Imath::Vec2<double>;

// Maximum number of cells of a map. In frames with more pixels, a cell covers several of them.
constexpr int64_t kMaxCells = int64_t(1) << 20;
// Maximum number of triangles; chosen by us. Each takes about 200 ns of one thread
// (tests/bench/results).
constexpr uint64_t kMaxTriangles = uint64_t(1) << 20;
// Limit on the work: the average number of times that a cell may be marked.
constexpr int64_t kMaxMarksPerCell = 64;
// A map with a smaller fraction of empty cells is not worth its cost.
constexpr double kMinEmptyFraction = 1.0 / 64;
// Safety margin in pixels around the filter's reach. The error of the camera's position already
// covers the rounding of ray directions.
constexpr double kMargin = 1.0 / 16;
// A ray's hit may lie beside its triangle. The distance is at most this number times the error
// bound of the surface point (README.md, "Ray offsets") times the condition number of the
// transform. The number covers the rounding of rays that are transformed into an instance, and a
// safety margin.
constexpr double kErrorScale = 16;

// Returns the condition number of an instance's transform in the Frobenius norm. It is 3 for
// similarities.
double condition_of(const scene_detail::Instance& instance) {
  if (!instance.transformed) return 3;
  const auto& m = instance.to_internal;
  const Vec3d x = to_double(m.x), y = to_double(m.y), z = to_double(m.z);
  const Vec3d a = y.cross(z), b = z.cross(x), c = x.cross(y);
  return std::sqrt((x.length2() + y.length2() + z.length2()) *
                   (a.length2() + b.length2() + c.length2())) /
         std::abs(x.dot(a));
}

}  // namespace

using scene_detail::placed_corners;
using scene_detail::plane_error;

// Projects triangles onto cells.
class EmptyPixels::Projection {
 public:
  Projection(EmptyPixels& map, const Camera& camera, int width, int height, float reach)
      : map_(map),
        camera_(camera),
        cell_(std::ldexp(1.0, map.shift_)),
        pixel_margin_(double(reach) - 0.5 + kMargin) {
    camera_error_ = 4 * 0x1p-23 * max_abs_component(camera.position());
    const Vec2d pixel = camera.pixel_size();
    const double across = (0.5 * width + reach + kMargin) * pixel.x;
    const double down = (0.5 * height + reach + kMargin) * pixel.y;
    max_distance_ratio_ = std::sqrt(1 + across * across + down * down) * 2;
    pixels_per_error_ = 1 / std::min(pixel.x, pixel.y) + 2.0 * (width + height) + 4.0 * reach;
  }

  // Marks the cells in which a triangle may be visible. Adds the work to `*marks`: the number of
  // these cells plus the number of their rows. Returns false if the cells cannot be bounded.
  bool mark(const std::array<Vec3d, 3>& corners, double error, int64_t* marks) const;
  // Returns a bound on the distance between a point of a triangle and the position where a ray may
  // hit it. `plane_error_bound` is the triangle's plane_error().
  double error(float plane_error_bound, double condition) const {
    return kErrorScale * condition * (double(plane_error_bound) + camera_error_);
  }

 private:
  double min_visible_depth(const std::array<Vec3d, 3>& corners) const;
  void mark_outline(std::span<const Vec2d> outline, double slack, int64_t* marks) const;
  void mark_cells(double left, double right, int row, int64_t* marks) const;
  int cell_at(double film, int count) const {
    return int(std::clamp(std::floor(film / cell_), -1.0, double(count)));
  }

  EmptyPixels& map_;
  const Camera& camera_;
  const double cell_, pixel_margin_;
  double camera_error_;        // error of the camera's position, like plane_error()
  double max_distance_ratio_;  // twice the largest ratio of distance to depth in the frame
  double pixels_per_error_;    // largest shift on the film, in pixels, for an error of 1 at depth 1
};

// Returns a lower bound on the depth of the triangle's visible points. It follows from the camera's
// distance to the triangle's plane.
double EmptyPixels::Projection::min_visible_depth(const std::array<Vec3d, 3>& p) const {
  const Vec3d normal = (p[1] - p[0]).cross(p[2] - p[0]);
  const double length = normal.length();
  if (!(length > 0)) return 0;
  return std::abs(normal.dot(p[0] - camera_.position())) / length / max_distance_ratio_;
}

bool EmptyPixels::Projection::mark(const std::array<Vec3d, 3>& corners, double error,
                                   int64_t* marks) const {
  std::array<Vec3d, 3> p;
  for (size_t i = 0; i < 3; ++i) p[i] = camera_.project_to_film(corners[i]);
  const auto [min_depth, max_depth] = std::minmax({p[0].z, p[1].z, p[2].z});
  if (!std::isfinite(error) || max_depth < -error) return std::isfinite(error);
  double near_depth = min_depth;
  std::array<Vec2d, 4> outline;
  size_t count = 0;
  const auto add = [&](const Vec3d& q) { outline[count++] = Vec2d(q.x / q.z, q.y / q.z); };
  if (near_depth > 16 * error) {
    for (const Vec3d& q : p) add(q);
  } else {
    near_depth = min_visible_depth(corners);
    if (!(near_depth > 16 * error)) return false;
    for (size_t i = 0; i < 3; ++i) {
      const Vec3d &a = p[i], &b = p[(i + 1) % 3];
      if (a.z >= near_depth) add(a);
      if ((a.z >= near_depth) != (b.z >= near_depth))
        add(a + (b - a) * ((near_depth - a.z) / (b.z - a.z)));
    }
    if (count == 0) return true;
  }
  mark_outline({outline.data(), count}, pixel_margin_ + error / near_depth * pixels_per_error_,
               marks);
  return true;
}

// In each row, marks the cells between the left and right ends of a convex outline.
void EmptyPixels::Projection::mark_outline(std::span<const Vec2d> outline, double slack,
                                           int64_t* marks) const {
  Imath::Box2d box;
  for (const Vec2d& p : outline) box.extendBy(p);
  const int first = std::max(0, cell_at(box.min.y - slack, map_.rows_));
  const int last = std::min(cell_at(box.max.y + slack, map_.rows_), map_.rows_ - 1);
  const bool small = last - first < 2;  // true for most triangles; the box is then exact enough
  for (int row = first; row <= last; ++row) {
    if (small) {
      mark_cells(box.min.x - slack, box.max.x + slack, row, marks);
      continue;
    }
    const double top = row * cell_ - slack, bottom = (row + 1) * cell_ + slack;
    double left = std::numeric_limits<double>::infinity(), right = -left;
    const auto reach = [&](double x) {
      left = std::min(left, x);
      right = std::max(right, x);
    };
    for (size_t i = 0; i < outline.size(); ++i) {
      const Vec2d &a = outline[i], &b = outline[i + 1 == outline.size() ? 0 : i + 1];
      if (a.y >= top && a.y <= bottom) reach(a.x);
      for (const double edge : {top, bottom}) {
        if ((a.y < edge) != (b.y < edge)) reach(a.x + (b.x - a.x) * ((edge - a.y) / (b.y - a.y)));
      }
    }
    mark_cells(left - slack, right + slack, row, marks);
  }
}

void EmptyPixels::Projection::mark_cells(double left, double right, int row, int64_t* marks) const {
  const int first = std::max(0, cell_at(left, map_.columns_));
  const int last = std::min(cell_at(right, map_.columns_), map_.columns_ - 1);
  uint8_t* const cells = &map_.used_[size_t(row) * size_t(map_.columns_)];
  // Several threads may mark the same cell.
  for (int i = first; i <= last; ++i) {
    std::atomic_ref<uint8_t>(cells[i]).store(1, std::memory_order_relaxed);
  }
  *marks += std::max(0, last - first + 1) + 1;
}

EmptyPixels::EmptyPixels(int width, int height) {
  const auto cells = [&](int size) { return ((size - 1) >> shift_) + 1; };
  while (int64_t(cells(width)) * cells(height) > kMaxCells) ++shift_;
  columns_ = cells(width);
  rows_ = cells(height);
  used_.assign(size_t(columns_) * size_t(rows_), 0);
}

// Returns false if the cells to mark cannot be bounded or take too much work. The result is
// deterministic: the number of marks counted is either exact or above the limit.
bool EmptyPixels::mark_all(const Scene& scene, const Projection& projection) {
  const int64_t limit = kMaxMarksPerCell * int64_t(used_.size());
  std::atomic<int64_t> marks{0};
  std::atomic<bool> is_bounded{true};
  const auto mark_range = [&](const scene_detail::Instance& instance, size_t begin, size_t end) {
    const scene_detail::Mesh& mesh = scene.meshes_[instance.mesh];
    const double condition = condition_of(instance);
    int64_t found = 0;
    for (size_t i = begin; i < end && is_bounded.load(std::memory_order_relaxed); ++i) {
      const auto triangle = uint32_t(i);
      const double error = projection.error(plane_error(mesh, instance, triangle), condition);
      if (!projection.mark(placed_corners(mesh, instance, triangle), error, &found) ||
          found > limit) {
        is_bounded.store(false, std::memory_order_relaxed);
      }
    }
    marks.fetch_add(found, std::memory_order_relaxed);
  };
  parallel_each(scene.instances_.size(), 64, [&](size_t i) {
    const scene_detail::Instance& instance = scene.instances_[i];
    const size_t triangles = scene.meshes_[instance.mesh].triangles.size();
    parallel_ranges(triangles, 4096,
                    [&](size_t first, size_t last) { mark_range(instance, first, last); });
  });
  return is_bounded && marks <= limit;
}

bool EmptyPixels::is_worthwhile() const {
  const auto empty = std::ranges::count(used_, uint8_t(0));
  return double(empty) >= kMinEmptyFraction * double(used_.size());
}

std::shared_ptr<const EmptyPixels> EmptyPixels::find(const Scene& scene, const Camera& camera,
                                                     int width, int height, float reach) {
  if (!camera.is_static_pinhole() || scene.moves()) return nullptr;
  if (scene.triangle_count() > kMaxTriangles) return nullptr;
  std::shared_ptr<EmptyPixels> map(new EmptyPixels(width, height));
  const Projection projection(*map, camera, width, height, reach);
  if (!map->mark_all(scene, projection) || !map->is_worthwhile()) return nullptr;
  return map;
}

}  // namespace emberline
