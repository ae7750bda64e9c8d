// The search for emitters that lie in other surfaces (flush_emitters.h).
//
// Each triangle has its own plane_error(), which grows with the triangle's coordinates. The error
// of a distant triangle may exceed the size of a hundred near triangles. Therefore each triangle
// searches a tree of emitter points with a radius of its own, which depends on the errors of the
// triangle and of the point. If one radius had to cover the largest error, every emitter would find
// every other emitter.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <map>
#include <mutex>

#include "renderer/core/log.h"
#include "renderer/core/parallel.h"
#include "renderer/scene/emitter_points.h"
#include "renderer/scene/flush_emitters.h"

namespace emberline::scene_detail {
namespace {

// With more emitters than this, only their centres are tested, because they are then probably small
// compared with the surfaces that they lie in. Chosen by us.
constexpr size_t kManyEmitters = 1 << 16;

// Maximum number of triangles examined in total (a few seconds of work), and in a range, which is
// the unit of parallel work. We chose both.
constexpr uint64_t kMaxTriangles = uint64_t(1) << 26;
constexpr size_t kRangeSize = 4096;
// Limits on the number of points examined; chosen by us. The total limit is kMaxVisits plus
// kVisitsPerTriangle for each triangle; a range has its own limit as well. An ordinary triangle
// meets about ten points, whereas a wall meets the points of all lamps on it.
constexpr uint64_t kMaxVisits = uint64_t(1) << 24, kVisitsPerTriangle = 32,
                   kMaxVisitsPerRange = 1 << 22;

using Corners = std::array<Vec3d, 3>;

Vec3d unit_normal(const Corners& c) {  // 0 if the triangle is degenerate
  return (c[1] - c[0]).cross(c[2] - c[0]).normalized();
}

Corners corners_of(const EmissiveTriangle& t) {
  return {to_double(t.p0), to_double(t.p1), to_double(t.p2)};
}

// Returns the centre, then points near the corners.
std::array<Vec3d, 4> test_points(const Corners& c) {
  const Vec3d middle = (c[0] + c[1] + c[2]) / 3.0;
  return {middle, c[0] * 0.97 + middle * 0.03, c[1] * 0.97 + middle * 0.03,
          c[2] * 0.97 + middle * 0.03};
}

struct Plane {
  Vec3d point, normal;
  double distance(const Vec3d& p) const { return std::abs((p - point).dot(normal)); }
  // Distance of the farthest corner.
  double distance(const Corners& c) const {
    return std::max({distance(c[0]), distance(c[1]), distance(c[2])});
  }
};

// A surface in which an emitter may lie.
class Surface {
 public:
  explicit Surface(const Corners& corners)
      : corners_(corners),
        plane_{corners[0], unit_normal(corners)},
        e1_(corners[1] - corners[0]),
        e2_(corners[2] - corners[0]),
        n_(e1_.cross(e2_)),
        scale_(1.0 / n_.length2()) {}

  const Plane& plane() const { return plane_; }
  // Returns whether `emitter` lies in the surface at `point`, which is a point of the emitter.
  // `error` is the sum of both plane errors.
  bool contains(const EmissiveTriangle& emitter, const Vec3d& point, double error) const {
    // Without this test, a triangle smaller than the error would count as lying in every plane
    // through it.
    if (!(plane_.distance(point) <= 2.0 * error) || !covers(point)) return false;
    // It is enough if one triangle lies in the other's plane, since the plane of the smaller
    // triangle is inaccurate at the far end of the larger one.
    const Corners corners = corners_of(emitter);
    if (plane_.distance(corners) <= error) return true;
    return Plane{corners[0], unit_normal(corners)}.distance(corners_) <= error;
  }

 private:
  bool covers(const Vec3d& p) const {
    constexpr double kSlack = -1e-9;  // relative to the triangle; far above double's rounding
    const Vec3d d = p - plane_.point;
    const double u = d.cross(e2_).dot(n_) * scale_, v = e1_.cross(d).dot(n_) * scale_;
    return u >= kSlack && v >= kSlack && u + v <= 1.0 - kSlack;
  }

