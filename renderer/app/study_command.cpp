#include "renderer/app/study_command.h"

#include <tbb/task_arena.h>

#include <algorithm>

#include "renderer/app/convergence_command.h"
#include "renderer/app/progress.h"
#include "renderer/app/standard_output.h"
#include "renderer/app/stop_signal.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/engine/worker_threads.h"
#include "renderer/output/outputs.h"
#include "renderer/statistics/study/files.h"
#include "renderer/statistics/study/study.h"

namespace emberline {
namespace {

int run(Study& study) {
  study.prepare();
  StopRequest stop;
  {
    const GracefulStop graceful;
    ProgressDisplay progress(study.samples_to_come(), stop);
    study.render([&](uint64_t count) { progress.add(count); }, stop.token());
  }
  if (!study.has_reference()) {
    log_info("stopped before there was a reference; the same command goes on");
    return kExitStopped;
  }
  WriteAttempts attempts;
  study.write_results(attempts);
  for (const std::string& path : attempts.written()) log_info("wrote " + path);
  const StudyResults& results = study.results();
  print_result(study_table(results));
  if (!attempts.failed().empty()) return kExitRenderFailed;
  if (!results.complete) return kExitStopped;
  const bool any = std::ranges::any_of(
      results.runs, [](const StudyRun& one) { return one.status == StudyRunStatus::kDone; });
  if (!any) throw RenderError("every run has failed; the first: " + results.runs[0].reason);
  return kExitDone;
}

}  // namespace

int run_study(const StudyOptions& given) {
  if (given.convergence != given.frame.scene.empty()) {
    throw UsageError(given.convergence ? "study --convergence needs no scene, but one is given"
                                       : "study needs a scene: study SCENE -o DIR");
  }
  if (given.folder.empty() && !given.convergence) {
    throw UsageError("study needs a folder for its results: -o DIR");
  }
  const WorkerThreads workers(given.frame.threads);
  if (given.convergence) return run_convergence(given);
  StudyOptions options = given;
  const int threads = options.frame.threads = workers.count();
  const StudyPlan plan = plan_study(options);
  FileRegister files;
  files.write_below("-o", options.folder);
  register_inputs(options.frame, files);
  if (!options.reference.empty()) files.read(options.reference, "the file of --reference is in it");
  tbb::task_arena arena(threads);
  return arena.execute([&] {
    Study study(options, plan, files, threads);
    return run(study);
  });
}

}  // namespace emberline
