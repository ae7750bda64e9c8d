#include "renderer/statistics/study/renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "renderer/engine/film_memory.h"
#include "renderer/engine/frame_scene.h"
#include "renderer/engine/frame_stop.h"
#include "renderer/engine/render_clock.h"
#include "renderer/engine/render_job.h"
#include "renderer/engine/render_plan.h"
#include "renderer/output/denoise_pass.h"
#include "renderer/output/plan_pilot.h"
#include "renderer/output/report.h"
#include "renderer/output/rgb_file.h"

namespace emberline {
namespace {

constexpr const char* kMotionLayer = "velocity";

void warn_of_counters(const RenderOptions& o, const RenderCounters& counters) {
  const std::string estimator = o.estimator.empty() ? "" : " `estimator` " + o.estimator;
  warn_about_non_finite(counters, o,
                        fmt::format("by render with `driver` {}{} `sampler` {} `seed` {}", o.driver,
                                    estimator, o.sampler, o.seed));
  warn_about_optics(counters.optics);
}

// Returns the options of the pilot of a planned frame.
RenderOptions study_pilot(RenderOptions planned) {
  planned.plan.clear();
  return pilot_of(planned);
}

StudyCheckpoint checkpoint(const Rect& crop, double budget, uint64_t samples, double wall_s,
                           double cpu_s, const std::optional<double>& estimate = {}) {
  return {.budget = budget,
          .samples = samples,
          .mean_samples = double(samples) / double(crop.area()),
          .wall_s = wall_s,
          .cpu_s = cpu_s,
          .error = {},
          .estimate = estimate,
          .filter = {}};
}

// Collects the channels of finished tiles.
class TileCollector : public RenderSink {
 public:
  // `end`, if given, knows why the frame was stopped. If it is null, the user has stopped it.
  TileCollector(const Rect& crop, const AovSet& aovs,
                const std::function<void(uint64_t)>& on_samples, const FrameStop* end = nullptr)
      : crop_(crop), on_samples_(on_samples), end_(end) {
    values_.resize(size_t(crop.area()) * film_channels(aovs).size());
  }
  void tile_finished(const FilmTile& tile) override { put_channels(tile, crop_, values_); }
  void samples_finished(uint64_t count) override {
    if (on_samples_) on_samples_(count);
  }
  PixelStop stop_cause() const override { return end_ ? end_->cause() : PixelStop::kUser; }
  std::vector<float> take_values() { return std::move(values_); }

 protected:
  const Rect crop_;

 private:
  const std::function<void(uint64_t)>& on_samples_;
  const FrameStop* end_;
  std::vector<float> values_;
};

// Copies the picture whenever a budget is spent or a round ends.
class ProgressiveCollector final : public TileCollector {
 public:
  // With uniform sampling (`uniform`) there are no rounds, and therefore no error estimates.
  ProgressiveCollector(const Rect& crop, std::span<const double> budgets, bool by_time,
                       bool uniform, const std::function<void(uint64_t)>& on_samples)
      : TileCollector(crop, {}, on_samples),
        budgets_(budgets),
        by_time_(by_time),
        uniform_(uniform) {}

  void picture_changed(const JobProgress& now, const LivePicture& picture) override {
    const double wall = clock.seconds(), cpu = clock.cpu_seconds();
    clock.exclude_time([&] {
      store_estimate(now);
      collect(now, picture, wall, cpu);
      if (now.pass_finished && !uniform_) {
        round_ = {now.samples, 0, to_rgb_image(rgba(picture), 4, crop_)};
      }
      last_estimate_ = now.error_estimate;
    });
    if (pictures.size() == budgets_.size()) budgets_spent.request_stop();
  }

  bool needs_picture() const override {
    return by_time_ && pictures.size() < collected_count() &&
           clock.seconds() >= budgets_[pictures.size()];
  }
  std::optional<uint64_t> next_picture_at() const override {
    if (by_time_ || pictures.size() >= collected_count()) return std::nullopt;
    return uint64_t(std::ceil(budgets_[pictures.size()] * double(crop_.area())));
  }

  // Stores the error estimate of the last round. A driver computes this estimate only when it plans
  // the next round.
  void store_estimate(const JobProgress& now) {
    if (!round_ || !now.error_estimate || now.error_estimate == last_estimate_) return;
    round_->estimate = *now.error_estimate;
    estimates.push_back(std::move(*round_));
    round_.reset();
  }

