#include "renderer/scene/geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#ifdef EMBERLINE_THREAD_SANITIZER
#include <tbb/global_control.h>
#endif

#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/description/transform_parts.h"

namespace emberline::scene_detail {
namespace {

void on_error(void* /*user*/, RTCError /*code*/, const char* message) {
  log_verbose(std::string("Embree: ") + message);
}

// Says whether a filter culls (or tests coverage): never, always, or as the mesh's flag says at the
// time of each hit.
enum class FilterRule { kNever, kAlways, kPerHit };

FilterRule filter_rule(bool now, bool may_change) {
  return may_change ? FilterRule::kPerHit : now ? FilterRule::kAlways : FilterRule::kNever;
}

bool applies(FilterRule filter_rule, bool now) {
  return filter_rule == FilterRule::kAlways || (filter_rule == FilterRule::kPerHit && now);
}

float coverage_at(const Mesh& mesh, uint32_t primitive, float u, float v,
                  const CoverageNumbers& numbers) {
  return mesh.material->coverage(interpolate_attributes(mesh, primitive, u, v), numbers.texel());
}

bool passes_coverage(float coverage, const CoverageNumbers& numbers) {
  if (coverage <= 0.0f || coverage >= 1.0f) return coverage > 0.0f;
  return numbers.decision() < coverage;
}

uint32_t placed_instance(const RTCFilterFunctionNArguments* arguments, unsigned i,
                         const GeometryRecord& record) {
  return record.instance == GeometryRecord::kRayInstance
             ? RTCHitN_instID(arguments->hit, arguments->N, i, 0)
             : record.instance;
}

// The filter that Embree calls for every candidate hit of geometry with culling or coverage; each
// specialisation does only the tests that it needs. The filter is a pure function of ray, triangle
// and key, so the result does not depend on the traversal order.
template <FilterRule kCulls, FilterRule kCovers>
void filter(const RTCFilterFunctionNArguments* arguments) {
  int* valid = arguments->valid;
  const unsigned n = arguments->N;
  const auto& record = *static_cast<const GeometryRecord*>(arguments->geometryUserPtr);
  const bool culls = applies(kCulls, record.mesh->cull_backfaces);
  const bool covers = applies(kCovers, record.mesh->has_coverage);
  for (unsigned i = 0; i < n; ++i) {
    if (valid[i] != -1) continue;
    if (culls) {
      // Normal and direction are in object space, where the counter-clockwise side is the front
      // even in a mirroring instance (glTF 2.0, section 3.7.4: a negative determinant flips the
      // winding).
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
      const CoverageNumbers numbers(context->coverage_key, placed_instance(arguments, i, record),
                                    primitive);
      const float coverage = coverage_at(mesh, primitive, RTCHitN_u(arguments->hit, n, i),
                                         RTCHitN_v(arguments->hit, n, i), numbers);
      const bool blocks = context->thickness ? !context->thickness->add(coverage)
                                             : passes_coverage(coverage, numbers);
      if (!blocks) valid[i] = 0;
    }
  }
}

// The filter for meshes that are not always visible; it tests the time first.
void filter_visibility(const RTCFilterFunctionNArguments* arguments) {
  const unsigned n = arguments->N;
  const auto& record = *static_cast<const GeometryRecord*>(arguments->geometryUserPtr);
  for (unsigned i = 0; i < n; ++i) {
    if (arguments->valid[i] != -1) continue;
    const VisibilityTimes* visibility =
        (*record.mesh->visibility)[placed_instance(arguments, i, record)].get();
    if (visibility && !visibility->at(RTCRayN_time(arguments->ray, n, i))) arguments->valid[i] = 0;
  }
  filter<FilterRule::kPerHit, FilterRule::kPerHit>(arguments);
}

RTCFilterFunctionN choose_filter(FilterRule culls, FilterRule covers) {
  using enum FilterRule;
  constexpr RTCFilterFunctionN kFilters[3][3] = {
      // indexed by culls, then by covers
      {filter<kNever, kNever>, filter<kNever, kAlways>, filter<kNever, kPerHit>},
      {filter<kAlways, kNever>, filter<kAlways, kAlways>, filter<kAlways, kPerHit>},
      {filter<kPerHit, kNever>, filter<kPerHit, kAlways>, filter<kPerHit, kPerHit>}};
  return kFilters[size_t(culls)][size_t(covers)];
}

// Splits each transform into a triangular matrix (scale and skew), a rotation and a translation, so
// that Embree interpolates rotations spherically. The quaternions q and -q are the same rotation;
// the one nearer to the previous step is used, so that the interpolation takes the shorter way.
std::vector<RTCQuaternionDecomposition> decompose(std::span<const Mat44d> steps) {
  std::vector<RTCQuaternionDecomposition> result;
  Imath::Quatd before;
  for (const Mat44d& step : steps) {
    const TransformParts p(step);
    const Imath::Quatd q = (p.rotation ^ before) < 0 ? -p.rotation : p.rotation;
    before = q;
    RTCQuaternionDecomposition d;
    rtcInitQuaternionDecomposition(&d);
    rtcQuaternionDecompositionSetScale(&d, float(p.size.x), float(p.size.y), float(p.size.z));
    rtcQuaternionDecompositionSetSkew(&d, float(p.skew_xy), float(p.skew_xz), float(p.skew_yz));
    rtcQuaternionDecompositionSetQuaternion(&d, float(q.r), float(q.v.x), float(q.v.y),
                                            float(q.v.z));
    rtcQuaternionDecompositionSetTranslation(&d, float(p.translation.x), float(p.translation.y),
                                             float(p.translation.z));
    result.push_back(d);
  }
  return result;
}

// User data of Embree's progress callback.
struct BuildMonitor {
  LoadProgress& progress;
  uint64_t items;

