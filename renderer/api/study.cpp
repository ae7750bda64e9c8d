// Studies of speed against error.
#include <utility>

#include "renderer/api/access.h"
#include "renderer/core/errors.h"
#include "renderer/core/names.h"
#include "renderer/core/option_values.h"
#include "renderer/core/shortened.h"
#include "renderer/statistics/study/files.h"
#include "renderer/statistics/study/study.h"

namespace emberline::api {
namespace {

struct StudyOption {
  std::string_view name;
  void (*read)(StudyOptions& options, const std::string& text);
};

template <auto Member>
void read_text(StudyOptions& options, const std::string& text) {
  options.*Member = text;
}

template <auto Member>
void read_count(StudyOptions& options, const std::string& text) {
  const std::optional<uint32_t> count = parse_number<uint32_t>(text);
  if (!count) throw emberline::UsageError("\"{}\" is not a whole number", shortened(text));
  options.*Member = count;
}

template <auto Member>
void read_switch(StudyOptions& options, const std::string& text) {
  if (text != "yes" && text != "no") {
    throw emberline::UsageError("\"{}\" is neither yes nor no", shortened(text));
  }
  options.*Member = text == "yes";
}

using O = StudyOptions;
constexpr StudyOption kOptions[] = {
    {"drivers", read_text<&O::drivers>},
    {"estimators", read_text<&O::estimators>},
    {"samplers", read_text<&O::samplers>},
    {"spp", read_text<&O::spp>},
    {"seconds", read_text<&O::seconds>},
    {"seeds", read_count<&O::seeds>},
    {"baseline", read_text<&O::baseline>},
    {"denoise", read_switch<&O::denoise>},
    {"separate", read_switch<&O::separate>},
    {"reference", read_text<&O::reference>},
    {"reference-spp", read_count<&O::reference_spp>},
    {"cache", read_text<&O::cache>},
    {"restart", read_switch<&O::restart>},
};

StudyOptions options_of(const std::string& scene, const FrameSettings& settings,
                        const StudyRequest& request, const Resources& resources) {
  StudyOptions options = Access::impl(request);
  if (options.folder.empty()) {
    throw emberline::UsageError("a study needs a folder for its results");
  }
  static_cast<FrameSettings&>(options.frame) = settings;
  options.frame.scene = scene;
  options.frame.threads = arena_threads(resources);
  options.frame.limits = {resources.memory_bytes, resources.load_timeout_s};
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
    for (const StudyCheckpoint& checkpoint : run.checkpoints) {
      StudyRow& measured_row = table.rows.emplace_back(row);
      measured_row.budget = checkpoint.budget;
      measured_row.samples = checkpoint.samples;
      measured_row.mean_samples = checkpoint.mean_samples;
      measured_row.wall_s = checkpoint.wall_s;
      measured_row.cpu_s = checkpoint.cpu_s;
      measured_row.estimate = checkpoint.estimate;
      for (const StudyMetricEntry& metric : study_metric_table()) {
        measured_row.errors.emplace_back(metric.name, checkpoint.error.*metric.value);
      }
      measured_row.errors.emplace_back("signed_bias", checkpoint.error.signed_bias);
    }
  }
  return table;
}

}  // namespace

StudyRequest::StudyRequest(std::string folder) : state_(std::make_unique<State>()) {
  state_->options.folder = std::move(folder);
}
StudyRequest::StudyRequest(const StudyRequest& other)
    : state_(std::make_unique<State>(*other.state_)) {}
StudyRequest::StudyRequest(StudyRequest&& other) noexcept = default;
StudyRequest& StudyRequest::operator=(StudyRequest other) noexcept {
  state_ = std::move(other.state_);
  return *this;
}
StudyRequest::~StudyRequest() = default;

StudyRequest& StudyRequest::set(std::string_view name, std::string_view text) {
  translate_errors([&] {
    const StudyOption& option = find_named(kOptions, "study", "option", name);
    try {
      option.read(state_->options, std::string(text));
    } catch (const emberline::UsageError& error) {
      throw emberline::UsageError("`{}`: {}", name, error.what());
    }
  });
  return *this;
}

StudyTable study(const std::string& scene, const Settings& settings, const StudyRequest& request,
                 const Resources& resources, const std::stop_token& stop,
                 const std::function<void(uint64_t)>& on_samples) {
  return translate_errors([&] {
    check_resources(resources);
    const StudyOptions options = options_of(scene, Access::impl(settings), request, resources);
    const StudyOutcome outcome =
        execute_study(options, "`folder`",
                      [&](uint64_t, const RenderStudy& render) { render(on_samples, stop); });
    if (!outcome.results) {
      throw Stopped(
          "the study was stopped before its reference was finished; the same call continues it");
    }
    if (!outcome.attempts.failed().empty()) {
      throw emberline::RenderError("{}: the file could not be written",
                                   outcome.attempts.failed().front());
    }
    return table_of(*outcome.results);
  });
}

}  // namespace emberline::api
