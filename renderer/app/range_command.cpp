#include "renderer/app/commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <unordered_set>
#include <utility>
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

// Returns the noise threshold of single frames with which combined frames meet `threshold` on
// average. It is the same for all frames, so that no bit depends on how a range is split. The first
// and last frames of the range keep more noise, because they have fewer neighbours.
float single_frame_threshold(float threshold, int across) {
  // On average, this share of a neighbour's samples counts, with four neighbours on either side. It
  // is the smallest of eight sequences of tests/bench/denoise_sequences.py (all but `light drops`).
  constexpr float kNeighbourShare = 0.47f;
  return std::min(threshold * std::sqrt(1.0f + 2.0f * kNeighbourShare * float(across)), 1.0f);
}

// With `across`, a frame is rendered with what denoising reads, and is denoised once its neighbours
// are rendered.
RenderOptions undenoised(RenderOptions options) {
  options.denoise = false;
  options.aovs += std::string(options.aovs.empty() ? "" : ",") + "denoising,specular_velocity";
  // Some of the channels that `judge` names are not denoised.
  if (options.noise_threshold && options.judge.empty()) {
    options.noise_threshold = single_frame_threshold(*options.noise_threshold, options.across);
  }
  return options;
}

// Denoises the frames of a range, each as soon as its neighbours in the range have been rendered.
class RangeDenoiser {
 public:
  // `options` names no frames yet.
  RangeDenoiser(DenoiseOptions options, const std::vector<int>& frames)
      : options_(std::move(options)), unrendered_(frames.begin(), frames.end()) {}

  // Call after each frame.
  void add(const FrameOutcome& outcome) {
    unrendered_.erase(outcome.frame);
    if (outcome.status == FrameStatus::kDone) rendered_.insert(outcome.frame);
    if (outcome.status == FrameStatus::kDone || outcome.status == FrameStatus::kSkipped) {
      waiting_.push_back(outcome.frame);
    }
    denoise_ready();
  }

  // Denoises the frames that still wait for a neighbour. Returns the exit code of all calls.
  int finish() {
    unrendered_.clear();
    denoise_ready();
    return exit_code_;
  }

  bool is_waiting() const { return !waiting_.empty(); }

 private:
  void denoise_ready() {
    std::erase_if(waiting_, [this](int frame) {
      if (has_near(unrendered_, frame)) return false;
      denoise(frame);
      return true;
    });
  }

  bool has_near(const std::unordered_set<int>& numbers, int frame) const {
    for (int64_t near = frame - options_.across; near <= frame + options_.across; ++near) {
      if (numbers.contains(int(near))) return true;
    }
    return false;
  }

  // Replaces the frame's pictures, unless nothing has changed since they were denoised. Logs an
  // error, so that the other frames are still rendered.
  void denoise(int frame) {
    options_.frames = {frame};
    try {
      const std::string image = expand_frame_number(options_.image, frame);
      if (!has_near(rendered_, frame) && is_denoised(image)) return;
      exit_code_ = std::max(exit_code_, run_denoise(options_));
    } catch (const std::exception& error) {
      const Failure failure = failure_of(error);
      log_error(failure.message);
      exit_code_ = std::max(exit_code_, failure.exit_code);
    }
  }

  static bool is_denoised(const std::string& image) {
    return FloatImageRows(image).image().find_channel("denoised.R") >= 0;
  }

  DenoiseOptions options_;
  std::unordered_set<int> unrendered_, rendered_;
  std::vector<int> waiting_;
  int exit_code_ = kExitDone;
};

// Renders the frames of a range, one after another.
class RangeRun {
 public:
  // `denoising` is set if the frames are denoised across frames.
  RangeRun(const RenderOptions& options, const std::vector<int>& frames,
           std::optional<DenoiseOptions> denoising)
      : options_(options), frames_(frames), run_(options_) {
    options_.frames.clear();  // otherwise the list would be copied for every frame
    if (denoising) denoiser_.emplace(*std::move(denoising), frames);
  }

  // Checks all frames before anything is written, because a frame could overwrite a file that
  // another frame reads or writes.
  void check_names() {
    FileRegister& files = run_.names.emplace();
    register_inputs(options_, files);
    register_run_outputs(options_, files);
    for (const int number : frames_) {
      const RenderOptions frame = frame_options(number);
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
      std::optional<FrameOutcome> outcome = render(frame_options(frames_[next]));
      if (!outcome) break;
      outcome->frame = frames_[next++];
      if (denoiser_ && !stopped_) denoiser_->add(*outcome);
      report_.frames.push_back(*std::move(outcome));
      run_.next_frame();
    }
    report_.remaining.assign(frames_.begin() + std::ptrdiff_t(next), frames_.end());
    if (!denoiser_) return;
    if (!stopped_) {
      denoising_ = denoiser_->finish();
    } else if (denoiser_->is_waiting()) {
      log_info("the last frames are not denoised; repeat the command with --skip-existing");
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
      write_file_atomically(path, is_page(path) ? range_report_page(options_, report_)
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
  RenderOptions frame_options(int number) const {
    RenderOptions frame = options_of_frame(options_, number);
    return options_.across > 0 ? undenoised(std::move(frame)) : frame;
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
  RenderRun run_;
  const Stopwatch wall_;
  bool rendered_ = false;  // whether at least one frame has been rendered
  bool stopped_ = false;   // by the user or the end of the job
  std::optional<RangeDenoiser> denoiser_;
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

}  // namespace

int run_range(const RenderOptions& options, const std::vector<int>& frames) {
  std::optional<DenoiseOptions> denoising;
  if (options.across > 0) denoising = denoising_of(options);
  RangeRun range(options, frames, denoising);
  range.check_names();
  if (denoising && options.noise_threshold && options.judge.empty()) {
    log_info(
        fmt::format("single frames are rendered with --noise-threshold {:.3g}, so that "
                    "combined frames have about {:.3g}",
                    *undenoised(options).noise_threshold, *options.noise_threshold));
  }
  if (!options.range_report.empty()) check_writable(options.range_report);
  check_output_folders(options, frames.front());
  range.render();
  return range.report();
}

}  // namespace emberline