  static bool on_progress(void* user, double fraction) {
    const auto& self = *static_cast<const BuildMonitor*>(user);
    self.progress.report_partial(self.items, fraction);
    return !self.progress.should_stop();
  }
};

}  // namespace

// In ThreadSanitizer builds, the calling thread builds alone, because ThreadSanitizer sees the
// memory accesses of Embree's threads but not their synchronisation. Tracing is not affected.
void build_bvh(RTCScene scene, LoadProgress& progress, uint64_t items) {
#ifdef EMBERLINE_THREAD_SANITIZER
  const tbb::global_control alone(tbb::global_control::max_allowed_parallelism, 1);
#endif
  BuildMonitor watched{progress, items};
  if (progress.watched())
    rtcSetSceneProgressMonitorFunction(scene, BuildMonitor::on_progress, &watched);
  rtcCommitScene(scene);
  if (progress.watched()) rtcSetSceneProgressMonitorFunction(scene, nullptr, nullptr);
  progress.check();  // throws if cancelled, before progress is reported
  progress.advance(items);
}

bool is_covered(const Mesh& mesh, uint32_t instance, uint32_t primitive, float u, float v,
                CoverageKey coverage_key) {
  const CoverageNumbers numbers(coverage_key, instance, primitive);
  return passes_coverage(coverage_at(mesh, primitive, u, v, numbers), numbers);
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

Imath::Box3f transformed(const Imath::Box3f& box, const Affine& m) {
  Imath::Box3f out;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d p((corner & 1 ? box.max : box.min).x, (corner & 2 ? box.max : box.min).y,
                  (corner & 4 ? box.max : box.min).z);
    out.extendBy(to_float(transform_point(m, p)));
  }
  return out;
}

Imath::Box3f bounds_of(const std::vector<Vec3f>& positions) {
  Imath::Box3f box;
  // The last entry is padding.
  for (size_t v = 0; v + 1 < positions.size(); ++v) box.extendBy(positions[v]);
  return box;
}

RTCDevice new_device(EmbreeIsa isa) {
  static std::atomic<bool> failed{false};
  const std::string config = fmt::format("isa={}", name_of(embree_isa_table(), isa));
  RTCDevice device = failed ? nullptr : rtcNewDevice(config.c_str());
  if (!device) failed = true;
  return device;
}

EmbreeDevice::EmbreeDevice(EmbreeIsa isa, std::shared_ptr<MemoryBudget> budget, std::string place)
    : budget_(std::move(budget)), place_(std::move(place)) {
  if (isa > widest_isa()) {
    throw UsageError("`isa` {}: this processor or this build of Embree supports at most {}",
                     name_of(embree_isa_table(), isa), name_of(embree_isa_table(), widest_isa()));
  }
  device_ = new_device(isa);
  if (!device_)
    throw RenderError(
        "not enough memory to start Embree, which takes 500 MB of address space; free memory or "
        "raise the limit (ulimit -v)");
  rtcSetDeviceErrorFunction(device_, on_error, nullptr);
  rtcSetDeviceMemoryMonitorFunction(device_, count_memory, this);
}

EmbreeDevice::~EmbreeDevice() { rtcReleaseDevice(device_); }

// If this returns false, Embree ends the build with RTC_ERROR_OUT_OF_MEMORY.
bool EmbreeDevice::count_memory(void* user, ssize_t bytes, bool /*post*/) {
  auto& self = *static_cast<EmbreeDevice*>(user);
  uint64_t left = 0;
  if (bytes > 0 && !self.budget_->try_reserve(MemoryPart::kBvh, uint64_t(bytes), &left)) {
    const std::lock_guard lock(self.rejection_mutex_);
    if (self.rejection_.bytes == 0) self.rejection_ = {uint64_t(bytes), left};
    return false;
  }
  if (bytes < 0) self.budget_->release(MemoryPart::kBvh, uint64_t(-bytes));
  self.monitored_bytes_.fetch_add(bytes, std::memory_order_relaxed);
  return true;
}

void EmbreeDevice::add_object_bytes(uint64_t bytes) {
  budget_->reserve(MemoryPart::kBvh, bytes, place_);
  object_bytes_ += bytes;
}

void EmbreeDevice::release_object_bytes(uint64_t bytes) noexcept {
  budget_->release(MemoryPart::kBvh, bytes);
  object_bytes_ -= bytes;
}

uint64_t EmbreeDevice::bytes() const {
  return uint64_t(std::max<int64_t>(0, monitored_bytes_.load())) + object_bytes_;
}

void EmbreeDevice::check() {
  const RTCError error = rtcGetDeviceError(device_);
  if (error == RTC_ERROR_NONE) return;
  const Rejection first = [&] {
    const std::lock_guard lock(rejection_mutex_);
    return std::exchange(rejection_, {});
  }();
  if (first.bytes > 0) {
    throw InputError(place_, budget_->limit_message(MemoryPart::kBvh, first.bytes, first.left));
  }
  if (error == RTC_ERROR_OUT_OF_MEMORY) throw RenderError("out of memory while building the BVH");
  throw RenderError("Embree error " + std::to_string(int(error)) + " while building the BVH");
}

EmbreeScene::EmbreeScene(std::shared_ptr<EmbreeDevice> embree_device)
    : device(std::move(embree_device)) {
  add_object_bytes(embree::kSceneObjectBytes);
  scene = rtcNewScene(device->handle());
  // In robust mode the builder does not split triangles, so a shadow ray's filter sees each
  // triangle only once, as Thickness requires. In other modes, light may also leak between
  // triangles.
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  if (device->has_query_filters) embree::enable_query_filters(scene);
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
}

EmbreeScene::~EmbreeScene() {
  rtcReleaseScene(scene);
  device->release_object_bytes(object_bytes_);
}

void EmbreeScene::add_object_bytes(uint64_t bytes) {
  device->add_object_bytes(bytes);
  object_bytes_ += bytes;
}

void EmbreeScene::attach(RTCGeometry geometry, uint32_t id, uint64_t items) {
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, id);
  rtcReleaseGeometry(geometry);
  items_ += items;
}

