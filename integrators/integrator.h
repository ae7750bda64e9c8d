// Scene and camera rays in, radiance out. An integrator knows no pixel, film or driver.
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

// All that is constant over a frame and that an integrator may ask for.
struct IntegratorSettings {
  // Scattering events: 1 is direct light only. To go straight through a smooth thin wall is none.
  int max_depth = 16;
  // The environment lights the scene but is not seen by the camera, nor straight through smooth
  // panes; nor are shadow catchers.
  bool transparent = false;
  // The most that a path's light may add to a sample in any channel, where it has come by way of
  // more than the surface that is seen: scaled down beyond it, in its colour. Mirrors and smooth
  // glass are seen through. 0: no limit.
  float clamp_indirect = 0.0f;
  // Taken at surfaces that are seen, also in mirrors and through smooth glass, at the others one;
  // at most PixelSamples::kBesideSlots + 1. 0: BSDF sampling alone, an independent estimator for
  // the tests.
  int light_samples = 1;
};

// Counts what paths in glass run into; sums over all samples.
struct OpticsCounters {
  uint64_t rays_ended_at_walls = 0;  // kMostWalls in a row
  uint64_t solids_forgotten = 0;     // faces met inside Interior::kMost solids already
  // Samples of lights that only such samples find, and how many of them would have arrived but for
  // smooth solid glass. One sample in 16 is looked at.
  uint64_t point_light_samples = 0, blocked_by_glass = 0;

  void merge(const OpticsCounters& o) {
    rays_ended_at_walls += o.rays_ended_at_walls;
    solids_forgotten += o.solids_forgotten;
    point_light_samples += o.point_light_samples;
    blocked_by_glass += o.blocked_by_glass;
  }
  double blocked_share() const {
    return point_light_samples > 0 ? double(blocked_by_glass) / double(point_light_samples) : 0.0;
  }
};

// The work of one batch of samples: their camera rays, in the order of the batch's numbers.
struct SampleBatch {
  const Scene& scene;
  const Camera& camera;
  std::span<const Ray> rays;
  bool nothing_ahead = false;    // it is known that none of the rays meets a surface
  bool surface_aovs = false;     // fill SampleValue::first_hit
  bool hit_id = false;           // fill first_hit.id alone
  const AovSet* aovs = nullptr;  // that are asked for; null: none
  // With surface_aovs: also fill first_hit.velocity of surfaces, for a shutter that is open for
  // this number of frames. 0: no velocity.
  double velocity_frames = 0.0;
  // The radiance by light group: both pointers or neither. The values arrive without light; the
  // groups' shares add up to SampleValue::radiance.
  const LightGroups* light_groups = nullptr;
  LightGroupValues* light_values = nullptr;
  // The same by light path: values by PathLayers::place_of.
  const PathLayers* path_layers = nullptr;
  LightGroupValues* layer_values = nullptr;
  // Guides light samples; null: none.
  const LightGuide* guide = nullptr;
  // For the denoiser: one for each ray, which arrives empty. No span: not recorded.
  std::span<DenoiserFeatures> features = {};
  // Holdouts and catchers, for camera rays, also straight through smooth panes; null: none. Only
  // `path` and `direct` know them.
  const SurfaceRoles* roles = nullptr;
  // Light on catchers: one for each ray, which arrives empty. No span: not recorded.
  std::span<CatcherSample> catcher_samples = {};
  // With catchers and an environment: samples the environment by all of its light, since no BSDF
  // sample finds the light that MIS compensation leaves out.
  const LightGuide* catcher_guide = nullptr;
  // The solids that each ray begins in: as many as there are rays. Null: all begin outside.
  const Interior* interiors = nullptr;
  OpticsCounters* optics = nullptr;  // counts, if it is there
  // With IntegratorSettings::clamp_indirect: counts what it takes. Else null.
  ClampedLight* clamped = nullptr;
};

class Integrator {
 public:
  virtual ~Integrator() = default;
  // One virtual call per batch, none per ray. `samples` has been started on the batch. Thread-safe;
  // values[i] arrive empty (no radiance, alpha 0) and depend on ray i and its sample's numbers
  // alone (law 1): the rays counted there, too.
  virtual void estimate(const SampleBatch& batch, PixelSamples& samples,
                        std::span<SampleValue> values) const = 0;
};

// The table of integrators: feeds the factory, --help, the "valid names are" message and the tests.
struct IntegratorEntry {
  std::string_view name;
  std::string_view summary;
  std::unique_ptr<Integrator> (*create)(const IntegratorSettings&);
  bool shows_uv = false;  // texture coordinates are looked at even if no material reads them
  bool tells_lights_apart = false;  // fills SampleBatch::light_values, layer_values and `features`
};
std::span<const IntegratorEntry> integrator_table();

// Both throw UsageError that lists the valid names.
const IntegratorEntry& find_integrator(std::string_view name);
std::unique_ptr<Integrator> create_integrator(std::string_view name,
                                              const IntegratorSettings& settings);

}  // namespace emberline
