#include "integrators/indirect_survey.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <vector>

#include "integrators/path_glass.h"
#include "integrators/path_loop.h"
#include "integrators/recorders/hooks.h"
#include "renderer/core/flush_denormals.h"
#include "renderer/core/memory_budget.h"
#include "renderer/core/parallel.h"
#include "renderer/scene/camera.h"
#include "renderer/scene/indirect_guide.h"
#include "samplers/sampler.h"

namespace emberline {

// The vertices of a batch of paths.
struct SurveyPaths {
  static constexpr size_t kMaxVertices = 12;  // per path; later ones are not recorded
  struct Path {
    std::array<SurveyVertex, kMaxVertices> vertices;
    size_t count = 0;
  };
  std::array<Path, kRayBatch> paths;
};

namespace {

// We chose the following constants; tests/bench/results has results for other values.
//
// The number of paths (log2) in the pilot, which also decides whether a guide is worthwhile, and in
// the last of the two rounds after it. The first of these has half as many. Each round is guided by
// all paths before it.
constexpr int kMinPilotBits = 8, kMaxBits = 16;
// Without `always`, paths are guided in rooms and the like, where these limits hold. In the open,
// light samples find most of the light, and guiding only costs time.
constexpr double kMinIndirectFraction = 0.25, kMaxLeavingFraction = 0.25;
// The depth limit of the survey's paths. Longer ones would add little, since the light at each
// vertex comes from its cell.
constexpr int kMaxDepth = 8;
constexpr size_t kChunk = 512;  // batches that are traced before their vertices are collected
constexpr uint32_t kSurveySeed = 0x5eed1e55u;

class SurveyRecorder : public Recorder {
 public:
  explicit SurveyRecorder(PathBatch& batch) : Recorder(batch) {}

  void shaded(int lane) {
    SurveyPaths::Path& path = b_.batch.survey->paths[size_t(lane)];
    current_[lane] = nullptr;
    if (path.count == SurveyPaths::kMaxVertices) return;
    SurveyVertex& v = path.vertices[path.count++];
    current_[lane] = &v;
    const ShadedPoint& point = b_.points[lane];
    v.position = point.surface.position;
    v.orientation = IndirectGuide::orientation_of(point.frame.shading.normal);
    if (b_.bsdfs[lane].can_be_guided() && !point.surface.material->unlit()) {
      v.albedo = limited(b_.bsdfs[lane].albedo());
    }
    v.samples_lights = b_.may_scatter(b_.paths[lane]);
    v.is_first = v.albedo > 0.0f && !has_first_[lane];
    has_first_[lane] |= v.is_first;
  }
  Rgb emitted(int lane, const Rgb& light) {
    if (current_[lane]) current_[lane]->emitted += limited(light);
    return light;
  }
  Rgb connected(int lane, const Rgb& light) {
    if (current_[lane]) current_[lane]->direct += limited(light);
    return light;
  }
  Rgb environment(int lane, const Rgb&, const Rgb& light) {
    if (current_[lane]) current_[lane]->incoming = limited(light);
    return light;
  }
  void scattered(int lane, const BsdfSample& next) {
    SurveyVertex* const v = current_[lane];
    if (!v) return;
    v->next = SurveyVertex::Next::kSurface;
    v->weight = limited(next.weight);
    v->is_diffuse = !next.delta && next.wi.z > 0.0f && v->albedo > 0.0f;
    if (v->is_diffuse) v->bin = uint8_t(CosineGuide::bin_of(next.wi));
  }
  // environment() follows if the scene has an environment.
  void missed(int lane) {
    if (!current_[lane]) return;
    current_[lane]->next = SurveyVertex::Next::kNothing;
    current_[lane]->incoming = 0.0f;
  }
  // The last vertex of a path that roulette or a limit ended has no next vertex.
  void paths_ended(const LaneList& hit) {
    for (const int lane : hit) {
      SurveyPaths::Path& path = b_.batch.survey->paths[size_t(lane)];
      if (path.count == 0) continue;
      SurveyVertex& last = path.vertices[path.count - 1];
      if (last.next == SurveyVertex::Next::kSurface) last.next = SurveyVertex::Next::kUnknown;
    }
  }

 private:
  // The luminance; 0 if it is no number.
  static float limited(const Rgb& light) {
    const float value = luminance(light);
    return value > 0.0f ? std::min(value, SurveyVertex::kMaxLight) : 0.0f;
  }

  SurveyVertex* current_[kRayBatch] = {};  // null after kMaxVertices
  bool has_first_[kRayBatch] = {};
};

class Surveyor {
 public:
  Surveyor(const SurveyedView& view, const std::stop_token& stop)
      : view_(view),
        settings_{.max_depth = std::min(view.max_depth, kMaxDepth)},
        stop_(stop),
        memory_(view.memory, MemoryPart::kLights) {}

  IndirectSurvey run(bool always) {
    const uint64_t pixels = uint64_t(view_.width) * uint64_t(view_.height);
    const int bits = std::clamp(int(std::bit_width(pixels)), kMinPilotBits + 2, kMaxBits);
    const int pilot_bits = std::max(bits - 5, kMinPilotBits);
    reserve(size_t(1) << pilot_bits);
    trace(pilot_bits);
    if (!build()) return {};
    IndirectSurvey result = {nullptr, guide_->indirect_fraction(), leaving_fraction()};
    const bool is_room = result.indirect_fraction >= kMinIndirectFraction &&
                         result.leaving_fraction <= kMaxLeavingFraction;
    if (!always && !is_room) return result;
    reserve(size_t(3) << (bits - 1));
    for (const int round_bits : {bits - 1, bits}) {
      trace(round_bits);
      if (!build()) return {};
    }
    result.guide = guide_;
    return result;
  }