void EmbreeScene::build(LoadProgress& progress) {
  build_bvh(scene, progress, items_);
  ++device->bvh_builds;
  device->check();
}

Geometry::Geometry(std::shared_ptr<EmbreeDevice> device)
    : device_(std::move(device)), top_(device_) {}

RTCGeometry Geometry::make_triangles(EmbreeScene& scene, Mesh& mesh, uint32_t instance) {
  scene.add_object_bytes(embree::kTriangleObjectBytes);
  RTCGeometry geometry = rtcNewGeometry(device_->handle(), RTC_GEOMETRY_TYPE_TRIANGLE);
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
  const FilterRule culls = filter_rule(mesh.cull_backfaces, mesh.culling_may_change);
  const FilterRule covers = filter_rule(mesh.has_coverage, mesh.coverage_may_change);
  if (culls != FilterRule::kNever || covers != FilterRule::kNever || mesh.visibility) {
    if (!mesh.record) mesh.record = std::make_shared<GeometryRecord>();
    *mesh.record = {&mesh, instance, mesh.visibility != nullptr};
    rtcSetGeometryUserData(geometry, mesh.record.get());
    const RTCFilterFunctionN chosen =
        mesh.visibility ? filter_visibility : choose_filter(culls, covers);
    rtcSetGeometryIntersectFilterFunction(geometry, chosen);
    rtcSetGeometryOccludedFilterFunction(geometry, chosen);
  }
  return geometry;
}

