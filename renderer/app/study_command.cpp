#include "renderer/app/commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "io/files/atomic_file.h"
#include "io/files/input_file.h"
#include "io/files/owned_folder.h"
#include "renderer/app/frame_range.h"
#include "renderer/app/progress.h"
#include "renderer/app/standard_output.h"
#include "renderer/app/stop_signal.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/engine/worker_threads.h"
#include "renderer/output/option_rules.h"
#include "renderer/statistics/study/files.h"
#include "renderer/statistics/study/range.h"
#include "renderer/statistics/study/study.h"

namespace emberline {
namespace {

void run_with_progress(uint64_t samples, const RenderStudy& render) {
  StopRequest stop;
  const GracefulStop graceful;
  ProgressDisplay progress(samples, stop);
  render([&](uint64_t count) { progress.add(count); }, stop.token());
}

StudyOutcome study_frame(const StudyOptions& options) {
  StudyOutcome outcome = execute_study(options, "-o", run_with_progress);
  for (const std::string& path : outcome.attempts.written()) log_info("wrote " + path);
  if (!outcome.results) {
    log_info("stopped before the reference was finished; run the same command to continue");
  }
  return outcome;
}

// Throws RenderError if every run failed.
int exit_code_of(const StudyOutcome& outcome) {
  if (!outcome.results) return kExitStopped;
  if (!outcome.attempts.failed().empty()) return kExitRenderFailed;
  const StudyResults& results = *outcome.results;
  if (!results.complete) return kExitStopped;
  const bool any = std::ranges::any_of(
      results.runs, [](const StudyRun& one) { return one.status == StudyRunStatus::kDone; });
  if (!any) throw RenderError("every run failed; the first error is: " + results.runs[0].reason);
  return kExitDone;
}

int study_single_frame(const StudyOptions& options) {
  const StudyOutcome outcome = study_frame(options);
  if (outcome.results) print_result(study_table(*outcome.results));
  return exit_code_of(outcome);
}

std::string folder_of_frame(int number) { return expand_frame_number("frame.####", number); }

StudyOptions options_of_frame(const StudyOptions& options, int number, const OwnedFolder& folder) {
  StudyOptions one = options;
  one.frame = options_of_frame(options.frame, number);
  one.reference = expand_frame_number(options.reference, number);
  one.folder = folder.path(folder_of_frame(number));
  one.motion = true;
  return one;
}

// Writes what the studies of several frames say together. Returns the exit code.
int write_range(const OwnedFolder& folder, const std::vector<FrameStudy>& studies,
                const std::string& command_line) {
  WriteAttempts attempts;
  const auto write = [&](const char* name, const auto& text) {
    const std::string path = folder.path(name);
    attempts.attempt(path, [&] { write_file_atomically(path, text(studies)); });
  };
  write("range.csv", study_range_csv);
  write("range.json", study_range_json);
  write("range.html", [&](const auto& all) { return study_range_page(all, command_line); });
  for (const std::string& path : attempts.written()) log_info("wrote " + path);
  print_result(study_range_table(studies));
  return attempts.failed().empty() ? kExitDone : kExitRenderFailed;
}

// Throws InputError if a frame has no reference, before anything slow.
void check_references(const StudyOptions& options, const std::vector<int>& frames) {
  if (options.reference.empty()) return;
  for (const int number : frames) InputFile{expand_frame_number(options.reference, number)};
}

// Studies the frames one after another, each in a folder of its own.
int study_frames(const StudyOptions& options, const std::vector<int>& frames) {
  check_references(options, frames);
  OwnedFolderKind kind = {"-o", "emberline-study-range.json", {}, true};
  for (const int number : frames) kind.subfolders.push_back(folder_of_frame(number));
  OwnedFolder folder(options.folder, std::move(kind));
  folder.claim(std::vector<std::string>{"range.csv", "range.json", "range.html"});
  std::vector<FrameStudy> studies;
  int exit_code = kExitDone;
  for (const int number : frames) {
    log_info(fmt::format("frame {} ({} of {})", number, studies.size() + 1, frames.size()));
    const StudyOptions one = options_of_frame(options, number, folder);
    StudyOutcome outcome = study_frame(one);
    exit_code = exit_code_of(outcome);
    if (!outcome.results) break;
    studies.push_back({number, one.folder, *std::move(outcome.results), {}});
    if (exit_code != kExitDone) break;
    FrameStudy* last = studies.size() > 1 ? &studies[studies.size() - 2] : nullptr;
    if (!last || last->frame + 1 != number) continue;
    measure_flicker(*last, studies.back(), limits_of(options.frame.limits, one.folder));
  }
  if (studies.empty()) return exit_code;
  return std::max(exit_code, write_range(folder, studies, options.frame.command_line));
}

}  // namespace

int run_study(const StudyOptions& requested) {
  if (requested.convergence != requested.frame.scene.empty()) {
    throw UsageError(requested.convergence ? "study --convergence takes no scene"
                                           : "study needs a scene: study SCENE -o DIR");
  }
  if (requested.convergence && !requested.frame.frames.empty()) {
    throw UsageError("study --convergence takes no --frames");
  }
  if (requested.folder.empty() && !requested.convergence) {
    throw UsageError("study needs a folder for its results: -o DIR");
  }
  const WorkerThreads workers(requested.frame.threads);
  if (requested.convergence) return run_convergence(requested);
  StudyOptions options = requested;
  options.frame.threads = workers.count();
  check_options(options.frame);
  std::vector<int> frames = requested_frames(options.frame);
  if (frames.empty()) return study_single_frame(options);
  std::ranges::sort(frames);
  return study_frames(options, frames);
}

}  // namespace emberline
