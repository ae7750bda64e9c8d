// Interface of integrators: scene and camera rays in, radiance out. An integrator knows no pixel,
// film or driver.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "renderer/core/ray.h"
#include "renderer/film/sample_value.h"

namespace emberline {

class AovSet;            // renderer/film
class Camera;            // renderer/scene
class ClampedLight;      // renderer/film
class Interior;          // renderer/scene
class LightGroups;       // renderer/scene
class LightGroupValues;  // renderer/film
struct LightGuide;       // renderer/lights
class PathLayers;        // renderer/film
class PixelSamples;      // samplers
class Scene;             // renderer/scene
class SurfaceRoles;      // renderer/scene

struct IntegratorSettings {
  // Scattering events: 1 is direct light only. Going straight through a smooth thin wall is not
  // counted.
  int max_depth = 16;
  // The environment lights the scene, but neither it nor shadow catchers are visible to the camera,
  // directly or straight through smooth panes.
  bool transparent = false;
  // Limit for indirect light: what light that arrives by way of more than the visible surface adds
  // to a sample. Beyond it, in any channel, the light is scaled down without changing its colour.
  // Mirrors and smooth glass are seen through. 0: no limit.
  float clamp_indirect = 0.0f;
  // Light samples at surfaces that are visible, also in mirrors and through smooth glass; other
  // surfaces take one. At most PixelSamples::kAuxiliarySlots + 1. 0: BSDF sampling only, an
  // independent estimator for the tests.
  int light_samples = 1;
};

// Statistics of paths in glass, summed over all samples.
struct OpticsCounters {
  uint64_t rays_ended_at_panes = 0;  // after kMaxWalls in a row
  uint64_t dropped_solids = 0;       // faces met inside Interior::kLimit solids
  // Samples of lights that only light sampling finds, and how many of these are blocked only by
  // smooth solid glass. One sample in 16 is examined.
  uint64_t point_light_samples = 0, blocked_by_glass = 0;

  void merge(const OpticsCounters& o) {
    rays_ended_at_panes += o.rays_ended_at_panes;
    dropped_solids += o.dropped_solids;
    point_light_samples += o.point_light_samples;
    blocked_by_glass += o.blocked_by_glass;
  }
  double blocked_fraction() const {
    return point_light_samples > 0 ? double(blocked_by_glass) / double(point_light_samples) : 0.0;
  }
};

// A batch of samples: their camera rays, in the order of the samples.
struct SampleBatch {
  const Scene& scene;
  const Camera& camera;
  std::span<const Ray> rays;
  bool all_rays_miss = false;    // none of the rays is known to hit a surface
  bool surface_aovs = false;     // fill SampleValue::first_hit
  bool hit_id = false;           // fill first_hit.id only
  const AovSet* aovs = nullptr;  // the requested AOVs; null: none
  // With surface_aovs: also fill first_hit.velocity of surfaces, for a shutter that is open for
  // this number of frames. 0: no velocity.
  double velocity_frames = 0.0;
  // Radiance by light group: both pointers or neither. The values arrive empty; the groups add up
  // to SampleValue::radiance.
  const LightGroups* light_groups = nullptr;
  LightGroupValues* light_values = nullptr;
  // Radiance by light-path layer; indexed by PathLayers::index_of.
  const PathLayers* path_layers = nullptr;
  LightGroupValues* layer_values = nullptr;
  // Guides light samples; null: none.
  const LightGuide* guide = nullptr;
  // Denoiser features, one for each ray; arrive empty. Empty span: not recorded.
  std::span<DenoiserFeatures> features = {};
  // Holdouts and catchers for camera rays, also straight through smooth panes; null: none. Only
  // `path` and `direct` support them.
  const SurfaceRoles* roles = nullptr;
  // Light on catchers, one for each ray; arrives empty. Empty span: not recorded.
  std::span<CatcherSample> catcher_samples = {};
  // With catchers and an environment: samples the environment by all of its light. Catchers take no
  // BSDF samples, which would find the light that MIS compensation leaves out.
  const LightGuide* catcher_guide = nullptr;
  // The solids that each ray starts in, one for each ray. Null: all start outside.
  const Interior* interiors = nullptr;
  OpticsCounters* optics = nullptr;  // may be null
  // With IntegratorSettings::clamp_indirect: counts the removed light. Otherwise null.
  ClampedLight* clamped = nullptr;
};

class Integrator {
 public:
  virtual ~Integrator() = default;
  // One virtual call per batch. Thread-safe. `samples` has been started on the batch. values[i]
  // arrive empty (no radiance, alpha 0). They, and the rays counted there, depend only on ray i and
  // its sample's random numbers (law 1).
  virtual void estimate(const SampleBatch& batch, PixelSamples& samples,
                        std::span<SampleValue> values) const = 0;
};

// A row of the table of integrators, which feeds the factory, --help, error messages and tests.
struct IntegratorEntry {
  std::string_view name;
  std::string_view summary;
  std::unique_ptr<Integrator> (*create)(const IntegratorSettings&);
  bool shows_uv = false;               // shows texture coordinates even if no material reads them
  bool supports_light_groups = false;  // fills SampleBatch::light_values, layer_values, features
};
std::span<const IntegratorEntry> integrator_table();

// Both throw UsageError with the valid names.
const IntegratorEntry& find_integrator(std::string_view name);
std::unique_ptr<Integrator> create_integrator(std::string_view name,
                                              const IntegratorSettings& settings);

}  // namespace emberline
