// The settings of a frame and their defaults. Every client fills in this struct.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "io/display/choices.h"
#include "io/exr/choices.h"
#include "renderer/core/rect.h"
#include "renderer/core/vector.h"
#include "renderer/drivers/driver_choices.h"
#include "renderer/film/filter_choices.h"

namespace emberline {

enum class EmbreeIsa;  // renderer/scene/embree_isa.h

// The ways to distribute light samples: only by each light's power, or guided by a survey of the
// arriving light (renderer/scene/light_survey.h).
enum class EnvironmentSampling { kGuided, kByLight };
// Whether paths are guided to indirect light (integrators/indirect_survey.h).
enum class Guiding { kAuto, kOn, kOff };

// The samples [first, end) of each pixel.
struct SampleSpan {
  uint32_t first = 0, end = 0;
};

// The times at which the shutter opens and closes, in frames relative to the frame's time.
struct Shutter {
  double open = 0, close = 0;
};

// Says which point the vertical axis of a turntable passes through: the centre of the scene's
// bounds, or the point that the camera looks at.
enum class TurntableCenter { kBounds, kLookAt };

// A turntable view: the camera orbits a vertical axis.
struct Turntable {
  std::optional<int> frame;  // 1 is the unrotated camera; absent: all frames, one after another
  uint32_t count = 1;        // frames of a full turn
  bool operator==(const Turntable&) const = default;
};

// A floor that catches shadows (description/catcher_plane.h).
struct CatcherPlane {
  std::optional<double> height;  // metres; absent: just below the scene
  bool operator==(const CatcherPlane&) const = default;
};

// The sun of a clear sky, in degrees: elevation above the horizon, and azimuth from -Z (north)
// towards +X (east).
struct SunPosition {
  double elevation = 0, azimuth = 0;
};

// Members such as `driver` and `integrator` hold a name from a table such as driver_table().
struct FrameSettings {
  std::string scene;          // file path
  std::string resource_root;  // files outside this folder are rejected; empty: the scene's folder

  // Sampling.
  std::string driver = "bucket";
  std::string integrator = "path";
  std::string sampler = "sobol";
  std::string filter{kDefaultFilter};
  std::optional<float> filter_radius;  // pixels; absent: the filter's default
  std::optional<uint32_t> spp;         // 64 if nothing else limits the samples
  std::optional<uint32_t> min_spp, max_spp;
  std::optional<float> noise_threshold;   // expected RMS error in the displayed picture
  std::string estimator;                  // empty: kDefaultEstimator
  std::optional<ErrorMetric> allocation;  // absent: kDefaultAllocation
  bool unbiased = false;
  std::string judge;  // channels whose error counts (judged_channels_of()); empty: R G B
  std::optional<double> time_limit_s;
  std::optional<double> time_budget_s;  // plan samples for this time (time_budget.h)
  int max_depth = 16;
  std::optional<float> clamp_indirect;  // radiance; absent: no clamping
  int light_samples = 1;                // on surfaces seen directly, in mirrors or through glass
  uint32_t seed = 0;
  bool static_noise = false;   // the same noise in every frame of an animation
  std::optional<int> streams;  // 1 or 2; absent: as many as denoising or the estimator needs
  int bucket_size = 64;        // pixels
  BucketOrder bucket_order = BucketOrder::kHilbert;
  BisectionAxis bisection_axis = BisectionAxis::kBoth;
  Reconstruction reconstruction = Reconstruction::kDuplicate;

  // Frame and view.
  int width = 1280, height = 720;
  std::optional<Rect> crop;
  std::string camera;  // name or index; empty: the first in the file, or a view of the whole scene
  std::optional<Vec3d> look_from, look_at;       // metres
  std::optional<double> fov_y;                   // degrees
  std::optional<double> f_stop, focus_distance;  // metres; without f_stop: a pinhole
  bool panorama = false;  // latitude-longitude map of all directions from the camera
  std::optional<Turntable> turntable;
  TurntableCenter turntable_center = TurntableCenter::kBounds;

  // Animation. Without `animation` and `time`, nodes keep the file's transforms.
  std::string animation;              // name, index or "all"; empty: the first if a time is given
  std::optional<double> time, frame;  // seconds, or frames at `fps`; at most one is set
  double fps = 24;
  std::optional<Shutter> shutter;  // absent: open only for an instant

  // Changes to the scene.
  std::string edits;        // edits file; empty: none
  std::string variant;      // name or index; empty: the file's own materials
  std::string environment;  // file; empty: `sun`, or the scene's environment
  std::optional<SunPosition> sun;
  float environment_strength = 1.0f;
  float environment_rotation = 0.0f;  // degrees
  EnvironmentSampling environment_sampling = EnvironmentSampling::kGuided;
  Guiding guiding = Guiding::kAuto;
  bool transparent = false;
  WorkingSpace working_space = WorkingSpace::kRec709;
  bool show_backfaces = false;
  bool lenient = false;
  std::optional<EmbreeIsa> isa;  // absent: the widest that the machine supports

  // The part of the frame to render, for `merge`. Absent: the whole frame.
  std::optional<FramePart> part;
  std::optional<SampleSpan> sample_range;
  std::string plan;  // file of sample counts (output/sample_plan_file.h); empty: none

  // Channels.
  std::string aovs;
  std::string cryptomattes;        // list of kinds, written as EXR layers
  int cryptomatte_levels = 6;      // ids per pixel
  std::string catchers, holdouts;  // lists of nodes (SurfaceRoles)
  std::optional<CatcherPlane> catcher_plane;
  bool light_groups = false;  // written as EXR layers
  std::string half;           // list of EXR layers stored as half floats
  ExrCompression exr_compression = ExrCompression::kZip;
  ExrParts exr_parts = ExrParts::kOne;
  bool denoise = false;  // adds a denoised picture
};

// Returns whether the frame has shadow catchers.
inline bool has_catchers(const FrameSettings& settings) {
  return !settings.catchers.empty() || settings.catcher_plane;
}

}  // namespace emberline
