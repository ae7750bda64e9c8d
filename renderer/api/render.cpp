// A scene and settings as a picture.
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <iterator>
#include <mutex>
#include <thread>
#include <utility>

#include "renderer/api/frame_files.h"
#include "renderer/api/picture_sink.h"
#include "renderer/api/translated.h"
#include "renderer/core/errors.h"
#include "renderer/drivers/bucket_schedule.h"
#include "renderer/engine/film_memory.h"
#include "renderer/engine/setting_table.h"
#include "renderer/engine/stop_request.h"
#include "renderer/output/frame_extension.h"
#include "renderer/output/frame_memory.h"
#include "renderer/output/light_layers.h"

namespace emberline::api {
namespace {

// Asks for the end when the caller does, or when the time is over.
class EndOfFrame {
 public:
  EndOfFrame(const std::stop_token& stop, const std::stop_token& give_up,
             std::optional<double> limit_s)
      : by_caller_(stop, [this] { request_.request(PixelStop::kUser); }),
        given_up_(give_up, [this] { request_.request(PixelStop::kUser); }) {
    if (!limit_s) return;
    clock_ = std::jthread([this, limit_s](const std::stop_token& over) {
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, over, std::chrono::duration<double>(*limit_s), [] { return false; });
      if (!over.stop_requested()) request_.request(PixelStop::kTimeLimit);
    });
  }
  std::stop_token token() const { return request_.token(); }
  PixelStop cause() const { return request_.cause(); }

 private:
  StopRequest request_;
  std::stop_callback<std::function<void()>> by_caller_, given_up_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::jthread clock_;
};

// Shows a frame on its way.
class WatchedSink final : public PictureSink {
 public:
  WatchedSink(const OutputSettings& settings, const SceneLayers& layers, const EndOfFrame& end,
              RenderJob& job, FrameFiles& files, const std::function<void(const Progress&)>& watch)
      : PictureSink(settings, layers),
        width_(settings.crop.width()),
        height_(settings.crop.height()),
        end_(end),
        job_(job),
        files_(files),
        watch_(watch) {}

  void tile_finished(const FilmTile& tile) override {
    PictureSink::tile_finished(tile);
    if (!watch_ || !job_.by_tiles()) return;
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
    if (files_.wanted()) files_.save(job_);
    if (!watch_) return;
    rgba_.resize(4 * size_t(width_) * size_t(height_));
    picture.resolve(rgba_);
    try {
      watch_({now.samples, now.error_estimate, rgba_.data(), width_, height_});
    } catch (...) {
      files_.save(job_);
      throw;
    }
  }
  void cut_short() override { files_.save(job_); }
  bool picture_wanted() const override { return files_.wanted(); }
  PixelStop stop_cause() const override { return end_.cause(); }

