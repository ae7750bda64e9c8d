// A study of speed against error, and its rows.
#include <tbb/task_arena.h>

#include "renderer/api/access.h"
#include "renderer/api/translated.h"
#include "renderer/core/errors.h"
#include "renderer/output/outputs.h"
#include "renderer/statistics/study/files.h"
#include "renderer/statistics/study/study.h"

namespace emberline::api {
namespace {

StudyOptions options_of(const std::string& scene, const FrameSettings& settings,
                        const StudyRequest& request, const Resources& resources) {
  if (request.folder.empty()) {
    throw emberline::UsageError("a study needs a folder for its results");
  }
  StudyOptions options;
  static_cast<FrameSettings&>(options.frame) = settings;
  options.frame.scene = scene;
  options.frame.threads = arena_threads(resources);
  options.frame.limits = {resources.memory_bytes, resources.load_timeout_s};
  if (!request.drivers.empty()) options.drivers = request.drivers;
  if (!request.estimators.empty()) options.estimators = request.estimators;
  const auto given = [](const std::string& text) {
    return text.empty() ? std::nullopt : std::optional(text);
  };
  options.samplers = given(request.samplers);
  options.spp = given(request.spp);
  options.seconds = given(request.seconds);
  options.seeds = request.seeds;
  options.baseline = request.baseline;
  options.denoise = request.denoise;
  options.separate = request.separate;
  options.reference = request.reference;
  options.reference_spp = request.reference_spp;
  options.cache = request.cache;
  options.folder = request.folder;
  options.restart = request.restart;
  return options;
}

StudyRow row_of(const StudyMethod& method, const StudyRun& run) {
  StudyRow row;
  row.method = method.name;
  row.driver = method.driver;
  row.sampler = method.sampler;
  row.estimator = method.estimator;
  row.allocation = method.allocation;
  row.unbiased = method.unbiased;
  row.denoised = method.denoised;
  row.seed = run.seed;
  row.failure = run.status == StudyRunStatus::kFailed ? run.reason : "";
  return row;
}

StudyTable table_of(const StudyResults& results) {
  StudyTable table;
  table.complete = results.complete;
  table.text = study_table(results);
  for (const StudyRun& run : results.runs) {
    const StudyRow row = row_of(results.methods[run.method], run);
    if (run.checkpoints.empty()) table.rows.push_back(row);
    for (const StudyCheckpoint& at : run.checkpoints) {
      StudyRow& reached = table.rows.emplace_back(row);
      reached.budget = at.budget;
      reached.samples = at.samples;
      reached.mean_samples = at.mean_samples;
      reached.wall_s = at.wall_s;
      reached.cpu_s = at.cpu_s;
      reached.estimate = at.estimate;
      for (const StudyMetricEntry& metric : study_metric_table()) {
        reached.errors.emplace_back(metric.name, at.error.*metric.value);
      }
      reached.errors.emplace_back("signed_bias", at.error.signed_bias);
    }
  }
  return table;
}

StudyTable run(Study& study, const std::stop_token& stop,
               const std::function<void(uint64_t)>& on_samples) {
  study.prepare();
  study.render(
      on_samples ? on_samples : [](uint64_t) {}, stop);
  if (!study.has_reference()) {
    throw Stopped("the study was stopped before there was a reference; the same call goes on");
  }
  WriteAttempts attempts;
  study.write_results(attempts);
  if (!attempts.failed().empty()) {
    throw emberline::RenderError("{}: it could not be written", attempts.failed().front());
  }
  return table_of(study.results());
}

}  // namespace

StudyTable study(const std::string& scene, const Settings& settings, const StudyRequest& request,
                 const Resources& resources, const std::stop_token& stop,
                 const std::function<void(uint64_t)>& on_samples) {
  return translated([&] {
    check_resources(resources);
    const StudyOptions options = options_of(scene, Access::of(settings), request, resources);
    const StudyPlan plan = plan_study(options);
    FileRegister files;
    files.write_below("`folder`", options.folder);
    register_inputs(options.frame, files);
    if (!options.reference.empty()) {
      files.read(options.reference, "the file of `reference` is in it");
    }
    return tbb::task_arena(options.frame.threads).execute([&] {
      Study study(options, plan, files, options.frame.threads);
      return run(study, stop, on_samples);
    });
  });
}

}  // namespace emberline::api
