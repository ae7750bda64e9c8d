#include "renderer/scene/solids.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "renderer/core/load_progress.h"
#include "renderer/core/shortened.h"
#include "renderer/scene/geometry.h"
#include "renderer/scene/interior.h"

namespace emberline {

using scene_detail::Affine;
using scene_detail::Instance;
using scene_detail::Mesh;
using scene_detail::shape_of;
using scene_detail::SolidShape;

namespace {

double determinant(const Affine& m) {
  return dot(to_double(m.x), cross(to_double(m.y), to_double(m.z)));
}

// Enlarges a box by far more than the rounding error of a face.
Imath::Box3f expanded_box(Imath::Box3f box) {
  constexpr float kMargin = 1e-4f;
  const Vec3f margin(kMargin * std::max(max_abs_component(box.min), max_abs_component(box.max)));
  box.min -= margin;
  box.max += margin;
  return box;
}

}  // namespace

std::unique_ptr<const Solids> Solids::find(Scene& scene, const SceneDescription& description,
                                           LoadProgress& progress) {
  std::unique_ptr<Solids> solids(new Solids);
  for (uint32_t i = 0; i < scene.instances_.size(); ++i) {
    Mesh& mesh = scene.meshes_[scene.instances_[i].mesh];
    if (mesh.triangles.empty() || !mesh.material->is_solid()) continue;
    const std::string& name = description.meshes[scene.instances_[i].mesh].name;
    if (!mesh.solid) mesh.solid = shape_of(std::array<const Mesh*, 1>{&mesh}, &name, progress);
    if (solids->solids_.empty()) {
      solids->solids_.resize(scene.instances_.size());
      for (uint32_t k = 0; k < solids->solids_.size(); ++k) solids->solids_[k].body = k;
    }
    Solid& solid = solids->solids_[i];
    solids->set_shape(scene, i, *mesh.solid);
    solids->instances_.push_back(i);
    const Material& material = *mesh.material;
    solid.is_clear = material.is_clear_solid() && mesh.colors.empty();
    solid.transmits_straight =
        solid.is_clear && material.ior() == 1.0f && material.dispersion() == 0.0f;
    if (solid.transmits_straight) solids->has_straight_transmission_ = true;
  }
  if (solids->instances_.empty()) return nullptr;
  solids->join_parts(scene, description, progress);
  for (const uint32_t i : solids->instances_) {
    if (solids->solids_[i].closed) continue;
    const MeshDescription& mesh = description.meshes[scene.instances_[i].mesh];
    solids->open_names_.emplace(i, shortened(mesh.name));
  }
  solids->find_ranks();
  solids->find_near();
  solids->find_flat(scene);
  solids->find_touching(scene, description.file, progress);
  return solids;
}

void Solids::set_shape(const Scene& scene, uint32_t i, const SolidShape& shape) {
  const Instance& instance = scene.instances_[i];
  Solid& solid = solids_[i];
  solid.closed = shape.closed;
  solid.mesh_bounds = solid.bounds = shape.bounds;
  solid.volume = shape.volume;
  if (!instance.transformed) return;
  solid.bounds = scene_detail::transformed(shape.bounds, instance.to_internal);
  solid.volume *= std::abs(determinant(instance.to_internal));
}

void Solids::find_ranks() {
  std::vector<uint32_t> order = instances_;
  std::ranges::sort(order, [this](uint32_t a, uint32_t b) {
    return std::tuple(solids_[a].volume, solids_[a].body, a) <
           std::tuple(solids_[b].volume, solids_[b].body, b);
  });
  for (uint32_t rank = 0; rank < order.size(); ++rank) solids_[order[rank]].rank = rank;
}

Imath::Box3f Solids::bounds_over_shutter(const Scene& scene, uint32_t i) const {
  Imath::Box3f box = solids_[i].bounds;
  const Instance& instance = scene.instances_[i];
  if (instance.moving_index == Instance::kStatic) return box;
  constexpr int kTimes = 64;
  for (int k = 1; k <= kTimes; ++k) {
    const Affine m = scene.geometry_->transform_at(instance.moving_index, float(k) / kTimes);
    box.extendBy(scene_detail::transformed(solids_[i].mesh_bounds, m));
  }
  // The margin exceeds the distance by which a corner can leave the box between two sampled times.
  const Vec3f margin(0.05f * box.size().length());
  box.min -= margin;
  box.max += margin;
  return box;
}

// Marks solids that are near another solid, by a sweep along x. A solid with too many neighbours
// along x counts as near without a test.
void Solids::find_near() {
  constexpr size_t kMaxNeighbours = 256;
  std::vector<uint32_t> order = instances_;
  const auto left = [this](uint32_t i) { return solids_[i].bounds.min.x; };
  std::ranges::sort(order, [&](uint32_t a, uint32_t b) {
    return left(a) != left(b) ? left(a) < left(b) : a < b;
  });
  for (size_t i = 0; i < order.size(); ++i) {
    const Imath::Box3f box = expanded_box(solids_[order[i]].bounds);
    for (size_t k = i + 1; k < order.size() && left(order[k]) <= box.max.x; ++k) {
      const bool is_same_body = solids_[order[i]].body == solids_[order[k]].body;
      if (k - i <= kMaxNeighbours && (is_same_body || !box.intersects(solids_[order[k]].bounds)))
        continue;
      solids_[order[i]].is_near = solids_[order[k]].is_near = true;
      if (k - i > kMaxNeighbours) break;
    }
  }
  for (const uint32_t i : instances_) {
    if (solids_[i].is_near) near_.push_back(i);
  }
}

// Faces count as coincident if their distance is at most this multiple of the sum of their error
// bounds.
static constexpr float kReach = 8.0f;

// A face at shutter open. One time is enough, because solids whose faces stay coincident move
// together.
struct Solids::Face {
  Vec3f low, high;  // bounds
  float error;      // maximum distance from its plane at which a ray may hit it
  uint32_t instance, primitive;
  bool is_solid_face;

