#include "renderer/app/range_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "io/files/atomic_file.h"
#include "io/files/write_attempts.h"
#include "renderer/app/command_frame.h"
#include "renderer/app/failure.h"
#include "renderer/app/frame_range.h"
#include "renderer/app/range_report.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/output/checkpoint.h"
#include "renderer/output/finished_frame.h"
#include "renderer/output/outputs.h"

namespace emberline {
namespace {

// The frames of a range, one after another.
class RangeRun {
 public:
  RangeRun(const RenderOptions& options, const std::vector<int>& frames)
      : options_(options), frames_(frames), run_(options_) {
    options_.frames.clear();  // which would be copied with every frame's options
  }

  // All frames are checked before anything is written: one may write what another reads or writes.
  void check_names() {
    FileRegister& files = run_.names.emplace();
    register_inputs(options_, files);
    register_run_outputs(options_, files);
    for (const int number : frames_) {
      const RenderOptions frame = options_of_frame(options_, number);
      if (is_numbered(options_.reference)) {
        files.read(frame.reference, "it is the file of --reference");
      }
      register_frame_outputs(frame, files);
      const std::string checkpoint = checkpoint_path(frame);
      if (!checkpoint.empty() && !frame.resume) check_checkpoint(checkpoint, false);
    }
  }

  void render() {
    size_t next = 0;
    while (next < frames_.size() && !ends()) {
      run_.place = FramePlace{frames_[next], next + 1, frames_.size()};
      std::optional<FrameOutcome> outcome = render(options_of_frame(options_, frames_[next]));
      if (!outcome) break;
      outcome->frame = frames_[next++];
      report_.frames.push_back(*std::move(outcome));
      run_.next_frame();
    }
    report_.left.assign(frames_.begin() + std::ptrdiff_t(next), frames_.end());
  }

  int report() {
    int exit_code = stopped_ ? kExitStopped : kExitDone;
    for (const FrameOutcome& outcome : report_.frames) {
      exit_code = std::max(exit_code, outcome.exit_code);
    }
    report_.exit_code = exit_code;
    report_.wall_s = wall_.seconds();
    report_.cpu_s = process_cpu_seconds();
    WriteAttempts attempts;
    const std::string& path = options_.range_report;
    const auto write = [&] { write_file_atomically(path, range_report_json(options_, report_)); };
    if (!path.empty() && !attempts.attempt(path, write)) {
      exit_code = std::max<int>(exit_code, kExitRenderFailed);
    }
    log_info(describe(report_));
    run_.end(exit_code);
    return exit_code;
  }

 private:
  bool ends() const {
    if (stopped_ || report_.frames.empty()) return stopped_;
    return options_.stop_on_error && report_.frames.back().fate == FrameFate::kFailed;
  }

  // Nothing for a frame that a signal has come before.
  std::optional<FrameOutcome> render(const RenderOptions& options) {
    FrameOutcome outcome;
    outcome.outputs = options.outputs;
    if (options.skip_existing && is_finished(options)) {
      log_info(run_.place->text() + " is skipped: all its outputs are there");
      outcome.fate = FrameFate::kSkipped;
      return outcome;
    }
    try {
      const std::optional<RenderReport> report = render_frame(run_, options);
      stopped_ = stop_signalled();
      if (!report) return std::nullopt;
      take(*report, outcome);
    } catch (const UnusableScene&) {
      throw;
    } catch (const std::exception& error) {
      // What is wrong with the command line before any frame has rendered is wrong with all of
      // them.
      const Failure failure = failure_of(error);
      if (!rendered_ && failure.exit_code == kExitUsage) throw;
      fail(failure, outcome);
      stopped_ = stop_signalled();
    }
    return outcome;
  }

  void take(const RenderReport& report, FrameOutcome& outcome) {
    rendered_ = true;
    outcome.exit_code = report.exit_code;
    outcome.fate = report.exit_code == kExitDone      ? FrameFate::kDone
                   : report.exit_code == kExitStopped ? FrameFate::kStopped
                                                      : FrameFate::kFailed;
    outcome.failed_outputs = report.failed_outputs;
    outcome.times = report.times;
    outcome.samples = report.counters.samples;
    outcome.rays = report.counters.rays.total();
    if (report.stop_cause == PixelStop::kUser) stopped_ = true;
  }

  void fail(const Failure& failure, FrameOutcome& outcome) const {
    log_error(fmt::format("frame {}: {}", run_.place->frame, failure.message));
    outcome.fate = FrameFate::kFailed;
    outcome.exit_code = failure.exit_code;
    outcome.error = failure.message;
  }

  RenderOptions options_;
  const std::vector<int>& frames_;
  RenderRun run_;
  const Stopwatch wall_;
  bool rendered_ = false;  // some frame
  bool stopped_ = false;   // by the user, or the job's end
  RangeReport report_;
};

}  // namespace

int run_range(const RenderOptions& options, const std::vector<int>& frames) {
  RangeRun range(options, frames);
  range.check_names();
  if (!options.range_report.empty()) check_writable(options.range_report);
  check_output_folders(options, frames.front());
  range.render();
  return range.report();
}

}  // namespace emberline
