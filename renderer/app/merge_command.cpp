#include "renderer/app/commands.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <optional>

#include "io/files/register.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/readable.h"
#include "renderer/engine/render_clock.h"
#include "renderer/engine/worker_threads.h"
#include "renderer/output/checkpoint_head.h"
#include "renderer/output/frame_merge.h"
#include "renderer/output/merged_checkpoint.h"
#include "renderer/output/outputs.h"
#include "renderer/output/report.h"

namespace emberline {
namespace {

// Combines the frame's settings with this run's outputs.
RenderOptions merged_options(const MergeOptions& merge, const FrameMerge& frame) {
  RenderOptions options = merge.frame;
  static_cast<FrameSettings&>(options) = frame.settings();
  for (const HeatmapRequest& heatmap : heatmap_requests(options)) {
    const std::optional<Aov> aov = heatmap.quantity->aov;
    if (!aov || *aov == Aov::kPart || frame.first().plan().aovs.contains(*aov)) continue;
    throw UsageError("--heatmap-of {}: the parts do not have it; render them with --aov {}",
                     heatmap.quantity->name, name_of(aov_table(), *aov));
  }
  return options;
}

// Fills in the report. Call after FrameMerge::deliver().
void describe_merge(const FrameMerge& frame, const RenderOptions& options, RenderReport& report) {
  report.counters = frame.counters();
  report.unsampled_pixels = frame.unsampled_pixels();
  report.complete = frame.complete();
  report.light_layers = frame.first().layers().lights;
  report.crop = frame.first().plan().crop;
  report.error_estimate = frame.error_estimate();
  if (!frame.first().plan().is_uniform) report.estimator = options.estimator;
  report.passes.push_back({0, report.counters.samples, report.error_estimate});
  for (const auto& part : frame.frames()) {
    report.parts.push_back({part->path(), find_text(part->head(), "machine", "host"),
                            find_text(part->head(), "machine", "instruction sets")});
  }
}

}  // namespace

int run_merge(const MergeOptions& merge) {
  if (merge.frame.outputs.empty())
    throw UsageError("merge needs an output: -o FILE.exr (or .png, .jpg)");
  const Stopwatch clock;
  raise_open_file_limit();  // every part stays open
  const WorkerThreads workers(merge.frame.threads);
  const LoadLimits limits = limits_of(merge.frame.limits, merge.parts.front());
  FrameMerge frame(merge.parts, merge.allow_holes, merge.strict, *limits.memory);
  RenderOptions options = merged_options(merge, frame);
  const Rect& crop = frame.first().plan().crop;
  FileRegister files;
  for (const std::string& part : merge.parts) files.read(part, "it is one of the parts");
  check_output_paths(options, crop, files);
  for (const std::string& path : options.reports) check_writable(path);
  options.scene = find_text(frame.first().head(), "files", "scene");

  const StopRequest stop;
  const OutputSettings settings = output_settings(options, crop);
  frame.reserve(options, settings, workers.count(), *limits.memory);
  FrameOutputs outputs(options.outputs, settings, stop);
  outputs.add_scene(frame.first().layers());
  std::optional<MergedCheckpoint> checkpoint;
  SaveTile save;
  if (options.resumable) {
    checkpoint.emplace(options, frame);
    save = std::bind_front(&MergedCheckpoint::save, &*checkpoint);
  }
  tbb::task_arena arena(workers.count());
  RenderReport report;
  arena.execute([&] {
    frame.deliver(settings.aovs, outputs, save);
    report.denoise = outputs.finish_spooled();
  });

  report.cryptomattes = outputs.cryptomattes();
  describe_merge(frame, options, report);
  report.threads = workers.count();
  report.budget = limits.memory;
  WriteAttempts attempts;
  outputs.finish({frame.complete(), report.counters.samples, report.counters.clamped.fraction()},
                 attempts);
  if (checkpoint) attempts.attempt(checkpoint->path(), [&] { checkpoint->commit(); });
  warn_about_non_finite(report.counters, options);
  warn_about_optics(report.counters.optics);
  report.failed_outputs = attempts.failed();
  report.exit_code = attempts.failed().empty() ? kExitDone : kExitRenderFailed;
  report.warnings = warnings_so_far();
  report.times.wall_s = report.times.write_s = clock.seconds();
  for (const std::string& path : options.reports) {
    attempts.attempt(path, [&] { write_file_atomically(path, report_json(options, report)); });
  }
  log_info(fmt::format("merged {} parts, {} samples, in {}", merge.parts.size(),
                       report.counters.samples, readable_seconds(clock.seconds())));
  if (report.denoise) log_info(describe(*report.denoise));
  for (const std::string& path : attempts.written()) log_info("wrote " + path);
  return attempts.failed().empty() ? kExitDone : kExitRenderFailed;
}

}  // namespace emberline
