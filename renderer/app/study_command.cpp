#include "renderer/app/commands.h"

#include <algorithm>

#include "renderer/app/progress.h"
#include "renderer/app/standard_output.h"
#include "renderer/app/stop_signal.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/engine/worker_threads.h"
#include "renderer/statistics/study/files.h"
#include "renderer/statistics/study/study.h"

namespace emberline {
namespace {

void run_with_progress(uint64_t samples, const RenderStudy& render) {
  StopRequest stop;
  const GracefulStop graceful;
  ProgressDisplay progress(samples, stop);
  render([&](uint64_t count) { progress.add(count); }, stop.token());
}

}  // namespace

int run_study(const StudyOptions& requested) {
  if (requested.convergence != requested.frame.scene.empty()) {
    throw UsageError(requested.convergence ? "study --convergence takes no scene"
                                           : "study needs a scene: study SCENE -o DIR");
  }
  if (requested.folder.empty() && !requested.convergence) {
    throw UsageError("study needs a folder for its results: -o DIR");
  }
  const WorkerThreads workers(requested.frame.threads);
  if (requested.convergence) return run_convergence(requested);
  StudyOptions options = requested;
  options.frame.threads = workers.count();
  const StudyOutcome outcome = execute_study(options, "-o", run_with_progress);
  if (!outcome.results) {
    log_info("stopped before the reference was finished; run the same command to continue");
    return kExitStopped;
  }
  for (const std::string& path : outcome.attempts.written()) log_info("wrote " + path);
  const StudyResults& results = *outcome.results;
  print_result(study_table(results));
  if (!outcome.attempts.failed().empty()) return kExitRenderFailed;
  if (!results.complete) return kExitStopped;
  const bool any = std::ranges::any_of(
      results.runs, [](const StudyRun& one) { return one.status == StudyRunStatus::kDone; });
  if (!any) throw RenderError("every run failed; the first error is: " + results.runs[0].reason);
  return kExitDone;
}

}  // namespace emberline
