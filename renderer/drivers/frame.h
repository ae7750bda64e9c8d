// What every driver renders: one frame, and what is counted on the way.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "integrators/integrator.h"
#include "renderer/core/rect.h"
#include "renderer/film/clamped_light.h"
#include "renderer/film/film_channels.h"
#include "renderer/film/film_extras.h"
#include "samplers/sampler.h"

namespace emberline {

class Archive;         // renderer/core
class CameraSolids;    // renderer/scene
class CryptomatteIds;  // renderer/scene
class EmptyPixels;     // renderer/scene
class PixelFilter;     // renderer/film

// A sample that came out NaN or infinite: enough to replay it.
struct NonFiniteSample {
  int x = 0, y = 0;
  uint32_t sample = 0;
  uint32_t seed = 0;  // the frame's, or its round's
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

// What happened, summed over the frame.
struct RenderCounters {
  RayCounters rays;
  uint64_t samples = 0;
  uint64_t non_finite_samples = 0;
  std::vector<NonFiniteSample> located;       // the first few, in (y, x, sample) order
  uint32_t min_samples = 0, max_samples = 0;  // per pixel of the crop
  ClampedLight clamped;                       // by --clamp-indirect
  OpticsCounters optics;
  bool stopped = false;  // by the stop token, before the work was done

  static constexpr size_t kLocatedLimit = 16;
  void locate(const NonFiniteSample& sample);
  // All but min_samples and stopped, which no worker knows.
  void merge(const RenderCounters& other);
  // All but `stopped`.
  void archive(Archive& archive);
};

// Says what glass has kept from the picture, if anything.
void warn_of_optics(const OpticsCounters& counters);

// All that is constant while a frame renders. Refers to things that must outlive it.
struct Frame {
  const Scene& scene;
  const Camera& camera;
  const Integrator& integrator;
  const Sampler& sampler;
  const PixelFilter& filter;
  int width = 0, height = 0;
  Rect crop;                       // what of it is rendered; the whole, if it is not cropped
  uint32_t first_sample = 0;       // of every pixel; samples of a film are counted from here on
  uint32_t samples_per_pixel = 1;  // of every pixel; of adaptive sampling on average, or 0
  uint32_t seed = 0;
  StreamCount streams = StreamCount::kOne;
  // Samples after which the half of the film changes: 8, with the stream (samplers/sampler.h).
  uint32_t half_block = 8;
  AovSet aovs;
  double shutter_frames = 1.0;  // how long it is open; 1 for an instant, of which velocity() is
  bool exact_counts = true;     // every pixel gets samples_per_pixel, and none more
  float clamp_indirect = 0.0f;  // the integrator's
  // Of the scene as it is built: what each of them gives is kept apart, if the integrator tells
  // lights apart (IntegratorEntry). Null: it is not, and costs nothing.
  const LightGroups* light_groups = nullptr;
  // Of the scene as it is built: each pixel's ids are kept (FilmExtras has room for them). Null:
  // no.
  const CryptomatteIds* cryptomattes = nullptr;
  // Of the scene as it is built; null: the camera sees all of it as other rays do.
  const SurfaceRoles* roles = nullptr;
  // Whose camera rays are not traced; null: all are.
  std::shared_ptr<const EmptyPixels> empty_pixels;
  // What the camera stands in; null: no solid.
  std::shared_ptr<const CameraSolids> camera_solids;
  // Those of SampleBatch; null: none.
  std::shared_ptr<const LightGuide> guide, catcher_guide;

  int half_of(uint32_t sample) const {
    return streams == StreamCount::kTwo ? int(sample / half_block & 1u) : 0;
  }
  // Whether samples have a time.
  bool moves() const;
  // Of which a worker, or what is loaded of the frame, begins.
  RenderCounters no_counts() const;
  FilmExtras with_light_groups(FilmExtras extras) const;
};

}  // namespace emberline
