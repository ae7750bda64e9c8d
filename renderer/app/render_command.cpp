#include "renderer/app/render_command.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <optional>

#include "io/atomic_file.h"
#include "renderer/app/frame_memory.h"
#include "renderer/app/frame_setup.h"
#include "renderer/app/light_layers.h"
#include "renderer/app/outputs.h"
#include "renderer/app/progress.h"
#include "renderer/app/refinement_output.h"
#include "renderer/app/remote_viewer.h"
#include "renderer/app/render_clock.h"
#include "renderer/app/replay.h"
#include "renderer/app/report.h"
#include "renderer/app/report_page.h"
#include "renderer/app/report_pictures.h"
#include "renderer/app/snapshots.h"
#include "renderer/app/standard_output.h"
#include "renderer/app/stop_signal.h"
#include "renderer/app/worker_threads.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/names.h"
#include "renderer/drivers/frame_plan.h"
#include "renderer/film/light_group_sums.h"
#include "renderer/scene/build_scene.h"

namespace emberline {
namespace {

void warn_of_non_finite(const RenderOptions& options, const FrameCounters& counters) {
  if (counters.non_finite_samples == 0) return;
  const NonFiniteSample& first = counters.located.front();
  log_warning(
      fmt::format("{} samples were NaN or infinite and count as black; the first is replayed "
                  "with --replay {}",
                  counters.non_finite_samples, replay_words(first, options.seed)));
}

void summarize(const RenderOptions& options, const RenderReport& report,
               const std::vector<std::string>& written) {
  const FrameCounters& c = report.counters;
  const double seconds = report.times.render_s;
  log_info(fmt::format("{} {} samples in {} ({:.2f} M samples/s, {:.2f} M rays/s), {:.0f} MiB",
                       c.stopped ? "stopped after" : "rendered", c.samples,
                       format_duration(seconds),
                       seconds > 0 ? double(c.samples) / seconds * 1e-6 : 0.0,
                       seconds > 0 ? double(c.rays.total()) / seconds * 1e-6 : 0.0,
                       double(peak_rss_bytes()) / 1048576));
  for (const std::string& path : written) log_info("wrote " + path);
  const auto snapshots = std::ranges::count_if(
      report.snapshots, [](const SnapshotReport& snapshot) { return !snapshot.file.empty(); });
  if (snapshots > 0)
    log_info(fmt::format("wrote {} snapshots to {}", snapshots, options.snapshots));
  for (const std::string& feature : report.features) log_verbose("built: " + feature);
}

// With the channels that the heatmaps need.
OutputSettings settings_of_outputs(const RenderOptions& options, const Rect& window) {
  OutputSettings settings{options.width,
                          options.height,
                          window,
                          options.bucket_size,
                          AovSet::parse(options.aovs),
                          settings_attributes(options),
                          options.display,
                          options.transparent,
                          heatmap_requests(options),
                          options.heatmap_style};
  for (const HeatmapRequest& heatmap : settings.heatmaps) {
    if (heatmap.quantity->aov) settings.aovs.insert(*heatmap.quantity->aov);
  }
  return settings;
}

// A time limit ends a frame as --spp does, but where the driver finishes it part by part: then
// parts of it have nothing.
bool is_complete(const FrameRender& rendered, const FrameCounters& counters,
                 const StopRequest& stop) {
  if (!counters.stopped) return true;
  return stop.cause() == PixelStop::kTimeLimit && !rendered.by_tiles();
}

// Renders while progress is shown, passes are noted, snapshots taken and a viewer kept informed.
FrameCounters render_frame(const RenderOptions& options, const Frame& frame,
                           FrameRender& frame_render, FrameOutputs& outputs,
                           SnapshotRecorder* snapshots, RemoteViewer* viewer, StopRequest& stop,
                           const Stopwatch& wall, RenderClock& render, RenderReport* report) {
  const auto pixels = double(frame.window.area());
  ProgressDisplay progress(uint64_t(frame.window.area()) * frame.samples_per_pixel, stop,
                           options.time_limit_s);
  std::atomic<bool> begun{false};
  outputs.on_samples([&](uint64_t count) {
    if (!begun.load(std::memory_order_relaxed) && !begun.exchange(true)) {
      report->times.first_sample_s = process_age_seconds().value_or(wall.seconds());
      report->times.first_sample_cpu_s = process_cpu_seconds();
    }
    progress.add(count);
  });
  // Buckets are finished one by one, so their pixels tell how far a threshold's frame has come.
  if (frame_render.by_tiles()) {
    outputs.on_pixels([&](int64_t finished) { progress.add_share(double(finished) / pixels); });
  }
  outputs.on_picture([&](const FrameProgress& now, const FramePicture& picture) {
    const double elapsed = render.seconds();
    // A driver looks at a finished pass when it plans the next one: what it estimates now is the
    // error of the picture at the end of the last pass.
    if (!report->passes.empty()) report->passes.back().error_estimate = now.error_estimate;
    if (now.pass_finished) report->passes.push_back({elapsed, now.samples, std::nullopt});
    if (snapshots) render.leave_out([&] { snapshots->look(now, picture, elapsed); });
    if (viewer) viewer->look(picture, elapsed);
  });
  if (snapshots || viewer) {
    const auto wanted = [=, &render] {
      const double elapsed = render.seconds();
      return (snapshots && snapshots->wanted(elapsed)) || (viewer && viewer->wanted(elapsed));
    };
    outputs.on_wanted(wanted, [=]() -> std::optional<uint64_t> {
      return snapshots ? snapshots->wanted_at() : std::nullopt;
    });
  }
  const FrameCounters counters = frame_render.render(frame, outputs, stop.token());
  outputs.on_samples({});
  outputs.on_pixels({});
  outputs.on_picture({});
  outputs.on_wanted({}, {});
  return counters;
}

}  // namespace

int run_render(const RenderOptions& options) {
  RenderReport report;
  const uint64_t memory_before = peak_rss_bytes();
  report.times.start_s = process_age_seconds();
  const Stopwatch wall;

  // Whatever names or ranges are wrong is found before anything is loaded or written.
  FramePlan plan(options);
  plan.driver_settings.explained = options.explained;
  plan.driver_settings.keep_tree = !options.trees.empty();
  FrameRender frame_render(options.driver, plan.driver_settings);
  const Rect& window = plan.window;
  const OutputSettings output_settings = settings_of_outputs(options, window);
  plan.aovs = output_settings.aovs;
  FileRegister files;
  check_output_paths(options, window, files);
  check_refinement_options(options, plan);
  check_light_layers(options);
  const WorkerThreads workers(options.threads);
  const int threads = workers.count();

  const LoadLimits limits = limits_of(options.limits, options.scene);
  if (!options.replay) {
    reserve_frame(frame_bytes(options, output_settings, frame_render), window, *limits.memory);
  }

  LoadProgress progress({}, {}, limits);
  // Likewise where nothing can be written: the files are opened before the scene is loaded, and
  // leave no trace if that fails.
  StopRequest stop;
  std::optional<SnapshotRecorder> snapshots;
  std::optional<FrameOutputs> outputs;
  std::optional<ReportPictures> pictures;
  if (!options.replay) {
    for (const std::string& path : options.reports) check_writable(path);
    if (std::ranges::any_of(options.reports, is_page)) {
      pictures.emplace(options.display, window, output_settings.aovs);
    }
    for (const std::string& path : options.trees) check_writable(path);
    if (!options.snapshots.empty()) snapshots.emplace(options, window, progress);
    outputs.emplace(options.outputs, output_settings, stop);
  }

  report.window = window;
  report.threads = threads;
  report.times.setup_s = wall.seconds();
  const Stopwatch load;
  SceneEdits edits = load_edits(options, progress);
  SceneDescription description = load_scene(options, progress, edits.variant.has_value());
  if (!edits.environment.file.empty()) {
    files.read(edits.environment.file, "it is the environment of --edits");
  }
  files.read(description.files, "the scene reads");
  choose_variant(options, description, edits);
  if (edits != SceneEdits() || options.light_groups) apply(edits, description);
  report.times.load_s = load.seconds();
  const CameraDescription camera_description = choose_camera(options, description, edits);
  report.camera = camera_description.name;
  report.coverage = description.coverage;
  report.repairs = description.repairs;

  std::optional<LightGroups> groups;
  if (options.light_groups) groups.emplace(outline(description));
  const Stopwatch build;
  const std::unique_ptr<Scene> scene = build_scene(std::move(description), plan.build, progress);
  const Camera camera = create_camera(options, camera_description, *scene);
  report.times.build_s = build.seconds();
  report.features = scene->features();
  report.memory = scene->memory();
  report.budget = limits.memory;
  check_growth(memory_before, *limits.memory, options.scene);
  if (groups) {
    if (!frame_render.by_tiles()) {
      const uint64_t bytes = LightGroupSums::bytes_per_pixel(groups->list().size());
      reserve_frame(bytes_of(uint64_t(window.area()), bytes), window, *limits.memory);
    }
    report.features.push_back(describe(*groups));
    if (outputs) outputs->add_light_layers(light_layer_names(groups->list()));
  }
  log_verbose(fmt::format(
      "loaded in {}, built in {}: {} triangles, {} instances", format_duration(report.times.load_s),
      format_duration(report.times.build_s), scene->triangle_count(), scene->instance_count()));

  const Frame frame = plan.frame(*scene, camera, groups ? &*groups : nullptr);
  if (options.replay) return run_replay(frame, *options.replay);

  std::optional<RemoteViewer> viewer;
  if (options.viewer) viewer.emplace(options, window, threads);
  if (pictures || viewer) {
    outputs->on_tile([&](const FilmTile& tile) {
      if (pictures) pictures->add(tile);
      if (viewer) viewer->add(tile);
    });
  }
  report.display = outputs->display_description();
  const GracefulStop graceful;
  // An arena of its own: the limit above cannot give more threads than the machine has cores.
  tbb::task_arena arena(threads);
  RenderClock render;
  arena.execute([&] {
    report.counters =
        render_frame(options, frame, frame_render, *outputs, snapshots ? &*snapshots : nullptr,
                     viewer ? &*viewer : nullptr, stop, wall, render, &report);
  });
  report.times.render_s = render.seconds();
  report.times.snapshots_s = render.left_out_seconds();
  report.times.render_cpu_s = render.cpu_seconds();
  if (report.passes.empty() || report.passes.back().samples < report.counters.samples) {
    report.passes.push_back({report.times.render_s, report.counters.samples, std::nullopt});
  }

  const Stopwatch write;
  WriteAttempts attempts, snapshot_attempts;
  outputs->rendering_ended();
  arena.execute([&] { frame_render.deliver(*outputs); });
  outputs->finish({is_complete(frame_render, report.counters, stop), report.counters.samples},
                  attempts);
  write_refinement(options, frame_render, attempts);
  if (viewer) viewer->finish(stop.cause());
  report.estimator = plan.even ? "none" : std::string(plan.driver_settings.adaptive.estimator);
  report.error_estimate = frame_render.error_estimate();
  report.passes.back().error_estimate = report.error_estimate;
  report.times.write_s = write.seconds();
  report.film_bytes = outputs->film_bytes() + frame_render.film_bytes() +
                      (pictures ? pictures->bytes() : 0) + (viewer ? viewer->bytes() : 0);
  if (snapshots) {
    const Stopwatch encode;
    arena.execute([&] { report.snapshots = snapshots->write(snapshot_attempts); });
    report.times.snapshots_s += encode.seconds();
  }
  report.stop_cause = stop.cause();
  const bool by_user = report.counters.stopped && stop.cause() == PixelStop::kUser;
  report.failed_outputs = attempts.failed();
  report.failed_outputs.insert(report.failed_outputs.end(), snapshot_attempts.failed().begin(),
                               snapshot_attempts.failed().end());
  report.exit_code = !report.failed_outputs.empty() ? kExitRenderFailed
                     : by_user                      ? kExitStopped
                                                    : kExitDone;
  report.times.wall_s = wall.seconds();
  report.times.cpu_s = process_cpu_seconds();
  warn_of_non_finite(options, report.counters);
  report.warnings = warnings_so_far();
  for (const std::string& path : options.reports) {
    const bool written = attempts.attempt(path, [&] {
      write_file_atomically(path, is_page(path) ? report_page(options, report, *pictures)
                                                : report_json(options, report));
    });
    if (!written) report.exit_code = kExitRenderFailed;
  }
  summarize(options, report, attempts.written());
  if (options.explained) {
    const auto& adaptive = dynamic_cast<const AdaptiveDriver&>(*frame_render.driver());
    print_result(adaptive.explain(frame_render.film(), options.explained->x, options.explained->y));
  }
  return report.exit_code;
}

}  // namespace emberline
