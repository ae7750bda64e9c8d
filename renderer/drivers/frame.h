// The data that is constant while a frame renders, and the counters of the rendering.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "integrators/indirect_survey.h"
#include "integrators/integrator.h"
#include "renderer/core/rect.h"
#include "renderer/film/channels.h"
#include "renderer/film/clamped_light.h"
#include "renderer/film/film_extras.h"
#include "renderer/film/pixel_stop.h"
#include "samplers/sampler.h"

namespace emberline {

class Archive;         // renderer/core
class CameraSolids;    // renderer/scene
class CryptomatteIds;  // renderer/scene
class EmptyPixels;     // renderer/scene
class PixelFilter;     // renderer/film

// The data needed to replay a sample that was NaN or infinite.
struct NonFiniteSample {
  int x = 0, y = 0;
  uint32_t sample = 0;
  uint32_t seed = 0;  // the frame's seed, or the seed of the sample's round
};

struct RayCounters {
  uint64_t camera = 0;  // one per sample
  uint64_t scatter = 0, shadow = 0;
  uint64_t total() const { return camera + scatter + shadow; }
  void add(const SampleRays& sample) {
    camera++;
    scatter += sample.scatter;
    shadow += sample.shadow;
  }
  void merge(const RayCounters& o) {
    camera += o.camera;
    scatter += o.scatter;
    shadow += o.shadow;
  }
};

// Counts over the whole frame.
struct RenderCounters {
  RayCounters rays;
  uint64_t samples = 0;
  uint64_t non_finite_samples = 0;
  std::vector<NonFiniteSample> located;       // the first non-finite samples, by (y, x, sample)
  uint32_t min_samples = 0, max_samples = 0;  // per pixel of the crop
  ClampedLight clamped;                       // light removed by --clamp-indirect
  OpticsCounters optics;
  bool stopped = false;  // whether a stop request ended the rendering before the work was done

  static constexpr size_t kMaxLocated = 16;
  void locate(const NonFiniteSample& sample);
  // Adds the counts of `other`, except min_samples and stopped, which workers do not know.
  void merge(const RenderCounters& other);
  // Saves or loads everything except `stopped`.
  void archive(Archive& archive);
};

// Warns if limitations of glass made the picture too dark or refraction wrong.
void warn_about_optics(const OpticsCounters& counters);

// Everything that is constant while a frame renders. Referenced objects must outlive the Frame.
struct Frame {
  const Scene& scene;
  const Camera& camera;
  const Integrator& integrator;
  const Sampler& sampler;
  const PixelFilter& filter;
  int width = 0, height = 0;
  Rect crop;                       // the rendered pixels; the whole frame if not cropped
  uint32_t first_sample = 0;       // index of every pixel's first sample; drivers count from it
  uint32_t samples_per_pixel = 1;  // per pixel; for `adaptive` the average, 0 for no limit
  uint32_t seed = 0;
  StreamCount streams = StreamCount::kOne;
  // Number of consecutive samples that go to the same half of the film. It must be the size of the
  // blocks in which samples alternate between streams (samplers/sampler.h).
  uint32_t half_block = 8;
  AovSet aovs;
  double shutter_frames = 1.0;  // shutter time in frames, for velocity(); 1 for an instant shutter
  // Time in seconds that the frame should take. The driver then begins with few samples, and
  // FrameDriver::extend_work() adds more. 0: no time budget.
  double time_budget_s = 0;
  bool exact_counts = true;     // whether every pixel gets exactly samples_per_pixel
  float clamp_indirect = 0.0f;  // as in the integrator's settings
  // Light groups of the built scene that are recorded separately, if the integrator supports that
  // (IntegratorEntry). Null: no groups.
  const LightGroups* light_groups = nullptr;
  // Cryptomatte ids of the built scene, recorded for each pixel (FilmExtras makes room for them).
  // Null: no ids.
  const CryptomatteIds* cryptomattes = nullptr;
  // Surface roles of the built scene. Null: camera rays see the same surfaces as other rays.
  const SurfaceRoles* roles = nullptr;
  // Pixels whose camera rays are not traced. Null: all camera rays are traced.
  std::shared_ptr<const EmptyPixels> empty_pixels;
  // Solids that contain the camera. Null: no solids.
  std::shared_ptr<const CameraSolids> camera_solids;
  // Light guides for SampleBatch. Null: no guide.
  std::shared_ptr<const LightGuide> guide, catcher_guide;
  IndirectSurvey indirect;  // may have a guide for SampleBatch

  int half_of(uint32_t sample) const {
    return streams == StreamCount::kTwo ? int(sample / half_block & 1u) : 0;
  }
  // Returns why a pixel that has all its samples gets no more.
  PixelStop complete_stop() const {
    return time_budget_s > 0 ? PixelStop::kTimeBudget : PixelStop::kBudget;
  }
  // Returns whether the scene or the camera moves, so that samples have a time.
  bool moves() const;
  // Returns the initial counters of a worker or of a loaded state.
  RenderCounters empty_counters() const;
  FilmExtras with_light_groups(FilmExtras extras) const;
};

}  // namespace emberline