void Geometry::build_mesh_scene(Mesh& mesh, LoadProgress& progress) {
  const auto built = std::make_shared<EmbreeScene>(device_);
  built->attach(make_triangles(*built, mesh, GeometryRecord::kRayInstance), 0,
                mesh.triangles.size());
  built->build(progress);
  mesh.bvh = built;
}

void Geometry::add_mesh(EmbreeScene& scene, Mesh& mesh, uint32_t instance) {
  scene.attach(make_triangles(scene, mesh, instance), instance, 1 + mesh.triangles.size());
}

void Geometry::add_static_group(std::vector<StaticInstance> list, std::vector<Mesh>& meshes,
                                const Geometry* before, LoadProgress& progress) {
  static_instances_ = std::move(list);
  if (static_instances_.empty()) return;
  if (before && before->static_instances_ == static_instances_) {
    static_scene_ = before->static_scene_;
    return;
  }
  const auto built = std::make_shared<EmbreeScene>(device_);
  for (const StaticInstance& r : static_instances_) add_mesh(*built, meshes[r.mesh], r.instance);
  built->build(progress);
  static_scene_ = built;
}

void Geometry::add_instance(const EmbreeScene& mesh_scene, const Affine& transform,
                            uint32_t instance) {
  top_.add_object_bytes(embree::kInstanceObjectBytes);
  RTCGeometry geometry = rtcNewGeometry(device_->handle(), RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(geometry, mesh_scene.scene);
  const float columns[12] = {
      transform.x.x, transform.x.y,           transform.x.z,           transform.y.x,
      transform.y.y, transform.y.z,           transform.z.x,           transform.z.y,
      transform.z.z, transform.translation.x, transform.translation.y, transform.translation.z};
  rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns);
  top_.attach(geometry, instance, 1);
}

uint32_t Geometry::add_moving_instance(const EmbreeScene& mesh_scene, std::span<const Mat44d> steps,
                                       uint32_t instance) {
  top_.add_object_bytes(embree::kInstanceObjectBytes);
  RTCGeometry geometry = rtcNewGeometry(device_->handle(), RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(geometry, mesh_scene.scene);
  rtcSetGeometryTimeStepCount(geometry, unsigned(steps.size()));
  const std::vector<RTCQuaternionDecomposition> parts = decompose(steps);
  for (unsigned step = 0; step < parts.size(); ++step) {
    rtcSetGeometryTransformQuaternion(geometry, step, &parts[step]);
  }
  top_.attach(geometry, instance, 1);
  moving_instances_.push_back({geometry, steps.size()});
  return uint32_t(moving_instances_.size()) - 1;
}

Affine Geometry::transform_at(uint32_t moving_index, float time) const {
  float m[12];
  rtcGetGeometryTransform(moving_instances_[moving_index].geometry, time,
                          RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, m);
  return {{m[0], m[1], m[2]}, {m[3], m[4], m[5]}, {m[6], m[7], m[8]}, {m[9], m[10], m[11]}};
}

// The static group becomes one more instance, whose index is the number of the scene's instances
// (see Scene::intersect()).
void Geometry::commit(uint32_t instances, LoadProgress& progress) {
  constexpr Affine kIdentity = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}};
  if (static_scene_) add_instance(*static_scene_, kIdentity, instances);
  top_.build(progress);
}

}  // namespace emberline::scene_detail
