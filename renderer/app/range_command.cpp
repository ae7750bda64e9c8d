#include "renderer/app/commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "io/files/atomic_file.h"
#include "io/files/write_attempts.h"
#include "io/image/input.h"
#include "renderer/app/command_frame.h"
#include "renderer/app/failure.h"
#include "renderer/app/frame_range.h"
#include "renderer/app/range_report.h"
#include "renderer/core/errors.h"
#include "renderer/core/file_suffix.h"
#include "renderer/core/log.h"
#include "renderer/engine/process_usage.h"
#include "renderer/output/checkpoint.h"
#include "renderer/output/finished_frame.h"
#include "renderer/output/outputs.h"
#include "renderer/output/render_options.h"
#include "renderer/output/report_page.h"

namespace emberline {
namespace {

// Renders the frames of a range, one after another.
class RangeRun {
 public:
  // `is_denoised`: whether the finished files have a denoised picture.
  RangeRun(const RenderOptions& options, const std::vector<int>& frames, bool is_denoised)
      : options_(options), frames_(frames), is_denoised_(is_denoised), run_(options_) {
    options_.frames.clear();  // otherwise the list would be copied for every frame
  }

  // Checks all frames before anything is written, because a frame could overwrite a file that
  // another frame reads or writes.
  void check_names() {
    FileRegister& files = run_.names.emplace();
    register_inputs(options_, files);
    register_run_outputs(options_, files);
    for (const int number : frames_) {
      const RenderOptions frame = options_of_frame(options_, number);
      if (has_frame_number(options_.reference)) {
        files.read(frame.reference, "it is the file of --reference");
      }
      register_frame_outputs(frame, files);
      const std::string checkpoint = checkpoint_path(frame);
      if (!checkpoint.empty() && !frame.resume) check_checkpoint(checkpoint, false);
    }
  }

  void render() {
    size_t next = 0;
    while (next < frames_.size() && !should_stop()) {
      run_.frame_position = FramePosition{frames_[next], next + 1, frames_.size()};
      std::optional<FrameOutcome> outcome = render(options_of_frame(options_, frames_[next]));
      if (!outcome) break;
      outcome->frame = frames_[next++];
      report_.frames.push_back(*std::move(outcome));
      run_.next_frame();
    }
    report_.remaining.assign(frames_.begin() + std::ptrdiff_t(next), frames_.end());
  }

  // Denoises the rendered frames and those near them, and replaces their pictures. `options` names
  // no frames yet. An error is logged, so that the range is still reported.
  void denoise(const DenoiseOptions& options) {
    if (stopped_) {
      log_info("the frames are not denoised; repeat the command with --skip-existing");
      return;
    }
    try {
      denoising_ = denoise_changed(options);
    } catch (const std::exception& error) {
      const Failure failure = failure_of(error);
      log_error(failure.message);
      denoising_ = failure.exit_code;
    }
  }

  int report() {
    int exit_code = stopped_ ? kExitStopped : denoising_;
    for (const FrameOutcome& outcome : report_.frames) {
      exit_code = std::max(exit_code, outcome.exit_code);
    }
    report_.exit_code = exit_code;
    report_.wall_s = wall_.seconds();
    report_.cpu_s = process_cpu_seconds();
    WriteAttempts attempts;
    const std::string& path = options_.range_report;
    const auto write = [&] {
      write_file_atomically(path, is_page(path) ? range_report_page(options_, report_, is_denoised_)
                                                : range_report_json(options_, report_));
    };
    if (!path.empty() && !attempts.attempt(path, write)) {
      exit_code = std::max<int>(exit_code, kExitRenderFailed);
    }
    log_info(describe(report_));
    run_.end(exit_code);
    return exit_code;
  }

 private:
  int denoise_changed(DenoiseOptions options) const {
    const std::vector<int> rendered = report_.frames_with_status(FrameStatus::kDone);
    for (const FrameOutcome& outcome : report_.frames) {
      const bool is_changed = std::ranges::any_of(rendered, [&](int frame) {
        return std::abs(int64_t(frame) - outcome.frame) <= options.across;
      });
      const bool is_skipped = outcome.status == FrameStatus::kSkipped;
      if (outcome.status != FrameStatus::kDone && !is_skipped) continue;
      if (is_changed || !is_denoised(expand_frame_number(options.image, outcome.frame))) {
        options.frames.push_back(outcome.frame);
      }
    }
    return options.frames.empty() ? int(kExitDone) : run_denoise(options);
  }

  static bool is_denoised(const std::string& image) {
    return FloatImageRows(image).image().find_channel("denoised.R") >= 0;
  }

  bool should_stop() const {
    if (stopped_ || report_.frames.empty()) return stopped_;
    return options_.stop_on_error && report_.frames.back().status == FrameStatus::kFailed;
  }

