#include "renderer/session/view_frame.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "renderer/core/errors.h"
#include "renderer/core/parallel.h"
#include "renderer/engine/render_plan.h"
#include "renderer/session/overlay_picture.h"

namespace emberline {
namespace {

// An edit's first picture is shown when this fraction of the pixels has a sample, which takes 10 to
// 20 ms for 1280 x 720 on two cores. In slow scenes, it is shown earlier, after
// kFirstPictureTimeout_s.
constexpr double kFirstCoverage = 1.0 / 64;
constexpr double kFirstPictureTimeout_s = 0.012;

// Later pictures come no faster than the eye can follow, and may only use a fraction of the render
// time. In the first second, while the artist waits for the effect of an edit, this fraction is
// kInteractiveCostFraction; after that, it is kIdleCostFraction.
constexpr double kMinInterval_s = 1.0 / 30;
constexpr double kInteractive_s = 1.0;
constexpr double kInteractiveCostFraction = 0.1;
constexpr double kIdleCostFraction = 0.01;

// The region gets this number of samples per pixel before the rest of the frame is rendered.
constexpr uint32_t kRegionSamples = 16;

// The first picture of a bucket frame takes extra samples, up to this fraction of the frame's
// samples. For this limit, the frame counts as having at least kMinJudgedSamples per pixel, the
// minimum that an estimator needs, and exactly this many if its number of samples is unknown.
constexpr double kFirstPictureFraction = 0.005;
constexpr uint32_t kMinJudgedSamples = 16;

// The publisher keeps this many pictures, each with linear and graded values: the newest, one that
// is being drawn, and the comparison picture twice (as stored, and graded again).
constexpr uint64_t kPictures = 4;

Camera camera_of(const RenderRequest& request) {
  const LoadedScene& scene = *request.scene;
  const int width = request.settings.render.width, height = request.settings.render.height;
  const Scene& built = scene.scene->scene();
  return {
      edited_camera(request.edits, scene.scene->editable().original(), scene.camera(width, height)),
      width,
      height,
      built.origin(),
      built.scale(),
      built.max_origin()};
}

double to_seconds(ViewClock::duration time) { return std::chrono::duration<double>(time).count(); }

// Replaces the stop reasons in the channel `stop`, and keeps the other information in its values.
void put_stops(std::span<const float> reasons, FilmCopy* copy) {
  const std::vector<std::string> names = film_channel_names(copy->aovs);
  const auto channel = size_t(std::ranges::find(names, "stop") - names.begin());
  for (size_t i = 0; i < reasons.size(); ++i) {
    float& stop = copy->channels[names.size() * i + channel];
    stop += reasons[i] - float(reason_of(uint8_t(stop)));
  }
}

}  // namespace

ViewFrame::ViewFrame(RenderRequest request, const PreparedSettings& prepared,
                     PicturePublisher& publisher, LiveDenoiser& denoiser,
                     std::shared_ptr<StopRequest> stop,
                     const std::atomic<DisplayMode>& display_mode,
                     const std::atomic<bool>& pause_requested, Pause pause)
    : request_(std::move(request)),
      prepared_(prepared),
      publisher_(publisher),
      denoiser_(denoiser),
      stop_(std::move(stop)),
      display_mode_(display_mode),
      pause_requested_(pause_requested),
      pause_(std::move(pause)),
      crop_(prepared.plan.crop),
      camera_(camera_of(request_)),
      memory_(request_.scene->memory.budget(), MemoryPart::kFilm) {}

ViewFrame::~ViewFrame() = default;

void ViewFrame::render(std::optional<Vec2i> explained) {
  explained_ = explained;
  const uint64_t pictures = kPictures * (4 * sizeof(float) + 4);
  reserve(crop_,
          request_.settings.denoise ? 2 * pictures + LiveDenoiser::kBytesPerPixel : pictures);
  if (request_.settings.region) render_region();
  const bool buckets = prepared_.plan.driver->tiles;
  if ((prepared_.live || buckets) && stop_->cause() == PixelStop::kNone) {
    render_stage(Stage::kFirst, first_, "bisection", crop_, 1);
  }
  if (stop_->cause() != PixelStop::kNone) return;
  if (buckets) begin_buckets();
  const RenderCounters counters = render_stage(Stage::kMain, main_, prepared_.options.driver, crop_,
                                               prepared_.plan.samples_per_pixel);
  if (!counters.stopped || stop_->cause() == PixelStop::kTimeLimit) finish(counters);
}

void ViewFrame::reserve(const Rect& pixels, uint64_t bytes_per_pixel) {
  memory_.add(bytes_of(uint64_t(pixels.area()), bytes_per_pixel),
              fmt::format("a frame of {}x{} pixels", crop_.width(), crop_.height()));
}

// Renders the region as a separate job, so that each pixel gets the same samples as in the whole
// frame.
void ViewFrame::render_region() {
  const Rect region = request_.settings.region->intersect(crop_);
  if (region.empty()) return;
  render_stage(Stage::kRegion, region_, "bisection", region, kRegionSamples);
}

RenderCounters ViewFrame::render_stage(Stage stage, std::unique_ptr<RenderJob>& job,
                                       const std::string& name, const Rect& crop,
                                       uint32_t samples_per_pixel) {
  StageOptions options = {name, crop, samples_per_pixel, {}, groups_.get()};
  const bool is_inside = explained_ && crop.contains(explained_->x, explained_->y);
  if (stage == Stage::kMain && is_inside) options.explained = explained_;
  std::unique_ptr<RenderJob> prepared =
      prepared_.plan.prepare_stage(*request_.scene->scene, camera_, options);
  reserve(crop, prepared->job_bytes_per_pixel());
  job = std::move(prepared);
  stage_ = stage;
  stage_name_ = name;
  stage_stop_ = std::stop_source();
  const std::stop_callback with_the_frame(stop_->token(), [this] { stage_stop_.request_stop(); });
  return job->render(*this, stage_stop_.get_token()).counters;
}

// Resolves the first picture, which the buckets then replace one by one.
void ViewFrame::begin_buckets() {
  constexpr uint64_t kDisplayed = 4;
  reserve(crop_, TilePicture::bytes_per_pixel(prepared_.plan) + kDisplayed);
  std::vector<float> rgba(4 * size_t(crop_.area()));
  resolve_frame(rgba);
  live_picture_ = nullptr;
  live_job_ = nullptr;
  first_.reset();
  progress_ = {};
  bucket_picture_.emplace(prepared_.plan, std::move(rgba));
  live_picture_ = &bucket_picture_->picture();
  // Forces a new picture now, since otherwise none may come before a bucket is finished.
  published_at_s_ = -std::numeric_limits<double>::infinity();
}

// A bucket frame's first picture only has to be good enough to judge an edit.
bool ViewFrame::is_first_picture_sufficient() const {
  if (stage_ != Stage::kFirst || prepared_.live || !published_) return false;
  const uint32_t samples = std::max(prepared_.plan.samples_per_pixel, kMinJudgedSamples);
  return progress_.completion >= kFirstPictureFraction * double(samples);
}

// In a bucket frame, the first picture's samples do not count, because buckets replace them.
bool ViewFrame::complete() const {
  const bool counts = stage_ == Stage::kMain || (stage_ == Stage::kFirst && prepared_.live);
  return counts && progress_.completion >= 1.0;
}

void ViewFrame::finish(const RenderCounters& counters) {
  if (counters.stopped && !bucket_picture_) main_->end(stop_->cause());
  finished_ = true;
  // If first_ still exists, time ran out before the main driver had sampled every pixel.
  if (!first_) {
    progress_.samples = counters.samples;
    progress_.rays = counters.rays.total();
    progress_.error_estimate = main_->error_estimate();
  }
  publish_picture();
}

double ViewFrame::seconds() const { return to_seconds(ViewClock::now() - started_ - paused_time_); }

void ViewFrame::picture_changed(const JobProgress& progress, const LivePicture& picture) {
  const bool may_replace = stage_ != Stage::kMain || !first_ || progress.completion >= 1.0;
  bool publishes_now = false;
  if (may_replace) {
    live_picture_ = &picture;
    progress_ = progress;
    live_driver_ = stage_name_;
    live_job_ = stage_ == Stage::kRegion  ? region_.get()
                : stage_ == Stage::kFirst ? first_.get()
                                          : main_.get();
    if (stage_ == Stage::kMain) first_.reset();
    publishes_now = is_picture_due();
    if (publishes_now) publish_picture();
  }
  may_publish_ = may_replace && (published_ || !publishes_now);
  check_time_limit();
  pause_(publishes_now);
  if (is_first_picture_sufficient()) stage_stop_.request_stop();
}

// Everything read here changes only at pauses, except the time and `pause_requested_`.
bool ViewFrame::needs_picture() const {
  if (pause_requested_.load(std::memory_order_relaxed)) return true;
  const double now = seconds();
  return (may_publish_ && is_due_by_time(now)) || is_time_over(now);
}

std::optional<uint64_t> ViewFrame::next_picture_at() const {
  if (published_ || !may_publish_) return std::nullopt;
  return uint64_t(std::ceil(kFirstCoverage * double(crop_.area())));
}

void ViewFrame::tile_begun(const Rect& pixels) {
  const std::unique_lock lock = bucket_picture_->lock();
  bucket_picture_->begin(pixels);
  update_buckets_isolated();
}

void ViewFrame::tile_finished(const FilmTile& tile) {
  const std::shared_ptr<const Grading> grading = publisher_.grading();
  const std::unique_lock lock = bucket_picture_->lock();
  bucket_picture_->finish(tile, grading);
  update_buckets_isolated();
}

// Runs isolated: while a thread waits for TBB to draw the picture, it must not start another
// bucket, which would lock the picture again.
void ViewFrame::update_buckets_isolated() {
  tbb::this_task_arena::isolate([&] { update_buckets(); });
}

void ViewFrame::update_buckets() {
  live_driver_ = stage_name_;
  progress_.pass = 1;
  progress_.samples = bucket_picture_->picture().samples();
  progress_.completion = bucket_picture_->picture().completion();
  const bool publishes_now = stop_->cause() == PixelStop::kNone && is_picture_due();
  if (publishes_now) publish_picture();
  check_time_limit();
  pause_(publishes_now);
}

bool ViewFrame::is_time_over(double now_s) const {
  const std::optional<TimeLimit> limit = time_limit_of(prepared_.options);
  return limit && stage_ == Stage::kMain && now_s >= limit->seconds;
}

void ViewFrame::check_time_limit() {
  if (is_time_over(seconds())) stop_->request(time_limit_of(prepared_.options)->cause);
}

bool ViewFrame::is_picture_due() const {
  if (!published_ && progress_.completion >= kFirstCoverage) return true;
  if (published_ && complete() && !complete_published_) return true;
  return is_due_by_time(seconds());
}

bool ViewFrame::is_due_by_time(double now_s) const {
  if (!published_) return now_s >= kFirstPictureTimeout_s;
  const double share = now_s < kInteractive_s ? kInteractiveCostFraction : kIdleCostFraction;
  return now_s >= published_at_s_ + std::max(kMinInterval_s, cost_s_ / share);
}

void ViewFrame::republish() {
  if (live_picture_) publish_picture();
}

void ViewFrame::set_lights(std::shared_ptr<const LightGroups> groups, std::optional<LightMix> mix) {
  groups_ = std::move(groups);
  mix_ = std::move(mix);
}

void ViewFrame::relight(const RelightRequest& lights) {
  request_.edit = lights.edit;
  request_.posted = lights.posted;
  mix_ = lights.mix;
  publish_picture();
}

void ViewFrame::publish_picture() {
  const ViewClock::time_point begun = ViewClock::now();
  std::shared_ptr<const Grading> grading = publisher_.grading();
  if (!grading) return;
  const std::shared_ptr<SessionPicture> picture = publisher_.acquire_picture();
  const size_t values = 4 * size_t(crop_.area());
  picture->rgba.resize(values);
  picture->rgba8.resize(values);
  resolve_frame(picture->rgba);
  denoise(*picture);
  picture->overlay_legend = draw(grading, *picture);
  if (!picture->raw8.empty()) grading->grade(picture->rgba, crop_.width(), picture->raw8);
  picture->edit = request_.edit;
  picture->x = crop_.x0;
  picture->y = crop_.y0;
  picture->width = crop_.width();
  picture->height = crop_.height();
  picture->complete = complete();
  picture->filled = stage_ != Stage::kRegion;
  picture->finished = finished_;
  picture->in_progress.clear();
  if (bucket_picture_) picture->in_progress = bucket_picture_->in_progress();
  picture->progress = progress_;
  picture->samples = progress_.samples;
  picture->rays = progress_.rays;
  picture->rendering_s = seconds();
  picture->driver = live_driver_;
  const ViewClock::time_point ended = ViewClock::now();
  picture->elapsed_s = to_seconds(ended - request_.posted);
  complete_published_ = complete_published_ || picture->complete;
  publisher_.publish(picture, std::move(grading));
  published_ = true;
  published_at_s_ = seconds();
  cost_s_ = to_seconds(ended - begun);
}

std::string ViewFrame::draw(const std::shared_ptr<const Grading>& grading,
                            SessionPicture& picture) {
  const std::span<uint8_t> rgba8(picture.rgba8);
  const ViewOverlay overlay = display_mode_.load().overlay;
  if (overlay == ViewOverlay::kStop) {
    if (const std::vector<float> reasons = stops(); !reasons.empty()) {
      return draw_stops(reasons, crop_, rgba8);
    }
  }
  if (const HeatmapQuantity* quantity = overlay_quantity(overlay)) {
    // A frame without the channel shows the plain picture; a frame that has it will follow.
    if (!quantity->aov || prepared_.plan.aovs.contains(*quantity->aov)) {
      const FilmCopy film = copy();
      const std::vector<std::string> names = film_channel_names(film.aovs);
      return draw_overlay(*quantity, names, film.channels, crop_, prepared_.options.heatmap_style,
                          rgba8);
    }
  }
  if (const RefinementTree* tree = driver_facts().tree; overlay == ViewOverlay::kTree && tree) {
    draw_tree(*tree, *grading, picture.linear(), crop_.width(), rgba8);
    return "leaves of the refinement tree";
  }
  if (bucket_picture_ && !region_ && !mix_ && picture.denoised.empty()) {
    std::ranges::copy(bucket_picture_->rgba8(grading), rgba8.begin());
  } else {
    grading->grade(picture.linear(), crop_.width(), rgba8);
  }
  return {};
}

DriverFacts ViewFrame::driver_facts() const {
  return live_job_ && live_job_->picture() ? live_job_->facts() : DriverFacts();
}

const LivePicture* ViewFrame::region_picture() const {
  return region_ ? region_->picture() : nullptr;
}

const LivePicture& ViewFrame::picture_of(int x, int y) const {
  const LivePicture* const region = region_picture();
  if (!region || !region->rect().contains(x, y)) return *live_picture_;
  const bool better = !live_picture_->rect().contains(x, y) ||
                      region->sample_count(x, y) > live_picture_->sample_count(x, y);
  return better ? *region : *live_picture_;
}

void ViewFrame::resolve_frame(std::span<float> rgba) const {
  if (stage_ != Stage::kRegion) {
    live_picture_->resolve(rgba, mix_ ? &*mix_ : nullptr);
  } else {
    const std::shared_ptr<const SessionPicture> before = publisher_.picture();
    const bool fits = before && before->rect() == crop_;
    if (fits) {
      std::ranges::copy(before->rgba, rgba.begin());
    } else {
      std::ranges::fill(rgba, 0.0f);
    }
  }
  const LivePicture* const picture = region_picture();
  if (!picture) return;
  const Rect& region = picture->rect();
  std::vector<float> inside(4 * size_t(region.area()));
  picture->resolve(inside, mix_ ? &*mix_ : nullptr);
  for (int y = region.y0; y < region.y1; ++y) {
    for (int x = region.x0; x < region.x1; ++x) {
      if (stage_ != Stage::kRegion && &picture_of(x, y) != picture) continue;
      std::copy_n(&inside[4 * region.index_of(x, y)], 4, &rgba[4 * crop_.index_of(x, y)]);
    }
  }
}

// Filters an incomplete frame on the lattice of pixels that bisection has sampled. Does not filter
// an incomplete frame with a region, because the region is sampled more finely than the lattice.
void ViewFrame::denoise(SessionPicture& picture) {
  const bool possible = LiveDenoiser::has_channels(prepared_.plan.aovs) && stage_ != Stage::kRegion;
  const PixelLattice* lattice = nullptr;
  if (!complete()) {
    lattice = region_ ? nullptr : driver_facts().lattice;
  }
  const DisplayMode as = display_mode_.load();
  const bool filtered = possible && as.filtered() && (lattice || complete());
  // The picture may be a reused picture with old values; resize() keeps its memory.
  picture.denoised.resize(filtered ? picture.rgba.size() : 0);
  picture.raw8.resize(filtered && as.include_raw ? picture.rgba.size() : 0);
  if (!filtered) return;
  const double samples = double(progress_.samples) / double(crop_.area());
  denoiser_.denoise({*live_picture_, region_picture(), lattice, samples, mix_.has_value()},
                    picture.rgba, picture.denoised);
}

// Before the last stage, all pixels count as unfinished.
PixelStop ViewFrame::stop_at(int x, int y) const {
  const bool last = bucket_picture_ || (main_ && live_job_ == main_.get());
  const PixelStop stop = last ? live_picture_->current_stop(x, y) : PixelStop::kUnfinished;
  if (!finished_ || stop != PixelStop::kUnfinished) return stop;
  return picture_of(x, y).sample_count(x, y) > 0 ? stop_->cause() : PixelStop::kNone;
}

std::vector<float> ViewFrame::stops() const {
  if (bucket_picture_ && !prepared_.plan.aovs.contains(Aov::kStop)) return {};
  const auto width = size_t(crop_.width());
  std::vector<float> stops(size_t(crop_.area()));
  parallel_each(size_t(crop_.height()), [&](size_t row) {
    for (size_t i = row * width; i < (row + 1) * width; ++i) {
      stops[i] = float(stop_at(crop_.x_of(i), crop_.y_of(i)));
    }
  });
  return stops;
}

FilmCopy ViewFrame::copy() const {
  FilmCopy result{crop_, prepared_.plan.aovs, {}, stops(), prepared_.options};
  result.options.scene = request_.scene->open->outline.file;
  result.options.driver = live_driver_;
  const size_t count = film_channels(prepared_.plan.aovs).size();
  result.channels.resize(count * size_t(crop_.area()));
  const auto put = [&](const LivePicture& picture) {
    const std::vector<float> values = picture.channels();
    const Rect& rect = picture.rect();
    for (int y = rect.y0; y < rect.y1; ++y) {
      for (int x = rect.x0; x < rect.x1; ++x) {
        if (&picture_of(x, y) != &picture) continue;
        std::copy_n(&values[count * rect.index_of(x, y)], count,
                    &result.channels[count * crop_.index_of(x, y)]);
      }
    }
  };
  put(*live_picture_);
  if (const LivePicture* region = region_picture()) put(*region);
  if (prepared_.plan.aovs.contains(Aov::kStop)) put_stops(result.stops, &result);
  // In a bucket frame, a pixel has no value until its bucket is finished.
  if (bucket_picture_) return result;
  std::vector<float> rgba(4 * size_t(crop_.area()));
  resolve_frame(rgba);
  for (size_t i = 0; i < size_t(crop_.area()); ++i) {
    std::copy_n(&rgba[4 * i], 4, &result.channels[count * i]);
  }
  return result;
}

PixelInspection ViewFrame::inspect_pixel(int x, int y, bool explained) const {
  PixelInspection result;
  result.x = x;
  result.y = y;
  result.edit = request_.edit;
  if (!live_picture_) return result;
  const LivePicture& picture = picture_of(x, y);
  if (!picture.rect().contains(x, y)) return result;
  result.known = true;
  result.samples = picture.sample_count(x, y);
  result.non_finite = picture.non_finite(x, y);
  result.variance = picture.variance(x, y);
  result.stop = stop_at(x, y);
  const bool is_shown = live_job_ && live_job_->picture() == live_picture_;
  if (explained && is_shown && &picture == live_picture_) {
    live_job_->record_pixel(x, y);
    result.explanation = live_job_->explain(x, y);
  }

  const Scene& scene = request_.scene->scene->scene();
  const SceneDescription& outline =
      request_.scene->scene->editable().original();  // in the current pose
  const Ray ray = camera_.ray({float(x) + 0.5f, float(y) + 0.5f});
  SurfaceHit hit;
  if (!scene.intersect(ray, {}, &hit)) return result;
  SurfaceInteraction surface;
  scene.interaction(hit, ray.time, &surface);
  result.id = hit.instance + 1;
  const InstanceDescription& instance = outline.instances[hit.instance];
  result.object =
      instance.name.empty() ? outline.meshes[size_t(instance.mesh)].name : instance.name;
  if (surface.material_index < outline.materials.size()) {
    result.material = int(surface.material_index);
  }
  result.position = to_double(surface.position) / scene.scale() + scene.origin();
  return result;
}

}  // namespace emberline