 private:
  // Reserves the memory for this many more paths.
  void reserve(size_t paths) {
    const size_t vertices = vertices_.size() + paths * SurveyPaths::kMaxVertices;
    const size_t at_once = kChunk * kRayBatch * SurveyPaths::kMaxVertices;
    memory_.release();
    memory_.add((vertices + at_once) * sizeof(SurveyVertex) + IndirectGuide::bytes(vertices),
                "`guiding` (off needs no memory): the survey of indirect light");
    vertices_.reserve(vertices);
  }

  // Traces 2^bits paths, guided by the guide of the rounds before.
  void trace(int bits) {
    const size_t batches = (size_t(1) << bits) / kRayBatch;
    for (size_t first = 0; first < batches; first += kChunk) {
      std::vector<std::vector<SurveyVertex>> found(std::min(kChunk, batches - first));
      parallel_ranges(found.size(), 4, [&](size_t begin, size_t end) {
        const FlushDenormals flush;  // as the render workers do
        PixelSamples samples(*sampler_);
        for (size_t i = begin; i < end && !stop_.stop_requested(); ++i) {
          found[i] = trace_batch(uint32_t(first + i) * kRayBatch, bits, samples);
        }
      });
      for (const std::vector<SurveyVertex>& vertices : found) {
        vertices_.insert(vertices_.end(), vertices.begin(), vertices.end());
      }
    }
    ++round_;
  }

  std::vector<SurveyVertex> trace_batch(uint32_t first_path, int bits, PixelSamples& samples) {
    std::array<SampleAddress, kRayBatch> addresses;
    for (uint32_t i = 0; i < kRayBatch; ++i) addresses[i] = {first_path + i, round_, 0};
    samples.start_batch(addresses, kSurveySeed);
    std::array<Ray, kRayBatch> rays;
    for (int i = 0; i < kRayBatch; ++i) {
      samples.start_sample(i);
      rays[size_t(i)] = camera_ray(first_path + uint32_t(i), bits, samples);
    }
    SurveyPaths paths;
    SampleBatch batch{.scene = view_.scene, .camera = view_.camera, .rays = rays};
    batch.guide = view_.light_guide;
    batch.indirect_guide = guide_.get();
    batch.survey = &paths;
    std::array<SampleValue, kRayBatch> values;
    PathLoop<PathGlass, SurveyRecorder>(settings_, batch, samples, values).trace();
    size_t count = 0;
    for (const SurveyPaths::Path& path : paths.paths) count += path.count;
    std::vector<SurveyVertex> vertices;
    vertices.reserve(count);
    for (const SurveyPaths::Path& path : paths.paths) {
      vertices.insert(vertices.end(), path.vertices.begin(), path.vertices.begin() + path.count);
    }
    return vertices;
  }

  // Divides the frame into 2^bits rectangles, with one path each. Ignores solids around the camera,
  // which affects only the noise.
  Ray camera_ray(uint32_t path, int bits, const PixelSamples& samples) const {
    const uint32_t columns = 1u << (bits + 1) / 2, rows = 1u << bits / 2;
    const Vec2f film((float(path % columns) + samples.get(camera_dim::kPixelX)) / float(columns) *
                         float(view_.width),
                     (float(path / columns) + samples.get(camera_dim::kPixelY)) / float(rows) *
                         float(view_.height));
    const bool moves = view_.scene.moves() || view_.camera.moves();
    return view_.camera.ray(film,
                            {samples.get(camera_dim::kLensX), samples.get(camera_dim::kLensY)},
                            moves ? samples.get(camera_dim::kTime) : 0.0f);
  }

  double leaving_fraction() const {
    double rays = 0, leaving = 0;
    for (const SurveyVertex& v : vertices_) {
      rays += v.is_diffuse;
      leaving += v.is_diffuse && v.next == SurveyVertex::Next::kNothing;
    }
    return leaving / std::max(rays, 1.0);
  }

  // Returns false if there is no guide.
  bool build() {
    if (stop_.stop_requested()) return false;
    guide_.reset();
    guide_ = std::make_shared<IndirectGuide>(vertices_);
    return !guide_->empty();
  }

  const SurveyedView& view_;
  const IntegratorSettings settings_;
  const std::stop_token& stop_;
  MemoryReservation memory_;
  const std::unique_ptr<Sampler> sampler_ = create_sampler("independent", {});
  uint32_t round_ = 0;
  std::vector<SurveyVertex> vertices_;
  std::shared_ptr<IndirectGuide> guide_;
};

}  // namespace

std::string IndirectSurvey::describe() const {
  if (indirect_fraction < 0) return "";
  return fmt::format("{}: {:.0f} % of the light is indirect, {:.0f} % of the rays leave the scene",
                     guide ? guide->describe() : "paths not guided", 100 * indirect_fraction,
                     100 * leaving_fraction);
}

IndirectSurvey survey_indirect_light(const SurveyedView& view, bool always,
                                     const std::stop_token& stop) {
  return Surveyor(view, stop).run(always);
}

}  // namespace emberline
