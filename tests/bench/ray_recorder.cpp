#include "bench/ray_recorder.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <latch>
#include <mutex>
#include <thread>
#include <vector>

#if defined(__x86_64__) || defined(_M_X64)
#include <immintrin.h>
#endif

#include "bench/clocks.h"
#include "renderer/scene/embree_api.h"

// The linker defines these names. Calls to rtcIntersect1 arrive at __wrap_rtcIntersect1, and
// __real_rtcIntersect1 is Embree's function.
extern "C" {
#if EMBERLINE_EMBREE_MAJOR >= 4
void __real_rtcIntersect1(RTCScene, RTCRayHit*, RTCIntersectArguments*);
void __real_rtcOccluded1(RTCScene, RTCRay*, RTCOccludedArguments*);
#else
void __real_rtcIntersect1(RTCScene, RTCIntersectContext*, RTCRayHit*);
void __real_rtcOccluded1(RTCScene, RTCIntersectContext*, RTCRay*);
#endif
}

namespace emberline::bench {
namespace {

constexpr uint32_t kOcclusion = 0xfffffffeu;  // marks an occlusion ray, in place of a primitive

// A ray and its result. Time, mask and flags are the same for all rays.
struct Record {
  float origin[3], t_near;
  float direction[3], t_far;
  CoverageKey coverage_key;
  uint32_t kind_or_primitive;  // kOcclusion, or the triangle that was hit
  uint32_t geometry, instance;
  float found;  // distance of the hit; for an occlusion ray, 1 if it is blocked
};
// Records are kept in blocks, so that recording never copies them.
constexpr size_t kBlock = 1 << 16;
using List = std::vector<std::unique_ptr<std::vector<Record>>>;

}  // namespace

struct RayRecorder::Lists {
  std::mutex mutex;
  std::vector<std::unique_ptr<List>> lists;
  std::atomic<RTCScene> scene{nullptr};
  std::atomic<bool> odd{false};  // true after a ray that this recorder cannot replay
  uint64_t serial = 0;           // identifies this recorder, since threads outlive it
};

namespace {

std::atomic<RayRecorder::Lists*> recording{nullptr};
thread_local List* thread_list = nullptr;
thread_local uint64_t thread_list_serial = 0;

Record& next_record(RayRecorder::Lists& lists) {
  if (thread_list_serial != lists.serial) {
    const std::lock_guard lock(lists.mutex);
    lists.lists.push_back(std::make_unique<List>());
    thread_list = lists.lists.back().get();
    thread_list_serial = lists.serial;
  }
  if (thread_list->empty() || thread_list->back()->size() == kBlock) {
    thread_list->push_back(std::make_unique<std::vector<Record>>());
    thread_list->back()->reserve(kBlock);
  }
  return thread_list->back()->emplace_back();
}

void record_query(RayRecorder::Lists& lists, Record& record, RTCScene scene, const RTCRay& ray,
                  const embree::RayContext& context) {
  record.origin[0] = ray.org_x;
  record.origin[1] = ray.org_y;
  record.origin[2] = ray.org_z;
  record.t_near = ray.tnear;
  record.direction[0] = ray.dir_x;
  record.direction[1] = ray.dir_y;
  record.direction[2] = ray.dir_z;
  record.t_far = ray.tfar;
  record.coverage_key = context.coverage_key;
  if (ray.time != 0.0f || ray.mask != 0xffffffffu) lists.odd = true;
  const RTCScene before = lists.scene.exchange(scene);
  if (before && before != scene) lists.odd = true;
}

RTCRay ray_of(const Record& r) {
  RTCRay ray;
  ray.org_x = r.origin[0];
  ray.org_y = r.origin[1];
  ray.org_z = r.origin[2];
  ray.tnear = r.t_near;
  ray.dir_x = r.direction[0];
  ray.dir_y = r.direction[1];
  ray.dir_z = r.direction[2];
  ray.time = 0.0f;
  ray.tfar = r.t_far;
  ray.mask = 0xffffffffu;
  ray.id = 0;
  ray.flags = 0;
  return ray;
}

void record_result(Record& record, const RTCRayHit& hit) {
  const bool missed = hit.hit.geomID == RTC_INVALID_GEOMETRY_ID;  // primID is then undefined
  record.kind_or_primitive = missed ? 0 : hit.hit.primID;
  record.geometry = hit.hit.geomID;
  record.instance = hit.hit.instID[0];
  record.found = hit.ray.tfar;
}

bool has_same_result(const Record& a, const RTCRayHit& hit) {
  if (a.geometry == RTC_INVALID_GEOMETRY_ID) return hit.hit.geomID == RTC_INVALID_GEOMETRY_ID;
  return a.geometry == hit.hit.geomID && a.instance == hit.hit.instID[0] &&
         a.kind_or_primitive == hit.hit.primID &&
         std::bit_cast<uint32_t>(a.found) == std::bit_cast<uint32_t>(hit.ray.tfar);
}

enum class Mode { kTrace, kSetUpOnly, kCompare };

// Keeps the compiler from removing unused results.
template <typename T>
void use(T& value) {
  asm volatile("" : : "r"(&value) : "memory");
}

// Traces like embree::intersect and embree::occluded, but bypasses the recorder.
void trace(RTCScene scene, embree::RayContext& context, RTCRayHit& hit) {
#if EMBERLINE_EMBREE_MAJOR >= 4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = &context.base;
  __real_rtcIntersect1(scene, &hit, &arguments);
#else
  __real_rtcIntersect1(scene, &context.base, &hit);
#endif
}

void trace(RTCScene scene, embree::RayContext& context, RTCRay& ray) {
#if EMBERLINE_EMBREE_MAJOR >= 4
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.context = &context.base;
  __real_rtcOccluded1(scene, &ray, &arguments);
#else
  __real_rtcOccluded1(scene, &context.base, &ray);
#endif
}

template <Mode kMode>
uint64_t play(RTCScene scene, const List& list) {
  uint64_t differences = 0;
  for (const auto& block : list) {
    for (const Record& record : *block) {
      embree::RayContext context;
      embree::init_context(context, record.coverage_key);
      if (record.kind_or_primitive == kOcclusion) {
        RTCRay ray = ray_of(record);
        if constexpr (kMode != Mode::kSetUpOnly) trace(scene, context, ray);
        use(context);
        use(ray);
        if constexpr (kMode == Mode::kCompare) {
          differences += (ray.tfar < 0.0f) != (record.found == 1.0f);
        }
      } else {
        RTCRayHit hit;
        hit.ray = ray_of(record);
        hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        if constexpr (kMode != Mode::kSetUpOnly) trace(scene, context, hit);
        use(context);
        use(hit);
        if constexpr (kMode == Mode::kCompare) differences += !has_same_result(record, hit);
      }
    }
  }
  return differences;
}

template <Mode kMode>
ReplayRun play_all(const RayRecorder::Lists& lists, uint64_t* differences) {
  const size_t n = lists.lists.size();
  std::vector<double> cpu(n), end(n);
  std::vector<uint64_t> different(n);
  std::latch ready{ptrdiff_t(n) + 1};
  std::vector<std::jthread> threads;
  for (size_t i = 0; i < n; ++i) {
    threads.emplace_back([&, i] {
#if defined(__x86_64__) || defined(_M_X64)
      _mm_setcsr(_mm_getcsr() | 0x8040u);  // as RenderWorker sets it
#endif
      ready.arrive_and_wait();
      const double start = thread_cpu();
      different[i] = play<kMode>(lists.scene, *lists.lists[i]);
      cpu[i] = thread_cpu() - start;
      end[i] = wall_clock();
    });
  }
  ready.arrive_and_wait();
  ReplayRun run;
  const double start = wall_clock();
  threads.clear();  // joins
  for (size_t i = 0; i < n; ++i) {
    run.cpu_s += cpu[i];
    run.wall_s = std::max(run.wall_s, end[i] - start);
    if (differences) *differences += different[i];
  }
  return run;
}

}  // namespace

RayRecorder::RayRecorder() : lists_(std::make_unique<Lists>()) {
  static std::atomic<uint64_t> serials{0};
  lists_->serial = ++serials;
  recording = lists_.get();
}
RayRecorder::~RayRecorder() { stop(); }
void RayRecorder::stop() { recording = nullptr; }

uint64_t RayRecorder::rays() const {
  if (lists_->odd) return 0;
  uint64_t count = 0;
  for (const auto& list : lists_->lists) {
    for (const auto& block : *list) count += block->size();
  }
  return count;
}
int RayRecorder::threads() const { return int(lists_->lists.size()); }
uint64_t RayRecorder::bytes_per_ray() { return sizeof(Record); }

ReplayRun RayRecorder::replay() const { return play_all<Mode::kTrace>(*lists_, nullptr); }
ReplayRun RayRecorder::replay_without_embree() const {
  return play_all<Mode::kSetUpOnly>(*lists_, nullptr);
}
uint64_t RayRecorder::differences() const {
  uint64_t count = 0;
  play_all<Mode::kCompare>(*lists_, &count);
  return count;
}

}  // namespace emberline::bench