  // Returns nullopt if a stop signal arrived before the frame began to render.
  std::optional<FrameOutcome> render(const RenderOptions& options) {
    FrameOutcome outcome;
    outcome.outputs = options.outputs;
    if (options.skip_existing && is_finished(options)) {
      log_info(run_.frame_position->text() + " is skipped: " + skip_reason(options));
      outcome.status = FrameStatus::kSkipped;
      return outcome;
    }
    try {
      const std::optional<RenderReport> report = render_frame(run_, options);
      stopped_ = stop_signalled();
      if (!report) return std::nullopt;
      record_report(*report, outcome);
    } catch (const UnusableScene&) {
      throw;
    } catch (const std::exception& error) {
      // If no frame has been rendered yet, a usage error probably affects all frames.
      const Failure failure = failure_of(error);
      if (!rendered_ && failure.exit_code == kExitUsage) throw;
      record_failure(failure, outcome);
      stopped_ = stop_signalled();
    }
    return outcome;
  }

  void record_report(const RenderReport& report, FrameOutcome& outcome) {
    rendered_ = true;
    outcome.exit_code = report.exit_code;
    outcome.status = report.exit_code == kExitDone      ? FrameStatus::kDone
                     : report.exit_code == kExitStopped ? FrameStatus::kStopped
                                                        : FrameStatus::kFailed;
    outcome.failed_outputs = report.failed_outputs;
    outcome.times = report.times;
    outcome.samples = report.counters.samples;
    outcome.rays = report.counters.rays.total();
    if (report.stop_cause == PixelStop::kUser) stopped_ = true;
  }

  void record_failure(const Failure& failure, FrameOutcome& outcome) const {
    log_error(fmt::format("frame {}: {}", run_.frame_position->frame, failure.message));
    outcome.status = FrameStatus::kFailed;
    outcome.exit_code = failure.exit_code;
    outcome.error = failure.message;
  }

  RenderOptions options_;
  const std::vector<int>& frames_;
  const bool is_denoised_;
  RenderRun run_;
  const Stopwatch wall_;
  bool rendered_ = false;  // whether at least one frame has been rendered
  bool stopped_ = false;   // by the user or the end of the job
  int denoising_ = kExitDone;
  RangeReport report_;
};

// Returns how the range is denoised. Throws UsageError if it cannot be.
DenoiseOptions denoising_of(const RenderOptions& options) {
  const auto exr = std::ranges::find_if(options.outputs, is_exr);
  if (!options.denoise || exr == options.outputs.end() || is_part(options)) {
    throw UsageError("--across requires --denoise and an .exr output, and excludes --part");
  }
  if (has_frame_number(std::filesystem::path(*exr).parent_path().string())) {
    throw UsageError("{}: with --across, only the file's name may have a frame number", *exr);
  }
  return {.image = *exr,
          .outputs = options.outputs,
          .frames = {},
          .across = options.across,
          .in_place = true,
          .display = options.display,
          .threads = options.threads,
          .limits = options.limits};
}

// Returns the noise threshold of single frames with which combined frames meet `threshold` on
// average. It is the same for all frames, so that no bit depends on how a range is split. The first
// and last frames of the range keep more noise, because they have fewer neighbours.
float single_frame_threshold(float threshold, int across) {
  // On average, this share of a neighbour's samples counts, with four neighbours on either side. It
  // is the smallest of eight sequences of tests/bench/denoise_sequences.py (all but `light drops`).
  constexpr float kNeighbourShare = 0.47f;
  return std::min(threshold * std::sqrt(1.0f + 2.0f * kNeighbourShare * float(across)), 1.0f);
}

// The frames are rendered with what denoising reads, and are denoised later.
RenderOptions undenoised(RenderOptions options) {
  options.denoise = false;
  options.aovs += std::string(options.aovs.empty() ? "" : ",") + "denoising,velocity";
  // Of the channels that `judge` names, some are not denoised.
  if (options.noise_threshold && options.judge.empty()) {
    const float combined = *options.noise_threshold;
    options.noise_threshold = single_frame_threshold(combined, options.across);
    log_info(
        fmt::format("single frames are rendered with --noise-threshold {:.3g}, so that "
                    "combined frames have about {:.3g}",
                    *options.noise_threshold, combined));
  }
  return options;
}

}  // namespace

int run_range(const RenderOptions& options, const std::vector<int>& frames) {
  std::optional<DenoiseOptions> denoising;
  if (options.across > 0) denoising = denoising_of(options);
  RangeRun range(denoising ? undenoised(options) : options, frames, options.denoise);
  range.check_names();
  if (!options.range_report.empty()) check_writable(options.range_report);
  check_output_folders(options, frames.front());
  range.render();
  if (denoising) range.denoise(*denoising);
  return range.report();
}

}  // namespace emberline