  RenderClock clock;
  std::vector<StudyPicture> pictures;
  std::vector<RoundEstimate> estimates;
  std::stop_source budgets_spent;

 private:
  // Returns the number of pictures that this class collects. If the last picture is the finished
  // frame, it is not counted, because render_progressive() adds it.
  size_t collected_count() const {
    return by_time_ && uniform_ ? budgets_.size() : budgets_.size() - 1;
  }

  void collect(const JobProgress& now, const LivePicture& picture, double wall, double cpu) {
    while (pictures.size() < collected_count()) {
      const double budget = budgets_[pictures.size()];
      const double spent_budget = by_time_ ? wall : double(now.samples) / double(crop_.area());
      if (spent_budget < budget) return;
      pictures.push_back({checkpoint(crop_, budget, now.samples, wall, cpu), with_counts(picture)});
    }
  }
  std::vector<float> rgba(const LivePicture& picture) const {
    std::vector<float> values(4 * size_t(crop_.area()));
    picture.resolve(values);
    return values;
  }
  std::vector<float> with_counts(const LivePicture& picture) const {
    const std::vector<float> colours = rgba(picture);
    std::vector<float> values;
    values.reserve(colours.size() / 4 * 5);
    for (size_t i = 0; i < colours.size() / 4; ++i) {
      values.insert(values.end(), &colours[4 * i], &colours[4 * i] + 4);
      values.push_back(float(picture.film().sample_count(crop_.x_of(i), crop_.y_of(i))));
    }
    return values;
  }

