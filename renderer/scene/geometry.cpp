#include "renderer/scene/geometry.h"

#include <algorithm>

#ifdef EMBERLINE_THREAD_SANITIZER
#include <tbb/global_control.h>
#endif

#include "renderer/core/errors.h"
#include "renderer/core/hash.h"
#include "renderer/core/log.h"
#include "renderer/scene/embree_version.h"

namespace emberline::scene_detail {
namespace {

void on_error(void* /*user*/, RTCError /*code*/, const char* message) {
  log_verbose(std::string("Embree: ") + message);
}

// Whether back faces are culled, or there is coverage: for good, or as the mesh says at the moment.
enum class Answer { kNever, kAlways, kAsked };

Answer answer(bool now, bool may_change) {
  return may_change ? Answer::kAsked : now ? Answer::kAlways : Answer::kNever;
}

bool holds(Answer answer, bool now) {
  return answer == Answer::kAlways || (answer == Answer::kAsked && now);
}

uint32_t placed_instance(const RTCFilterFunctionNArguments* arguments, unsigned i,
                         const GeometryRecord& record) {
  const uint32_t placed = RTCHitN_instID(arguments->hit, arguments->N, i, 0);
  return placed == RTC_INVALID_GEOMETRY_ID ? record.instance : placed;
}

// Called by Embree for every candidate hit of a geometry that has back faces to hide or coverage,
// in the version that asks for no more than that. A pure function of ray, triangle and key, so that
// traversal order cannot show.
template <Answer kCulls, Answer kCovers>
void filter(const RTCFilterFunctionNArguments* arguments) {
  int* valid = arguments->valid;
  const unsigned n = arguments->N;
  const auto& record = *static_cast<const GeometryRecord*>(arguments->geometryUserPtr);
  const bool culls = holds(kCulls, record.mesh->cull_backfaces);
  const bool covers = holds(kCovers, record.mesh->has_coverage);
  for (unsigned i = 0; i < n; ++i) {
    if (valid[i] != -1) continue;
    if (culls) {
      // Both in the mesh's own space, where counter-clockwise is the front even under a mirroring
      // instance (glTF 2.0, section 3.7.4: a negative determinant flips the winding).
      const Vec3f normal(RTCHitN_Ng_x(arguments->hit, n, i), RTCHitN_Ng_y(arguments->hit, n, i),
                         RTCHitN_Ng_z(arguments->hit, n, i));
      const Vec3f direction(RTCRayN_dir_x(arguments->ray, n, i),
                            RTCRayN_dir_y(arguments->ray, n, i),
                            RTCRayN_dir_z(arguments->ray, n, i));
      if (dot(normal, direction) >= 0.0f) {
        valid[i] = 0;
        continue;
      }
    }
    if (covers) {
      const Mesh& mesh = *record.mesh;
      const auto* context = reinterpret_cast<const embree::RayContext*>(arguments->context);
      const uint32_t primitive = RTCHitN_primID(arguments->hit, n, i);
      const uint32_t instance = placed_instance(arguments, i, record);
      if (!covered(mesh, instance, primitive, RTCHitN_u(arguments->hit, n, i),
                   RTCHitN_v(arguments->hit, n, i), context->coverage_key)) {
        valid[i] = 0;
      }
    }
  }
}

// Of meshes that are not always there, before all else.
void filter_shown(const RTCFilterFunctionNArguments* arguments) {
  const unsigned n = arguments->N;
  const auto& record = *static_cast<const GeometryRecord*>(arguments->geometryUserPtr);
  for (unsigned i = 0; i < n; ++i) {
    if (arguments->valid[i] != -1) continue;
    const ShownTimes* shown = (*record.shown)[placed_instance(arguments, i, record)].get();
    if (shown && !shown->at(RTCRayN_time(arguments->ray, n, i))) arguments->valid[i] = 0;
  }
  filter<Answer::kAsked, Answer::kAsked>(arguments);
}

template <Answer kCovers>
RTCFilterFunctionN filter_for(Answer culls) {
  switch (culls) {
    case Answer::kNever:
      return filter<Answer::kNever, kCovers>;
    case Answer::kAlways:
      return filter<Answer::kAlways, kCovers>;
    case Answer::kAsked:
      return filter<Answer::kAsked, kCovers>;
  }
  return nullptr;
}

RTCFilterFunctionN choose_filter(Answer culls, Answer covers) {
  switch (covers) {
    case Answer::kNever:
      return filter_for<Answer::kNever>(culls);
    case Answer::kAlways:
      return filter_for<Answer::kAlways>(culls);
    case Answer::kAsked:
      return filter_for<Answer::kAsked>(culls);
  }
  return nullptr;
}

// What Embree is given to call while it builds.
struct WatchedBuild {
  LoadProgress& progress;
  uint64_t items;

