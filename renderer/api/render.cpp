// Renders frames of a scene.
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <iterator>
#include <mutex>
#include <nlohmann/json.hpp>
#include <utility>

#include "renderer/api/frame_parts.h"
#include "renderer/api/picture_sink.h"
#include "renderer/core/errors.h"
#include "renderer/engine/frame_stop.h"
#include "renderer/engine/render_plan.h"
#include "renderer/engine/setting_table.h"
#include "renderer/output/checkpoint_head.h"
#include "renderer/output/frame_checkpoint.h"
#include "renderer/output/frame_extension.h"
#include "renderer/output/frame_memory.h"
#include "renderer/output/sample_plan_file.h"

namespace emberline::api {
namespace {

// Collects a frame's tiles, reports progress and saves checkpoints.
class ProgressSink final : public PictureSink {
 public:
  ProgressSink(const OutputSettings& settings, const SceneLayers& layers, const FrameStop& end,
               RenderJob& job, FrameCheckpoint& checkpoint,
               const std::function<void(const Progress&)>& watch)
      : PictureSink(settings, layers),
        width_(settings.crop.width()),
        height_(settings.crop.height()),
        end_(end),
        job_(job),
        checkpoint_(checkpoint),
        watch_(watch) {}

  void tile_finished(const FilmTile& tile) override {
    PictureSink::tile_finished(tile);
    if (!watch_ || !job_.is_tiled()) return;
    const std::lock_guard lock(mutex_);
    watch_({samples_, std::nullopt, nullptr, width_, height_});
  }
  void tile_loaded(const FilmTile& tile, uint64_t samples) override {
    samples_ += samples;
    tile_finished(tile);
  }
  void samples_loaded(uint64_t count) override { samples_ += count; }
  void samples_finished(uint64_t count) override { samples_ += count; }
  void picture_changed(const JobProgress& now, const LivePicture& picture) override {
    if (checkpoint_.is_due()) checkpoint_.save(job_);
    if (!watch_) return;
    rgba_.resize(4 * size_t(width_) * size_t(height_));
    picture.resolve(rgba_);
    try {
      watch_({now.samples, now.error_estimate, rgba_.data(), width_, height_});
    } catch (...) {
      checkpoint_.save(job_);
      throw;
    }
  }
  void interrupted() override { checkpoint_.save(job_); }
  bool needs_picture() const override { return checkpoint_.is_due(); }
  PixelStop stop_cause() const override { return end_.cause(); }