  const std::span<const double> budgets_;
  const bool by_time_;
  const bool uniform_;
  std::optional<RoundEstimate> round_;  // the last round, until it has an estimate
  std::optional<double> last_estimate_;
};

}  // namespace

StudyRenderer::StudyRenderer(const RenderOptions& options, bool has_motion,
                             const LoadLimits& limits, FileRegister& files)
    : crop_(crop_of(options)) {
  LoadProgress progress({}, {}, limits);
  RenderOptions frame = options;
  if (has_motion) frame.aovs = kMotionLayer;
  ReadScene read(frame, {}, {.build = RenderPlan(frame).build}, progress);
  files.read(read.description().files, "the scene reads");
  const CameraDescription camera = choose_camera(frame, read.description());
  scene_ = std::move(read).build(progress);
  camera_ = create_camera(frame, camera, scene_->scene());
}

uint64_t StudyRenderer::frame_bytes(const RenderOptions& options, size_t budgets) const {
  const AovSet aovs = aovs_of(options);
  const std::vector<std::string> channels = film_channel_names(aovs);
  const uint64_t floats = channels.size() + budgets * kStudyPictureChannels;
  const uint64_t filter = options.denoise ? denoise_bytes(crop_, kStudyTile, channels) : 0;
  uint64_t job = job_bytes_per_pixel(RenderPlan(options).drivers(), aovs);
  if (!options.plan.empty()) {
    const RenderOptions pilot = study_pilot(options);
    job = std::max(job, job_bytes_per_pixel(RenderPlan(pilot).drivers(), aovs_of(pilot))) +
          sizeof(uint32_t);
  }
  return filter + bytes_of(pixels(), job + floats * sizeof(float));
}

std::optional<StudyPicture> StudyRenderer::render(const RenderOptions& options, const AovSet& aovs,
                                                  const std::stop_token& stop) const {
  const RenderClock clock;
  RenderCounters pilot;
  std::shared_ptr<const SamplePlan> sample_plan;
  if (!options.plan.empty()) {
    sample_plan = plan_samples(options, stop, &pilot);
    if (!sample_plan) return std::nullopt;
  }
  const RenderPlan plan(options, {.aovs = aovs, .sample_plan = sample_plan});
  FrameStop end(stop);
  TileCollector collector(crop_, aovs, on_samples_, &end);
  const std::unique_ptr<RenderJob> job = plan.prepare(*scene_, camera_, end.token());
  end.begin(time_limit_of(options));
  const RenderCounters counters = job->render(collector, end.token()).counters;
  const double wall = clock.seconds(), cpu = clock.cpu_seconds();
  if (counters.stopped) return std::nullopt;
  warn_of_counters(options, counters);
  job->deliver(collector);
  return StudyPicture{
      checkpoint(crop_, 0, pilot.samples + counters.samples, wall, cpu, job->error_estimate()),
      collector.take_values(), pilot.non_finite_samples + counters.non_finite_samples};
}

std::optional<std::vector<float>> StudyRenderer::render_motion(const RenderOptions& frame,
                                                               const std::stop_token& stop) const {
  RenderOptions options = frame;
  options.driver = "bucket";
  options.spp = kMotionSamples;
  options.aovs = kMotionLayer;
  const std::optional<StudyPicture> picture = render(options, aovs_of(options), stop);
  if (!picture) return std::nullopt;
  const size_t stride = kStudyPictureChannels + 2;
  std::vector<float> motion;
  motion.reserve(2 * size_t(pixels()));
  for (size_t i = kStudyPictureChannels; i < picture->values.size(); i += stride) {
    motion.insert(motion.end(), {picture->values[i], picture->values[i + 1]});
  }
  return motion;
}

std::shared_ptr<const SamplePlan> StudyRenderer::plan_samples(const RenderOptions& planned,
                                                              const std::stop_token& stop,
                                                              RenderCounters* counters) const {
  const RenderOptions options = study_pilot(planned);
  const RenderPlan plan(options, {.aovs = AovSet()});
  TileCollector collector(crop_, {}, on_samples_);
  const std::unique_ptr<RenderJob> job = plan.prepare(*scene_, camera_, stop);
  *counters = job->render(collector, stop).counters;
  if (counters->stopped) return nullptr;
  warn_of_counters(options, *counters);
  return std::make_shared<SamplePlan>(planned_samples(*job, planned));
}

ProgressiveFrame StudyRenderer::render_progressive(const RenderOptions& options,
                                                   std::span<const double> budgets, bool by_time,
                                                   const std::stop_token& stop) const {
  const RenderPlan plan(options, {.aovs = AovSet()});
  ProgressiveCollector collector(crop_, budgets, by_time, plan.is_uniform, on_samples_);
  const std::stop_callback pass_on(stop, [&] { collector.budgets_spent.request_stop(); });
  collector.clock = RenderClock();
  const std::unique_ptr<RenderJob> job = plan.prepare(*scene_, camera_, stop);
  const RenderCounters counters =
      job->render(collector, collector.budgets_spent.get_token()).counters;
  const double wall = collector.clock.seconds(), cpu = collector.clock.cpu_seconds();
  ProgressiveFrame result;
  result.stopped = stop.stop_requested();
  if (result.stopped) return result;
  warn_of_counters(options, counters);
  result.non_finite_samples = counters.non_finite_samples;
  result.pictures = std::move(collector.pictures);
  result.estimates = std::move(collector.estimates);
  if (!counters.stopped) {
    job->deliver(collector);
    const std::optional<double> estimate = job->error_estimate();
    const std::vector<float> values = collector.take_values();
    while (result.pictures.size() < budgets.size()) {
      result.pictures.push_back({checkpoint(crop_, budgets[result.pictures.size()],
                                            counters.samples, wall, cpu, estimate),
                                 values});
    }
    if (estimate) {
      result.estimates.push_back(
          {counters.samples, *estimate, to_rgb_image(values, film_channels({}).size(), crop_)});
    }
  }
  return result;
}

void denoise_picture(const Rect& crop, StudyPicture* picture) {
  AovSet aovs;
  aovs.insert(Aov::kDenoising);
  const std::vector<std::string> names = film_channel_names(aovs);
  const size_t results = denoise_results(names).size();
  std::vector<float> denoised(size_t(crop.area()) * kStudyPictureChannels);
  const auto write = [&](const Rect& tile, const std::vector<float>& pixels) {
    const size_t stride = pixels.size() / size_t(tile.area());
    for (size_t i = 0; i < size_t(tile.area()); ++i) {
      const float* pixel = &pixels[i * stride];
      float* to = &denoised[crop.index_of(tile.x_of(i), tile.y_of(i)) * kStudyPictureChannels];
      std::copy_n(pixel, kStudyPictureChannels, to);
      std::copy_n(pixel + stride - results, 3, to);
    }
  };
  const RenderClock clock;
  const DenoiseReport report = denoise_film(crop, kStudyTile, names, picture->values, write);
  const double cpu = clock.cpu_seconds();
  picture->wall_s += clock.seconds();
  picture->cpu_s += cpu;
  picture->filter = {cpu, report.unchanged_fraction};
  picture->estimate = report.error_after;
  picture->values = std::move(denoised);
}

}  // namespace emberline