  static bool go_on(void* user, double share) {
    const auto& self = *static_cast<const WatchedBuild*>(user);
    self.progress.partly(self.items, share);
    return !self.progress.ends();
  }
};

}  // namespace

// ThreadSanitizer sees what Embree's threads allocate and free, but not how Embree orders them:
// under it the calling thread builds alone. Tracing is not touched.
void build_bvh(RTCScene scene, LoadProgress& progress, uint64_t items) {
#ifdef EMBERLINE_THREAD_SANITIZER
  const tbb::global_control alone(tbb::global_control::max_allowed_parallelism, 1);
#endif
  WatchedBuild watched{progress, items};
  if (progress.watched()) rtcSetSceneProgressMonitorFunction(scene, WatchedBuild::go_on, &watched);
  rtcCommitScene(scene);
  if (progress.watched()) rtcSetSceneProgressMonitorFunction(scene, nullptr, nullptr);
  progress.check();  // a build that was called off is no step forward
  progress.advance(items);
}

bool covered(const Mesh& mesh, uint32_t instance, uint32_t primitive, float u, float v,
             uint32_t coverage_key) {
  const SurfaceAttributes attributes = interpolate_attributes(mesh, primitive, u, v);
  const uint32_t h = hash_combine(hash_combine(coverage_key, instance), primitive);
  const float coverage = mesh.material->coverage(attributes, to_unit_float(h));
  return to_unit_float(hash32(h ^ 0x6a09e667u)) < coverage;
}

SurfaceAttributes interpolate_attributes(const Mesh& mesh, uint32_t primitive, float u, float v) {
  const std::array<uint32_t, 3>& index = mesh.triangles[primitive];
  SurfaceAttributes attributes;
  const size_t sets = std::min(mesh.uv_sets.size(), size_t(kMaxUvSets));
  for (size_t s = 0; s < sets; ++s) {
    const std::vector<Vec2f>& uv = mesh.uv_sets[s];
    if (!uv.empty()) attributes.uv[s] = interpolate_vertices(uv, index, u, v);
  }
  if (!mesh.colors.empty()) {
    attributes.has_color = true;
    attributes.color = interpolate_vertices(mesh.colors, index, u, v);
  }
  return attributes;
}

// Embree ends the build with RTC_ERROR_OUT_OF_MEMORY where this says no.
bool Geometry::count_memory(void* user, ssize_t bytes, bool /*post*/) {
  auto& self = *static_cast<Geometry*>(user);
  if (bytes > 0 && !self.budget_->try_reserve(MemoryPart::kBvh, uint64_t(bytes))) {
    self.refused_bytes_ = uint64_t(bytes);
    return false;
  }
  if (bytes < 0) self.budget_->give_back(MemoryPart::kBvh, uint64_t(-bytes));
  self.monitored_bytes_.fetch_add(bytes, std::memory_order_relaxed);
  return true;
}

// Null where there can be none. After one that failed (no memory) Embree 3.13 makes devices whose
// release never returns.
static RTCDevice new_device() {
  static std::atomic<bool> failed{false};
  RTCDevice device = failed ? nullptr : rtcNewDevice(nullptr);
  if (!device) failed = true;
  return device;
}

void Geometry::add_object_bytes(uint64_t bytes) {
  budget_->reserve(MemoryPart::kBvh, bytes, place_);
  object_bytes_ += bytes;
}

Geometry::Geometry(std::shared_ptr<MemoryBudget> budget, std::string place,
                   const ShownInstances& shown)
    : budget_(std::move(budget)), place_(std::move(place)), shown_(shown) {
  add_object_bytes(embree::kSceneObjectBytes);
  device = new_device();
  if (!device) throw RenderError("Embree could not be started on this machine");
  rtcSetDeviceErrorFunction(device, on_error, nullptr);
  rtcSetDeviceMemoryMonitorFunction(device, count_memory, this);
  top = rtcNewScene(device);
  rtcSetSceneFlags(top, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(top, RTC_BUILD_QUALITY_HIGH);
}

Geometry::~Geometry() {
  if (top) rtcReleaseScene(top);
  for (const RTCScene scene : mesh_scenes) rtcReleaseScene(scene);
  if (device) rtcReleaseDevice(device);
  budget_->give_back(MemoryPart::kBvh, object_bytes_);
}

RTCGeometry Geometry::make_triangles(const Mesh& mesh, uint32_t instance) {
  add_object_bytes(embree::kTriangleObjectBytes);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  // The last entry of positions is padding for Embree's 16-byte reads, not a vertex.
  const auto set_vertices = [&](size_t step, const std::vector<Vec3f>& positions) {
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, unsigned(step), RTC_FORMAT_FLOAT3,
                               positions.data(), 0, sizeof(Vec3f), positions.size() - 1);
  };
  if (!mesh.motion.empty()) {
    rtcSetGeometryTimeStepCount(geometry, unsigned(mesh.motion.size()) + 1);
  }
  set_vertices(0, mesh.positions);
  for (size_t step = 1; step <= mesh.motion.size(); ++step) {
    set_vertices(step, mesh.motion[step - 1].positions);
  }
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                             mesh.triangles.data(), 0, sizeof(mesh.triangles[0]),
                             mesh.triangles.size());
  const Answer culls = answer(mesh.cull_backfaces, mesh.culling_may_change);
  const Answer covers = answer(mesh.has_coverage, mesh.coverage_may_change);
  if (culls != Answer::kNever || covers != Answer::kNever || mesh.appears) {
    records.push_back(std::make_unique<GeometryRecord>(
        GeometryRecord{&mesh, instance, mesh.appears ? &shown_ : nullptr}));
    rtcSetGeometryUserData(geometry, records.back().get());
    const RTCFilterFunctionN chosen = mesh.appears ? filter_shown : choose_filter(culls, covers);
    rtcSetGeometryIntersectFilterFunction(geometry, chosen);
    rtcSetGeometryOccludedFilterFunction(geometry, chosen);
  }
  rtcCommitGeometry(geometry);
  return geometry;
}