 private:
  const int width_, height_;
  const FrameStop& end_;
  RenderJob& job_;
  FrameCheckpoint& checkpoint_;
  const std::function<void(const Progress&)>& watch_;
  std::vector<float> rgba_;
  std::atomic<uint64_t> samples_{0};
  std::mutex mutex_;
};

// Reserves the memory that a frame needs until its picture is finished. Throws InputError if the
// frame exceeds the memory budget. It is not a UsageError, because the budget belongs to the scene
// and not to the frame's settings.
MemoryReservation reserve_memory(const RenderOptions& options, const OutputSettings& output,
                                 const SceneLayers& layers, const RenderPlan& plan, int threads,
                                 const LoadLimits& limits) {
  MemoryReservation memory(limits.memory, MemoryPart::kFilm);
  RenderOptions lossless = options;  // no file is written, so lossy compression needs no memory
  lossless.exr_compression = ExrCompression::kZip;
  try {
    reserve_frame(lossless, output, plan, threads, memory);
    if (options.light_groups) {
      reserve_lights(lossless, output, plan, layers.lights, threads, memory);
    }
    reserve_pixels(PictureSink::bytes(output, layers), output.crop, memory);
  } catch (const emberline::UsageError& error) {
    throw InputError(error.what());
  }
  return memory;
}

// Checks `sample_plan` and opens the checkpoint, if they exist. Reads the scene's files again for
// their fingerprints. Throws the errors of these steps, and Cancelled after `give_up`.
void open_checkpoint(const RenderOptions& options, const RenderPlan& plan,
                     const std::optional<SamplePlanFile>& sample_plan, const SceneLayers& layers,
                     const Access::SceneState& scene, uint64_t max_bytes,
                     const std::stop_token& give_up, RenderJob& job, FrameCheckpoint& checkpoint) {
  if (options.checkpoint.empty() && !sample_plan) return;
  LoadProgress progress({}, give_up, scene.limits);
  nlohmann::json inputs = scene.files.fingerprints(options, progress);
  if (scene.edited && !scene.edited->empty()) inputs["the program's edits"] = *scene.edited;
  if (const std::string pose = pose_override(scene, options); !pose.empty()) {
    inputs["the program's pose"] = pose;
  }
  const nlohmann::json head = checkpoint_head(options, plan, layers, inputs);
  if (sample_plan) sample_plan->check(head);
  if (!options.checkpoint.empty()) checkpoint.open(head, false, {}, max_bytes, job);
}

struct RenderCallbacks {
  const std::stop_token& stop;
  const std::function<void(const Progress&)>& watch;
  const std::stop_token& give_up;
};

// Returns the picture of a job that has ended. Throws Stopped if the frame was given up.
Picture picture_of(RenderJob& job, ProgressSink& sink, const std::stop_token& give_up) {
  const auto check_abandoned = [&] {
    if (give_up.stop_requested()) throw Stopped("the render was abandoned");
  };
  check_abandoned();
  job.deliver(sink);
  Picture picture = sink.finish(give_up);
  check_abandoned();
  return picture;
}

// `options` must come from options_of() for this scene.
RenderedPicture render_picture(const Access::SceneState& state, const RenderOptions& options,
                               const Resources& resources, const RenderCallbacks& watch) {
  std::optional<SamplePlanFile> sample_plan;
  if (!options.plan.empty()) sample_plan.emplace(options, state.limits);
  const RenderPlan plan(options, {.is_extension = !options.extended.empty(),
                                  .sample_plan = sample_plan ? sample_plan->plan() : nullptr});
  OutputSettings output = output_settings(options, plan.crop);
  if (is_part(options)) output.denoise = false;  // needs pixels outside the part
  const FrameParts parts(state, options);
  const int threads = arena_threads(resources);
  const MemoryReservation memory =
      reserve_memory(options, output, parts.layers, plan, threads, state.limits);
  FrameStop end(watch.stop, watch.give_up);
  tbb::task_arena arena(threads);
  const std::unique_ptr<RenderJob> prepared = arena.execute(
      [&] { return plan.prepare(*state.open, parts.camera, parts.scene_parts, end.token()); });
  RenderJob& job = *prepared;
  FrameCheckpoint checkpoint(options);
  open_checkpoint(options, plan, sample_plan, parts.layers, state, 2 * memory.bytes(),
                  watch.give_up, job, checkpoint);
  ProgressSink sink(output, parts.layers, end, job, checkpoint, watch.watch);
  RenderResult result;
  Picture picture;
  arena.execute([&] {
    end.begin(time_limit_of(options));
    result = job.render(sink, end.token());
    checkpoint.save_if_retained(result.counters.stopped, end.cause(), job);
    try {
      picture = picture_of(job, sink, watch.give_up);
    } catch (...) {
      checkpoint.save_if_unwritten(result.counters.stopped, job);
      throw;
    }
  });
  const RenderCounters& counters = result.counters;
  const CheckpointReport saved = checkpoint.finish(counters.stopped, true, job);
  if (is_part(options) && !saved.error.empty()) throw RenderError(saved.error);
  checkpoint.log_failure(saved);
  return rendered_picture(std::move(picture), output, parts.layers, counters, job.error_estimate(),
                          checkpoint.is_open() ? !counters.stopped : result.complete);
}

// Rejects settings that extend() does not accept.
void check_extend_settings(const FrameSettings& more) {
  constexpr std::string_view kExtendSettings[] = {"spp", "noise-threshold", "max-spp",
                                                  "time-limit"};
  const FrameSettings none;
  for (const Setting& row : setting_table()) {
    if (row.text(more) == row.text(none) ||
        std::ranges::find(kExtendSettings, row.name) != std::end(kExtendSettings)) {
      continue;
    }
    throw emberline::UsageError(
        "`{}`: extend accepts only `spp`, `noise-threshold`, `max-spp` and `time-limit`; other "
        "settings cannot change",
        row.name);
  }
}

}  // namespace

Picture render(const Scene& scene, const Settings& settings, const Resources& resources,
               const std::stop_token& stop, const std::function<void(const Progress&)>& watch,
               const std::stop_token& give_up) {
  return render(RenderFiles::none(), scene, settings, resources, stop, watch, give_up);
}

RenderedPicture render(const RenderFiles& files, const Scene& scene, const Settings& settings,
                       const Resources& resources, const std::stop_token& stop,
                       const std::function<void(const Progress&)>& watch,
                       const std::stop_token& give_up) {
  return translate_errors([&] {
    check_resources(resources);
    if (!(files.interval_s > 0)) {
      throw emberline::UsageError("`checkpoint-interval`: {} is not a positive number of seconds",
                                  files.interval_s);
    }
    const Access::SceneState& state = Access::impl(scene);
    RenderOptions options = options_of(state, Access::impl(settings));
    options.checkpoint = files.checkpoint;
    options.resume = files.resume;
    options.resumable = files.keep;
    options.checkpoint_interval_s = files.interval_s;
    return render_picture(state, options, resources, {stop, watch, give_up});
  });
}

RenderedPicture extend(const std::string& checkpoint, const Scene& scene, const Settings& more,
                       const Resources& resources, const std::stop_token& stop,
                       const std::function<void(const Progress&)>& watch,
                       const std::stop_token& give_up) {
  return translate_errors([&] {
    check_resources(resources);
    check_extend_settings(Access::impl(more));
    FrameSettings settings = settings_in(checkpoint);
    extend_settings(Access::impl(more), checkpoint, settings);
    const Access::SceneState& state = Access::impl(scene);
    RenderOptions options = options_of(state, settings);
    options.extended = checkpoint;
    options.checkpoint = checkpoint + ".next";
    options.resume = options.resumable = true;
    return render_picture(state, options, resources, {stop, watch, give_up});
  });
}

std::vector<MatteNames> matte_names(const Scene& scene, const Settings& settings) {
  return translate_errors([&] {
    const Access::SceneState& state = Access::impl(scene);
    const RenderOptions options = options_of(state, Access::impl(settings));
    return names_of(FrameParts(state, options).layers);
  });
}

}  // namespace emberline::api
