// The settings of a frame, with the only defaults. Every client fills in this struct.
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

// Where light samples go: by each light's power alone, or guided by a survey of the light that
// arrives (renderer/scene/light_survey.h).
enum class EnvironmentSampling { kGuided, kByLight };

// Samples [first, end) of each pixel.
struct SampleSpan {
  uint32_t first = 0, end = 0;
};

// When the shutter is open, in frames from the frame's time on.
struct Shutter {
  double open = 0, close = 0;
};

// A view from all round the scene: the camera turns about the vertical axis through its centre.
struct Turntable {
  std::optional<int> frame;  // of the turn: 1 is the camera as it stands; absent: each in turn
  uint32_t count = 1;        // frames of a full turn
  bool operator==(const Turntable&) const = default;
};

// The sun of a clear sky, in degrees: above the horizon; from -Z over +X, which is east.
struct SunPosition {
  double elevation = 0, azimuth = 0;
};

// Names are those of the tables: driver_table(), integrator_table() and so on.
struct FrameSettings {
  std::string scene;          // a file
  std::string resource_root;  // files outside it are refused; empty: the scene's own folder

  // Samples and where they go.
  std::string driver = "bucket";
  std::string integrator = "path";
  std::string sampler = "sobol";
  std::string filter{kDefaultFilter};
  std::optional<float> filter_radius;  // pixels; absent: the filter's own
  std::optional<uint32_t> spp;         // 64, if nothing else limits the samples
  std::optional<uint32_t> min_spp, max_spp;
  std::optional<float> noise_threshold;   // expected RMS error in the displayed picture
  std::string estimator;                  // empty: kDefaultEstimator
  std::optional<ErrorMetric> allocation;  // absent: kDefaultAllocation
  bool unbiased = false;
  std::optional<double> time_limit_s;
  int max_depth = 16;
  std::optional<float> clamp_indirect;  // radiance; absent: nothing is clamped
  int light_samples = 1;  // at surfaces that are visible directly, in mirrors or through glass
  uint32_t seed = 0;
  std::optional<int> streams;  // 1, or what the estimator needs
  int bucket_size = 64;        // pixels
  BucketOrder bucket_order = BucketOrder::kHilbert;
  BisectionAxis bisection_axis = BisectionAxis::kBoth;
  Reconstruction reconstruction = Reconstruction::kDuplicate;

  // Frame and view.
  int width = 1280, height = 720;
  std::optional<Rect> crop;
  std::string camera;  // name or index; empty: the file's first, or one that frames the scene
  std::optional<Vec3d> look_from, look_at;       // metres
  std::optional<double> fov_y;                   // degrees
  std::optional<double> f_stop, focus_distance;  // metres; absent: a pinhole
  bool panorama = false;  // all around the camera's place, as a latitude-longitude map
  std::optional<Turntable> turntable;

  // The scene: its pose. Without an animation and a time, nodes keep the file's transforms.
  std::string animation;              // name, index or "all"; empty: the first, if there is a time
  std::optional<double> time, frame;  // seconds; or frames, at `fps`. At most one of them
  double fps = 24;
  std::optional<Shutter> shutter;  // absent: an instant

  // Changes to the scene.
  std::string edits;        // a file of them; empty: none
  std::string variant;      // name or index; empty: the file's own materials
  std::string environment;  // a file; empty: `sun`, or the scene's
  std::optional<SunPosition> sun;
  float environment_strength = 1.0f;
  float environment_rotation = 0.0f;  // degrees
  EnvironmentSampling environment_sampling = EnvironmentSampling::kGuided;
  bool transparent = false;
  WorkingSpace working_space = WorkingSpace::kRec709;
  bool show_backfaces = false;
  bool lenient = false;
  std::optional<EmbreeIsa> isa;  // absent: the widest of the machine

  // A part of the frame, for `merge`; absent: all of it.
  std::optional<FramePart> part;
  std::optional<SampleSpan> sample_range;

  // Channels.
  std::string aovs;
  std::string cryptomattes;        // kinds, a list; layers of the EXR
  int cryptomatte_levels = 6;      // ids of each pixel
  std::string catchers, holdouts;  // nodes, lists (SurfaceRoles)
  bool light_groups = false;       // layers of the EXR
  std::string half;                // layers of it in half floats, a list
  ExrCompression exr_compression = ExrCompression::kZip;
  ExrParts exr_parts = ExrParts::kOne;
  bool denoise = false;  // adds a denoised picture
};

}  // namespace emberline