  Corners corners_;
  Plane plane_;
  Vec3d e1_, e2_, n_;
  double scale_;
};

float largest_coordinate(const Imath::Box3f& box) {
  return std::max(max_abs_component(box.min), max_abs_component(box.max));
}

class FlushSearch {
 public:
  FlushSearch(const PlacedEmitters& placed, LoadProgress& progress)
      : placed_(placed),
        progress_(progress),
        points_(emitter_points()),
        found_{std::vector<float>(placed.emitters.size(), 0.0f), {}} {}

  FlushSurfaces find() {
    if (points_.empty()) return std::move(found_);
    const std::vector<TriangleRange> ranges = ranges_near_emitters();
    const uint64_t visits = max_visits_per_range(ranges);
    parallel_each(ranges.size(), [&](size_t i) {
      progress_.check();
      search_range(ranges[i], visits);
    });
    for (size_t i = 0; i < placed_.emitters.size(); ++i) {
      if (found_.reach[i] > 0.0f) {
        record_offset(surface_key(placed_.emitters[i].instance, placed_.emitters[i].primitive),
                      found_.reach[i]);
      }
    }
    return std::move(found_);
  }

 private:
  struct TriangleRange {
    uint32_t instance;
    uint32_t begin, end;
  };

  EmitterPoints emitter_points() const;
  std::vector<TriangleRange> ranges_near_emitters() const;
  uint64_t max_visits_per_range(const std::vector<TriangleRange>& ranges) const;
  // Calls visit(triangle, surface, error, point) for each point that may lie in one of the range's
  // triangles, until visit returns false.
  template <typename Visit>
  void visit_points(const TriangleRange& range, const Visit& visit) const;
  void search_range(const TriangleRange& range, uint64_t visits_left);
  void record_offset(uint64_t key, float reach) {
    float& offset = found_.offsets[key];
    offset = std::max(offset, reach);
  }

