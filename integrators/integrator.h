// The interface of integrators, which compute radiance for the camera rays of a scene. An
// integrator does not depend on pixels, film or driver.
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
class IndirectGuide;     // renderer/scene
class Interior;          // renderer/scene
class LightGroups;       // renderer/scene
class LightGroupValues;  // renderer/film
struct LightGuide;       // renderer/lights
class PathLayers;        // renderer/film
class PixelSamples;      // samplers
class Scene;             // renderer/scene
class SurfaceRoles;      // renderer/scene
struct SurveyPaths;      // integrators/indirect_survey.cpp

struct IntegratorSettings {
  // Maximum number of scattering events; 1 means direct light only. Going straight through a smooth
  // thin wall is not counted.
  int max_depth = 16;
  // If true, the environment lights the scene, but the camera sees neither the environment nor
  // shadow catchers, whether directly or straight through smooth thin walls.
  bool transparent = false;
  // Upper limit for each contribution of indirect light to a sample. Light is indirect if another
  // surface scattered it before it reached the visible surface. Surfaces that are seen in mirrors
  // or through smooth glass count as visible. If a channel exceeds the limit, the light is scaled
  // down without changing its colour. 0 means no limit.
  float clamp_indirect = 0.0f;
  // Number of light samples at surfaces that are visible directly, in mirrors or through smooth
  // glass; other surfaces take one. At most PixelSamples::kAuxiliarySlots + 1. With 0, only BSDF
  // sampling finds lights; tests use this as an independent estimator.
  int light_samples = 1;
};

// Statistics of paths in glass, summed over all samples.
struct OpticsCounters {
  uint64_t rays_ended_at_panes = 0;  // rays with > kMaxWalls walls or hidden faces in a row
  uint64_t dropped_solids = 0;       // times a path inside Interior::kLimit solids entered another
  // The number of light samples of point-like lights, and the number of these samples that only
  // smooth solid glass blocks. Such light is lost, since only light sampling finds point-like
  // lights. One sample in 16 is examined.
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

// A batch of samples, given by their camera rays, and the outputs that the caller wants.
struct SampleBatch {
  const Scene& scene;
  const Camera& camera;
  std::span<const Ray> rays;
  bool all_rays_miss = false;    // the caller knows that no ray hits a surface
  bool surface_aovs = false;     // fill SampleValue::first_hit
  bool hit_id = false;           // fill first_hit.id only
  const AovSet* aovs = nullptr;  // the requested AOVs; null if none
  // The time for which the shutter is open, in frames. If it is not 0, first_hit.velocity is filled
  // in for surfaces, which requires surface_aovs.
  double velocity_frames = 0.0;
  // Output of radiance by light group; set both pointers or neither. The caller must clear
  // light_values. The sum over the groups is SampleValue::radiance.
  const LightGroups* light_groups = nullptr;
  LightGroupValues* light_values = nullptr;
  // Output of radiance by light-path layer, indexed by PathLayers::index_of.
  const PathLayers* path_layers = nullptr;
  LightGroupValues* layer_values = nullptr;
  // Guides light samples; null if there is no guide.
  const LightGuide* guide = nullptr;
  // Guides paths to indirect light; null if there is no guide.
  const IndirectGuide* indirect_guide = nullptr;
  // Output of the paths' vertices for the survey that makes such a guide; null if not recorded.
  SurveyPaths* survey = nullptr;
  // Output of denoiser features, with one entry per ray. The caller must set each entry to its
  // default value. An empty span means that features are not recorded.
  std::span<DenoiserFeatures> features = {};
  // Says which surfaces are holdouts or catchers for camera rays; null if there are none. A ray
  // that has gone straight through smooth thin walls still counts as a camera ray here. Only `path`
  // and `direct` support holdouts and catchers.
  const SurfaceRoles* roles = nullptr;
  // Output of the light on catchers, with one entry per ray. The caller must set each entry to its
  // default value. An empty span means that this light is not recorded.
  std::span<CatcherSample> catcher_samples = {};
  // Guides light samples at catchers under an environment. Catchers take no BSDF samples, so their
  // light samples must also cover the light that MIS compensation would leave to BSDF samples.
  const LightGuide* catcher_guide = nullptr;
  // The solids in which each ray starts, one entry per ray; null if all rays start outside.
  const Interior* interiors = nullptr;
  OpticsCounters* optics = nullptr;  // may be null
  // Adds up the light that IntegratorSettings::clamp_indirect removes; null if nothing is clamped.
  ClampedLight* clamped = nullptr;
};

class Integrator {
 public:
  virtual ~Integrator() = default;
  // Estimates a batch with one virtual call. Thread-safe. `samples` must have been started on the
  // batch, and `values` must be passed in empty (no radiance, alpha 0). values[i], including its
  // ray counts, depends only on ray i and on the random numbers of its sample (law 1).
  virtual void estimate(const SampleBatch& batch, PixelSamples& samples,
                        std::span<SampleValue> values) const = 0;
};

// A row of the table of integrators. The factory, --help, error messages and tests use this table.
struct IntegratorEntry {
  std::string_view name;
  std::string_view summary;
  std::unique_ptr<Integrator> (*create)(const IntegratorSettings&);
  bool shows_uv = false;               // shows texture coordinates even if no material reads them
  bool supports_light_groups = false;  // fills SampleBatch::light_values, layer_values, features
  bool uses_indirect_guide = false;    // reads SampleBatch::indirect_guide
};
std::span<const IntegratorEntry> integrator_table();

// Both functions throw UsageError for an unknown name and list the valid ones.
const IntegratorEntry& find_integrator(std::string_view name);
std::unique_ptr<Integrator> create_integrator(std::string_view name,
                                              const IntegratorSettings& settings);

}  // namespace emberline