RTCScene Geometry::add_mesh_scene(const Mesh& mesh, LoadProgress& progress) {
  add_object_bytes(embree::kSceneObjectBytes);
  RTCScene scene = rtcNewScene(device);
  mesh_scenes.push_back(scene);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
  RTCGeometry geometry = make_triangles(mesh, 0);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  build_bvh(scene, progress, mesh.triangles.size());
  ++bvh_builds;
  check();
  return scene;
}

void Geometry::add_mesh(const Mesh& mesh, uint32_t instance) {
  RTCGeometry geometry = make_triangles(mesh, instance);
  rtcAttachGeometryByID(top, geometry, instance);
  rtcReleaseGeometry(geometry);
  top_items_ += 1 + mesh.triangles.size();
}

void Geometry::add_instance(RTCScene mesh_scene, const Affine& transform, uint32_t instance) {
  add_object_bytes(embree::kInstanceObjectBytes);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(geometry, mesh_scene);
  const float columns[12] = {
      transform.x.x, transform.x.y,           transform.x.z,           transform.y.x,
      transform.y.y, transform.y.z,           transform.z.x,           transform.z.y,
      transform.z.z, transform.translation.x, transform.translation.y, transform.translation.z};
  rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns);
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(top, geometry, instance);
  rtcReleaseGeometry(geometry);
  ++top_items_;
}

uint32_t Geometry::add_moving_instance(RTCScene mesh_scene, std::span<const Mat44d> steps,
                                       uint32_t instance) {
  add_object_bytes(embree::kInstanceObjectBytes);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(geometry, mesh_scene);
  rtcSetGeometryTimeStepCount(geometry, unsigned(steps.size()));
  const std::vector<RTCQuaternionDecomposition> parts = decompose(steps);
  for (unsigned step = 0; step < parts.size(); ++step) {
    rtcSetGeometryTransformQuaternion(geometry, step, &parts[step]);
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(top, geometry, instance);
  rtcReleaseGeometry(geometry);
  ++top_items_;
  moving_instances.push_back({geometry, steps.size()});
  return uint32_t(moving_instances.size()) - 1;
}

Affine Geometry::transform_at(uint32_t moving, float time) const {
  float m[12];
  rtcGetGeometryTransform(moving_instances[moving].geometry, time, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR,
                          m);
  return {{m[0], m[1], m[2]}, {m[3], m[4], m[5]}, {m[6], m[7], m[8]}, {m[9], m[10], m[11]}};
}

void Geometry::commit(LoadProgress& progress) {
  build_bvh(top, progress, top_items_);
  ++bvh_builds;
  check();
}

uint64_t Geometry::embree_bytes() const {
  return uint64_t(std::max<int64_t>(0, monitored_bytes_.load())) + object_bytes_;
}

uint64_t Geometry::record_bytes() const {
  return records.capacity() * sizeof(records[0]) + records.size() * sizeof(GeometryRecord);
}

void Geometry::check() {
  const RTCError error = rtcGetDeviceError(device);
  if (error == RTC_ERROR_NONE) return;
  if (const uint64_t bytes = refused_bytes_.exchange(0)) {
    throw InputError(place_, budget_->refusal(MemoryPart::kBvh, bytes));
  }
  if (error == RTC_ERROR_OUT_OF_MEMORY) throw RenderError("out of memory while building the BVH");
  throw RenderError("Embree error " + std::to_string(int(error)) + " while building the BVH");
}

}  // namespace emberline::scene_detail

namespace emberline {

namespace {

// What a device says of itself, if there can be one.
template <class Describe>
std::string ask_embree(const Describe& describe) {
  RTCDevice device = scene_detail::new_device();
  if (!device) return "unknown";
  const std::string answer = describe(
      [device](RTCDeviceProperty property) { return rtcGetDeviceProperty(device, property); });
  rtcReleaseDevice(device);
  return answer;
}

}  // namespace

std::string embree_version() {
  return ask_embree([](const auto& property) {
    return std::to_string(property(RTC_DEVICE_PROPERTY_VERSION_MAJOR)) + "." +
           std::to_string(property(RTC_DEVICE_PROPERTY_VERSION_MINOR)) + "." +
           std::to_string(property(RTC_DEVICE_PROPERTY_VERSION_PATCH));
  });
}

std::string embree_instruction_set() {
  return ask_embree([](const auto& property) -> std::string {
    if (property(RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED)) return "AVX-512";
    if (property(RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED)) return "AVX";
#ifdef __aarch64__
    return "Neon";
#else
    return "SSE";
#endif
  });
}

}  // namespace emberline