  float reach(const Face& other) const { return kReach * (error + other.error); }
  bool is_disjoint(const Face& other) const {
    for (int c = 0; c < 3; ++c) {
      if (low[c] > other.high[c] + reach(other) || other.low[c] > high[c] + reach(other))
        return true;
    }
    return false;
  }
};

// A list of faces that reserves its memory in advance.
struct Solids::FaceList {
  FaceList(std::shared_ptr<MemoryBudget> budget, const std::string& file_name)
      : memory(std::move(budget), MemoryPart::kGeometry), file(file_name) {}
  void add(const Face& face) {
    if (faces.size() == faces.capacity()) {
      const size_t more = std::max<size_t>(1024, faces.size());
      memory.add(bytes_of(more, sizeof(Face)), file);
      faces.reserve(faces.size() + more);
    }
    faces.push_back(face);
  }
  std::vector<Face> faces;
  MemoryReservation memory;
  const std::string& file;
};

std::array<Vec3d, 3> Solids::corners_of(const Scene& scene, uint32_t instance, uint32_t primitive) {
  const Instance& placed = scene.instances_[instance];
  return scene_detail::placed_corners(scene.meshes_[placed.mesh], placed, primitive);
}

// Returns whether one face lies in the other's plane.
bool Solids::are_coplanar(const Scene& scene, const Face& a, const Face& b) {
  const auto p = corners_of(scene, a.instance, a.primitive);
  const auto q = corners_of(scene, b.instance, b.primitive);
  const auto lies_in_plane = [&](const std::array<Vec3d, 3>& plane,
                                 const std::array<Vec3d, 3>& face) {
    const Vec3d normal = (plane[1] - plane[0]).cross(plane[2] - plane[0]).normalized();
    return std::ranges::all_of(face, [&](const Vec3d& corner) {
      return std::abs(dot(corner - plane[0], normal)) <= double(a.reach(b));
    });
  };
  return lies_in_plane(p, q) || lies_in_plane(q, p);
}

Solids::Face Solids::face_of(const Scene& scene, uint32_t instance, uint32_t primitive) const {
  const Instance& placed = scene.instances_[instance];
  const Mesh& mesh = scene.meshes_[placed.mesh];
  Imath::Box3f box;
  for (const Vec3d& corner : corners_of(scene, instance, primitive)) {
    box.extendBy(to_float(corner));
  }
  return {box.min,  box.max,   scene_detail::plane_error(mesh, placed, primitive),
          instance, primitive, mesh.material->is_solid()};
}

void Solids::add_faces(const Scene& scene, uint32_t instance, FaceList* faces) const {
  const size_t count = scene.meshes_[scene.instances_[instance].mesh].triangles.size();
  for (uint32_t p = 0; p < count; ++p) faces->add(face_of(scene, instance, p));
}

void Solids::find_flat(const Scene& scene) {
  for (const uint32_t body : instances_) {
    if (!solids_[body].closed || solids_[body].body != body) continue;
    const std::vector<uint32_t> parts = parts_of(body);
    // Calls use(instance, primitive) for each face until `use` returns false.
    const auto all_faces = [&](const auto& use) {
      return std::ranges::all_of(parts, [&](uint32_t i) {
        const size_t count = scene.meshes_[scene.instances_[i].mesh].triangles.size();
        uint32_t p = 0;
        while (p < count && use(i, p)) ++p;
        return p == count;
      });
    };
    Vec3d normal(0.0), plane_point(0.0);
    double reach = 0.0;
    all_faces([&](uint32_t i, uint32_t p) {
      const std::array<Vec3d, 3> c = corners_of(scene, i, p);
      const Vec3d here = (c[1] - c[0]).cross(c[2] - c[0]);
      if (here.length2() <= normal.length2()) return true;
      normal = here;
      plane_point = c[0];
      const Instance& placed = scene.instances_[i];
      // If a solid is thicker than this, a ray hits its faces one after another, even if other
      // faces coincide with them.
      reach = 2 * SolidCrossing::kReach *
              scene_detail::plane_error(scene.meshes_[placed.mesh], placed, p);
      return true;
    });
    normal.normalize();
    const bool flat = all_faces([&](uint32_t i, uint32_t p) {
      return std::ranges::all_of(corners_of(scene, i, p), [&](const Vec3d& corner) {
        return std::abs(dot(corner - plane_point, normal)) <= reach;
      });
    });
    if (!flat) continue;
    for (const uint32_t i : parts) {
      if (opaque_parts_.contains(i)) continue;
      solids_[i].is_flat = solids_[i].transmits_straight = has_straight_transmission_ = true;
      mark_all_touching(scene, i);
    }
  }
}

// For surfaces without an interior, adds the faces that are near solids, and the faces of these
// solids unless they are listed already. Skips emissive surfaces, because flush_emitters.h handles
// them. Returns false if this takes too many tests.
bool Solids::add_surfaces(const Scene& scene, LoadProgress& progress, FaceList* faces) const {
  constexpr uint64_t kMaxTests = 50'000'000;  // about a second
  std::vector<Imath::Box3f> boxes;
  for (const uint32_t i : instances_) boxes.push_back(expanded_box(solids_[i].bounds));
  std::vector<Imath::Box3f> mesh_bounds(scene.meshes_.size());
  std::vector<bool> has_surfaces(instances_.size());
  uint64_t tests = 0;
  for (uint32_t i = 0; i < scene.instances_.size(); ++i) {
    if (i % 1024 == 0) progress.check();
    const Instance& placed = scene.instances_[i];
    const Mesh& mesh = scene.meshes_[placed.mesh];
    if (mesh.triangles.empty() || mesh.material->is_solid() || mesh.material->is_emissive())
      continue;
    Imath::Box3f& mesh_box = mesh_bounds[placed.mesh];
    if (mesh_box.isEmpty()) mesh_box = scene_detail::bounds_of(mesh.positions);
    const Imath::Box3f box =
        placed.transformed ? scene_detail::transformed(mesh_box, placed.to_internal) : mesh_box;
    std::vector<size_t> near;
    for (size_t k = 0; k < boxes.size(); ++k) {
      if (boxes[k].intersects(box)) near.push_back(k);
    }
    tests += boxes.size() + near.size() * mesh.triangles.size();
    if (tests > kMaxTests) return false;
    for (uint32_t p = 0; p < mesh.triangles.size() && !near.empty(); ++p) {
      const Face face = face_of(scene, i, p);
      bool is_near_solid = false;
      for (const size_t k : near) {
        if (!boxes[k].intersects({face.low, face.high})) continue;
        is_near_solid = has_surfaces[k] = true;
      }
      if (is_near_solid) faces->add(face);
    }
  }
  for (size_t k = 0; k < instances_.size(); ++k) {
    if (has_surfaces[k] && !solids_[instances_[k]].is_near) add_faces(scene, instances_[k], faces);
  }
  return true;
}

void Solids::mark_all_touching(const Scene& scene, uint32_t instance) {
  const size_t count = scene.meshes_[scene.instances_[instance].mesh].triangles.size();
  std::vector<bool>& touching = solids_[instance].touching;
  touching_faces_ += count - uint64_t(std::count(touching.begin(), touching.end(), true));
  touching.assign(count, true);
}

void Solids::mark_touching(const Scene& scene, const Face& face) {
  std::vector<bool>& touching = solids_[face.instance].touching;
  if (touching.empty()) {
    touching.resize(scene.meshes_[scene.instances_[face.instance].mesh].triangles.size());
  }
  touching_faces_ += !touching[face.primitive];
  touching[face.primitive] = true;
}

// Pairs a face with one of the strips that it overlaps. The strips divide the y axis. Two faces
// that may touch share a strip, so faces are compared only within strips, along x.
struct Solids::StripFace {
  uint32_t strip, face;
};

std::vector<Solids::StripFace> Solids::sort_into_strips(const std::vector<Face>& faces,
                                                        const std::string& file,
                                                        MemoryReservation* memory) {
  constexpr double kStrips = 64;  // chosen by us
  double low = INFINITY, high = -INFINITY, reach = 0.0;
  for (const Face& face : faces) {
    low = std::min(low, double(face.low.y));
    high = std::max(high, double(face.high.y));
    reach = std::max(reach, double(face.reach(face)));
  }
  const double per_strip = kStrips / std::max(high - low, 1e-300);
  const auto strip = [&](double y) {
    return uint32_t(std::clamp((y - low) * per_strip, 0.0, kStrips - 1));
  };
  const auto first = [&](const Face& face) { return strip(face.low.y - reach / 2); };
  const auto last = [&](const Face& face) { return strip(face.high.y + reach / 2); };
  uint64_t count = 0;
  for (const Face& face : faces) count += last(face) - first(face) + 1;
  memory->add(bytes_of(count, sizeof(StripFace)), file);
  std::vector<StripFace> order;
  order.reserve(count);
  for (uint32_t i = 0; i < faces.size(); ++i) {
    for (uint32_t k = first(faces[i]); k <= last(faces[i]); ++k) order.push_back({k, i});
  }
  std::ranges::sort(order, [&](const StripFace& a, const StripFace& b) {
    const Face &p = faces[a.face], &q = faces[b.face];
    return std::tuple(a.strip, p.low.x, p.instance, p.primitive) <
           std::tuple(b.strip, q.low.x, q.instance, q.primitive);
  });
  return order;
}

// Marks the faces that coincide with a face of another body, by a sweep along x in each strip. If
// the work reaches a limit, all remaining faces count as touching.
void Solids::find_touching(const Scene& scene, const std::string& file, LoadProgress& progress) {
  constexpr uint64_t kMaxPairs = 100'000'000;  // less than a second
  FaceList list(progress.budget(), file);
  for (const uint32_t i : near_) add_faces(scene, i, &list);
  if (!add_surfaces(scene, progress, &list)) {
    for (const uint32_t i : instances_) mark_all_touching(scene, i);
    return;
  }
  const std::vector<Face>& faces = list.faces;
  MemoryReservation memory(progress.budget(), MemoryPart::kGeometry);
  const std::vector<StripFace> order = sort_into_strips(faces, file, &memory);
  uint64_t pairs = 0;
  for (size_t i = 0; i < order.size(); ++i) {
    if (i % 1024 == 0) progress.check();
    const Face& a = faces[order[i].face];
    for (size_t k = i + 1; k < order.size() && pairs < kMaxPairs; ++k, ++pairs) {
      const Face& b = faces[order[k].face];
      if (order[k].strip != order[i].strip || b.low.x > a.high.x + a.reach(b)) break;
      if (!a.is_solid_face && !b.is_solid_face) continue;
      const bool is_same_body =
          a.is_solid_face && b.is_solid_face && body(a.instance) == body(b.instance);
      if (is_same_body || a.instance == b.instance || a.is_disjoint(b) ||
          !are_coplanar(scene, a, b)) {
        continue;
      }
      mark_touching(scene, a);
      mark_touching(scene, b);
    }
    if (pairs >= kMaxPairs) mark_touching(scene, a);
  }
}

}  // namespace emberline
