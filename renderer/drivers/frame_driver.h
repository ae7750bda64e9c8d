// A frame driver decides which pixel gets its next samples. Drivers are interchangeable: for equal
// sample counts they produce equal bits (law 2), because every sample is a pure function of the
// frame (law 1) and each pixel's samples are added in index order by one owner.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "integrators/integrator.h"
#include "renderer/drivers/adaptive/refinement_tree.h"
#include "renderer/drivers/adaptive/round_planner.h"
#include "renderer/drivers/work_item.h"
#include "renderer/film/film.h"
#include "renderer/film/filter.h"
#include "renderer/film/light_mix.h"

namespace emberline {

// All that is constant while a frame renders. Refers to things that must outlive it.
struct Frame {
  const Scene& scene;
  const Camera& camera;
  const Integrator& integrator;
  const Sampler& sampler;
  const PixelFilter& filter;
  int width = 0, height = 0;
  Rect window;                     // what of it is rendered: the crop, or the whole
  uint32_t samples_per_pixel = 1;  // of every pixel; of adaptive sampling on average, or 0
  uint32_t seed = 0;
  StreamCount streams = StreamCount::kOne;
  AovSet aovs;
  bool exact_counts = true;  // every pixel gets samples_per_pixel, and none more
  // Of the scene as it is built: what each of them gives is kept apart, if the integrator tells
  // lights apart (IntegratorEntry). Null: it is not, and costs nothing.
  const LightGroups* light_groups = nullptr;

  FilmExtras with_light_groups(FilmExtras extras) const {
    if (light_groups) extras.light_groups = light_groups->size();
    return extras;
  }
};

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
struct FrameCounters {
  RayCounters rays;
  uint64_t samples = 0;
  uint64_t non_finite_samples = 0;
  std::vector<NonFiniteSample> located;       // the first few, in (y, x, sample) order
  uint32_t min_samples = 0, max_samples = 0;  // per pixel of the window
  bool stopped = false;                       // by the stop token, before the work was done

  static constexpr size_t kLocatedLimit = 16;
  void merge(const FrameCounters& other);
};

// The frame as it can be shown while it renders: complete at every moment, the pixels without
// samples filled from their neighbours.
class FramePicture {
 public:
  virtual ~FramePicture() = default;
  // R G B A of every pixel of the window, interleaved, rows from its top. With a mix, of a frame
  // with light groups, under other lights: each group times its weight (renderer/film/light_mix.h).
  virtual void resolve(std::span<float> rgba, const LightMix* mix = nullptr) const = 0;
  virtual const FilmTile& film() const = 0;
  // Why the pixel of the window gets no more samples, as far as the driver has decided that by now;
  // kGoingOn for the others, also where a stop request has cut them short.
  virtual PixelStop stop_so_far(int x, int y) const = 0;
};

// How far a progressive render has come.
struct FrameProgress {
  int pass = 0;             // how many have begun; the first brings every pixel its first sample
  uint64_t samples = 0;     // so far
  uint64_t rays = 0;        // likewise
  double completion = 0.0;  // of the first pass: pixels that have a sample, in [0, 1]
  bool pass_finished = false;
  // The driver's own, if it has made one: of the picture as it was at the end of the pass before.
  std::optional<double> error_estimate;
};

// How window, progress bar, writers and checkpoints see the frame; drivers know none of them.
// Called from worker threads, concurrently, unless a function says otherwise.
class FrameObserver {
 public:
  virtual ~FrameObserver() = default;
  // A driver that finishes one part of the frame after another begins with these pixels.
  virtual void tile_begun(const Rect& /*pixels*/) {}
  // All samples of the tile's pixels are in; the tile is reused after the call returns. May throw:
  // the frame is then abandoned and render() rethrows.
  virtual void tile_finished(const FilmTile& tile) = 0;
  // Some more samples are done (about every millisecond of work).
  virtual void samples_finished(uint64_t /*count*/) {}
  // A progressive driver pauses: from its own thread, while no worker renders. That is often in its
  // first pass, and then at the end of each pass or where a picture is wanted. The picture may be
  // looked at until the call returns.
  virtual void picture_changed(const FrameProgress& /*progress*/, const FramePicture& /*picture*/) {
  }
  // Somebody waits for picture_changed(): a progressive driver then pauses after the parts that
  // are under way, some milliseconds of work, instead of after a slice of them. Asked from worker
  // threads after each part; what is rendered is the same.
  virtual bool picture_wanted() const { return false; }
  // The least number of the frame's samples at which the next picture is wanted: a progressive
  // driver then pauses with the part that reaches it, for whatever number of threads. Asked at
  // pauses.
  virtual std::optional<uint64_t> picture_wanted_at() const { return std::nullopt; }
  // Why a stop was requested, for the pixels that it cut short.
  virtual PixelStop stop_cause() const { return PixelStop::kUser; }
};

class FrameDriver {
 public:
  virtual ~FrameDriver() = default;
  // Renders the frame, on the calling thread's TBB arena. Returns soon after a stop is requested.
  virtual FrameCounters render(const Frame& frame, FrameObserver& observer,
                               std::stop_token stop) = 0;
  // Hands the observer the finished tiles of what render() kept in memory; to be called once after
  // it. A driver that hands on every tile as it is finished keeps nothing.
  virtual void deliver(FrameObserver& /*observer*/) {}
  // The driver's estimate of the delivered frame's error: expected RMS error of the displayed
  // picture, if it made one.
  virtual std::optional<double> error_estimate() const { return std::nullopt; }
  // What decided the number of the pixel's samples, in lines for people, or what does so far; empty
  // if nothing did. At a pause, or after render().
  virtual std::string explain(int /*x*/, int /*y*/) const { return {}; }
  // At a pause: explain() will be asked about this pixel instead of the settings', and has to tell
  // of it what happens from here on.
  virtual void follow(int /*x*/, int /*y*/) {}
  // What render() kept, as it can be shown; null for a driver that keeps nothing.
  virtual const FramePicture* picture() const { return nullptr; }
  // The tree by which the first samples were placed, if that is what the driver does and
  // DriverSettings::keep_tree asked for it.
  virtual const RefinementTree* tree() const { return nullptr; }
  // What render() and deliver() will hold of each pixel of a frame beside their workers' tiles, at
  // most; with light groups 24 for each and 24 more.
  virtual uint64_t bytes_per_pixel(const AovSet& /*aovs*/) const { return 0; }
  // What the driver holds beside its workers' tiles, for the report.
  virtual uint64_t film_bytes() const { return 0; }
};

struct DriverSettings {
  int bucket_size = 64;
  std::string bucket_order = "hilbert";
  std::string bisection_axis = "both";
  std::string reconstruction = "duplicate";
  AdaptiveSettings adaptive = {};
  std::optional<Vec2i> explained = {};  // the pixel that explain() will be asked about
  bool keep_tree = false;               // tree() will be asked for
};

struct DriverEntry {
  std::string_view name;
  std::string_view summary;
  std::unique_ptr<FrameDriver> (*create)(const DriverSettings&);
  bool progressive = false;  // calls FrameObserver::picture_changed
};
std::span<const DriverEntry> driver_table();

// Throws UsageError that lists the valid names.
std::unique_ptr<FrameDriver> create_driver(std::string_view name, const DriverSettings& settings);

}  // namespace emberline