  const PlacedEmitters& placed_;
  LoadProgress& progress_;
  const EmitterPoints points_;
  std::mutex mutex_;
  FlushSurfaces found_;
};

EmitterPoints FlushSearch::emitter_points() const {
  const size_t points_per_emitter = placed_.emitters.size() > kManyEmitters ? 1 : 4;
  std::vector<EmitterPoint> points;
  points.reserve(placed_.emitters.size() * points_per_emitter);
  for (uint32_t i = 0; i < placed_.emitters.size(); ++i) {
    if (i % 65536 == 0) progress_.check();
    const EmissiveTriangle& e = placed_.emitters[i];
    const Corners corners = corners_of(e);
    if (is_black(e.mean_radiance) || !(unit_normal(corners).length2() > 0)) continue;
    const Instance& instance = placed_.instances[e.instance];
    const Mesh& mesh = placed_.meshes[instance.mesh];
    if (moves(mesh, instance)) continue;
    const float error = plane_error(mesh, instance, e.primitive);
    const std::array<Vec3d, 4> all = test_points(corners);
    for (size_t k = 0; k < points_per_emitter; ++k) points.push_back({all[k], error, i});
  }
  return EmitterPoints(std::move(points));
}

std::vector<FlushSearch::TriangleRange> FlushSearch::ranges_near_emitters() const {
  std::vector<Imath::Box3f> bounds(placed_.meshes.size());
  parallel_each(placed_.meshes.size(), [&](size_t i) {
    progress_.check();
    bounds[i] = bounds_of(placed_.meshes[i].positions);
  });
  std::vector<TriangleRange> ranges;
  uint64_t triangles = 0;
  for (uint32_t i = 0; i < placed_.instances.size(); ++i) {
    if (i % 1024 == 0) progress_.check();
    const Instance& instance = placed_.instances[i];
    const size_t count = placed_.meshes[instance.mesh].triangles.size();
    if (count == 0 || moves(placed_.meshes[instance.mesh], instance)) continue;
    const Imath::Box3f& mesh_bounds = bounds[instance.mesh];
    const Imath::Box3f box =
        instance.transformed ? transformed(mesh_bounds, instance.to_internal) : mesh_bounds;
    const float error = plane_error(largest_coordinate(mesh_bounds), instance);
    const auto stop_at_first = [](const EmitterPoint&) { return false; };
    if (points_.visit({box.min, box.max, Vec3d(0.0), Vec3d(0.0), 2.0f * error}, stop_at_first)) {
      continue;
    }
    triangles += count;
    if (triangles > kMaxTriangles) {
      log_warning(
          "too many triangles are near emitters; emitters that lie in another surface may be "
          "missed");
      break;
    }
    for (size_t begin = 0; begin < count; begin += kRangeSize) {
      ranges.push_back({i, uint32_t(begin), uint32_t(std::min(count, begin + kRangeSize))});
    }
  }
  return ranges;
}

template <typename Visit>
void FlushSearch::visit_points(const TriangleRange& range, const Visit& visit) const {
  const Instance& instance = placed_.instances[range.instance];
  const Mesh& mesh = placed_.meshes[instance.mesh];
  for (uint32_t t = range.begin; t < range.end; ++t) {
    const Corners corners = placed_corners(mesh, instance, t);
    const Surface surface(corners);
    if (!(surface.plane().normal.length2() > 0)) continue;
    const float error = plane_error(mesh, instance, t);
    Imath::Box3f box;
    for (const Vec3d& p : corners) box.extendBy(to_float(p));
    const bool all = points_.visit(
        {box.min, box.max, surface.plane().point, surface.plane().normal, 2.0f * error},
        [&](const EmitterPoint& point) { return visit(t, surface, error, point); });
    if (!all) return;
  }
}

// Returns the number of visits allowed per range, such that the total stays within the limit. The
// limit is per range so that the result does not depend on the threads.
uint64_t FlushSearch::max_visits_per_range(const std::vector<TriangleRange>& ranges) const {
  std::vector<uint64_t> counts(ranges.size(), 0);
  parallel_each(ranges.size(), [&](size_t i) {
    progress_.check();
    visit_points(ranges[i], [&](uint32_t, const Surface&, float, const EmitterPoint&) {
      return ++counts[i] < kMaxVisitsPerRange;
    });
  });
  std::ranges::sort(counts);
  uint64_t remaining = kMaxVisits + kVisitsPerTriangle * kRangeSize * ranges.size();
  for (size_t i = 0; i < counts.size(); ++i) {
    const uint64_t visits_per_range = remaining / (counts.size() - i);
    if (counts[i] > visits_per_range) return visits_per_range;
    remaining -= counts[i];
  }
  return kMaxVisitsPerRange;
}

void FlushSearch::search_range(const TriangleRange& range, uint64_t visits_left) {
  std::map<uint32_t, float> surfaces;
  visit_points(
      range, [&](uint32_t t, const Surface& surface, float error, const EmitterPoint& point) {
        const EmissiveTriangle& e = placed_.emitters[point.emitter];
        const bool is_same_triangle = e.instance == range.instance && e.primitive == t;
        if (!is_same_triangle && surface.contains(e, point.position, double(error + point.error))) {
          // The planes may be error + point.error apart, and Embree's rounding may add the same
          // distance again.
          const float reach = 2.0f * (error + point.error);
          float& max_reach = surfaces[t];
          max_reach = std::max(max_reach, reach);
          const std::atomic_ref<float> atomic_reach(found_.reach[point.emitter]);
          float before = atomic_reach.load(std::memory_order_relaxed);
          while (before < reach && !atomic_reach.compare_exchange_weak(before, reach)) {
          }
        }
        return --visits_left > 0;
      });
  const std::lock_guard lock(mutex_);
  for (const auto& [t, reach] : surfaces) record_offset(surface_key(range.instance, t), reach);
}

}  // namespace

FlushSurfaces find_flush_surfaces(const PlacedEmitters& placed, LoadProgress& progress) {
  return FlushSearch(placed, progress).find();
}

}  // namespace emberline::scene_detail