 private:
  const int width_, height_;
  const EndOfFrame& end_;
  RenderJob& job_;
  FrameFiles& files_;
  const std::function<void(const Progress&)>& watch_;
  std::vector<float> rgba_;
  std::atomic<uint64_t> samples_{0};
  std::mutex mutex_;
};

// Reserves what a frame takes until it is a picture.
MemoryReservation reserved(const RenderOptions& options, const OutputSettings& output,
                           const SceneLayers& layers, const RenderPlan& plan, int threads,
                           const LoadLimits& limits) {
  MemoryReservation memory(limits.memory, MemoryPart::kFilm);
  const Rect& crop = output.crop;
  RenderOptions lossless = options;  // nothing is encoded
  lossless.exr_compression = ExrCompression::kZip;
  memory.add(frame_bytes(lossless, output, plan) + PictureSink::bytes(output, layers) +
                 light_group_bytes(lossless, output, plan, layers.lights),
             "a frame of " + std::to_string(crop.width()) + "x" + std::to_string(crop.height()) +
                 " pixels");
  memory.add(bucket_list_bytes(crop, output.tile_size), "the list of its buckets");
  const uint64_t lights =
      options.light_groups ? light_tile_bytes_per_pixel(output.aovs, layers.lights.size()) : 0;
  const BucketsAtWork at_work = buckets_at_work(crop, output.tile_size, threads);
  memory.add(bytes_of(at_work.pixels(), tile_bytes_per_pixel(plan.drivers(), output.aovs) + lights),
             "working on buckets of " + std::to_string(at_work.width) + "x" +
                 std::to_string(at_work.height) + " pixels");
  return memory;
}

// How a frame is watched and ended.
struct Watch {
  const std::stop_token& stop;
  const std::function<void(const Progress&)>& watch;
  const std::stop_token& give_up;
};

// `options` are of this scene: options_of().
Picture render_picture(const Access::SceneState& state, const RenderOptions& options,
                       const Resources& resources, const Watch& watch) {
  const RenderPlan plan(options, {.extending = !options.extended.empty()});
  OutputSettings output = output_settings(options, plan.crop);
  if (is_part(options)) output.denoise = false;  // a part lacks the pixels around its own
  const FrameParts parts(state, options);
  const int threads = arena_threads(resources);
  const MemoryReservation memory =
      reserved(options, output, parts.layers, plan, threads, state.limits);
  const EndOfFrame end(watch.stop, watch.give_up, options.time_limit_s);
  FrameFiles files(options, plan, parts, state, watch.give_up);
  tbb::task_arena arena(threads);
  const emberline::Scene& scene = state.open->scene();
  RenderJob job(
      arena.execute([&] { return plan.frame(scene, parts.camera, parts.of_scene, end.token()); }),
      plan.drivers());
  files.prepare(2 * memory.bytes(), job);
  WatchedSink sink(output, parts.layers, end, job, files, watch.watch);
  const auto check_going = [&] {
    if (watch.give_up.stop_requested()) throw Stopped("the frame was given up");
  };
  RenderResult result;
  Picture picture;
  arena.execute([&] {
    result = job.render(sink, end.token());
    files.rendered(result.counters.stopped, end.cause(), job);
    try {
      check_going();
      job.deliver(sink);
      picture = sink.finish(watch.give_up);
      check_going();
    } catch (...) {
      files.no_picture(result.counters.stopped, job);
      throw;
    }
  });
  const RenderCounters& counters = result.counters;
  files.finish(counters.stopped);
  warn_of_optics(counters.optics);
  picture.samples = counters.samples;
  picture.rays = counters.rays.total();
  picture.non_finite_samples = counters.non_finite_samples;
  picture.error_estimate = job.error_estimate();
  picture.complete = files.is_open() ? !counters.stopped : result.complete;
  return picture;
}

// What an extension takes.
void check_is_more(const FrameSettings& more) {
  constexpr std::string_view kMore[] = {"spp", "noise-threshold", "max-spp", "time-limit"};
  const FrameSettings none;
  for (const Setting& row : setting_table()) {
    if (row.text(more) == row.text(none) || std::ranges::find(kMore, row.name) != std::end(kMore)) {
      continue;
    }
    throw emberline::UsageError(
        "`{}`: extend takes `spp`, `noise-threshold`, `max-spp` and `time-limit`; all else stays "
        "as "
        "the frame has it",
        row.name);
  }
}

}  // namespace

Picture render(const Scene& scene, const Settings& settings, const Resources& resources,
               const std::stop_token& stop, const std::function<void(const Progress&)>& watch,
               const std::stop_token& give_up) {
  return translated([&] {
    check_resources(resources);
    const Access::SceneState& state = Access::of(scene);
    return render_picture(state, options_of(state, Access::of(settings)), resources,
                          {stop, watch, give_up});
  });
}

Picture render(const RenderFiles& files, const Scene& scene, const Settings& settings,
               const Resources& resources, const std::stop_token& stop,
               const std::function<void(const Progress&)>& watch, const std::stop_token& give_up) {
  return translated([&] {
    check_resources(resources);
    if (files.checkpoint.empty()) throw emberline::UsageError("`checkpoint`: no file is named");
    if (!(files.interval_s > 0)) {
      throw emberline::UsageError("`checkpoint-interval`: {} is not a number of seconds",
                                  files.interval_s);
    }
    const Access::SceneState& state = Access::of(scene);
    RenderOptions options = options_of(state, Access::of(settings));
    options.checkpoint = files.checkpoint;
    options.resume = files.resume;
    options.resumable = files.keep;
    options.checkpoint_interval_s = files.interval_s;
    return render_picture(state, options, resources, {stop, watch, give_up});
  });
}

Picture extend(const std::string& checkpoint, const Scene& scene, const Settings& more,
               const Resources& resources, const std::stop_token& stop,
               const std::function<void(const Progress&)>& watch, const std::stop_token& give_up) {
  return translated([&] {
    check_resources(resources);
    check_is_more(Access::of(more));
    FrameSettings settings = settings_in(checkpoint);
    extend_settings(Access::of(more), checkpoint, settings);
    const Access::SceneState& state = Access::of(scene);
    RenderOptions options = options_of(state, settings);
    options.extended = checkpoint;
    options.checkpoint = checkpoint + ".next";
    options.resume = options.resumable = true;
    return render_picture(state, options, resources, {stop, watch, give_up});
  });
}

std::vector<MatteNames> matte_names(const Scene& scene, const Settings& settings) {
  return translated([&] {
    const Access::SceneState& state = Access::of(scene);
    const RenderOptions options = options_of(state, Access::of(settings));
    return names_of(FrameParts(state, options).layers);
  });
}

}  // namespace emberline::api