using emberline::bench::recording;

// The renderer's calls arrive here. Their context is a RayContext (renderer/scene/embree_api.h).
extern "C" {
#if EMBERLINE_EMBREE_MAJOR >= 4
void __wrap_rtcIntersect1(RTCScene scene, RTCRayHit* hit, RTCIntersectArguments* context) {
  const auto real = [&] { __real_rtcIntersect1(scene, hit, context); };
  const auto* ray_context =
      reinterpret_cast<const emberline::embree::RayContext*>(context->context);
#else
void __wrap_rtcIntersect1(RTCScene scene, RTCIntersectContext* context, RTCRayHit* hit) {
  const auto real = [&] { __real_rtcIntersect1(scene, context, hit); };
  const auto* ray_context = reinterpret_cast<const emberline::embree::RayContext*>(context);
#endif
  auto* const lists = recording.load(std::memory_order_relaxed);
  if (!lists) [[likely]] {
    real();
    return;
  }
  emberline::bench::Record& record = emberline::bench::next_record(*lists);
  emberline::bench::record_query(*lists, record, scene, hit->ray, *ray_context);
  real();
  emberline::bench::record_result(record, *hit);
}

#if EMBERLINE_EMBREE_MAJOR >= 4
void __wrap_rtcOccluded1(RTCScene scene, RTCRay* ray, RTCOccludedArguments* context) {
  const auto real = [&] { __real_rtcOccluded1(scene, ray, context); };
  const auto* ray_context =
      reinterpret_cast<const emberline::embree::RayContext*>(context->context);
#else
void __wrap_rtcOccluded1(RTCScene scene, RTCIntersectContext* context, RTCRay* ray) {
  const auto real = [&] { __real_rtcOccluded1(scene, context, ray); };
  const auto* ray_context = reinterpret_cast<const emberline::embree::RayContext*>(context);
#endif
  auto* const lists = recording.load(std::memory_order_relaxed);
  if (!lists) [[likely]] {
    real();
    return;
  }
  emberline::bench::Record& record = emberline::bench::next_record(*lists);
  emberline::bench::record_query(*lists, record, scene, *ray, *ray_context);
  real();
  record.kind_or_primitive = emberline::bench::kOcclusion;
  record.found = ray->tfar < 0.0f ? 1.0f : 0.0f;
}
}
