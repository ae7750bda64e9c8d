// Measures speed against error for several ways to render one frame. Runs the whole study, from
// warm-up to results.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "io/files/write_attempts.h"
#include "renderer/statistics/study/options.h"
#include "renderer/statistics/study_results.h"

namespace emberline {

// The result of a study.
struct StudyOutcome {
  std::optional<StudyResults> results;  // empty if stopped before the reference was complete
  WriteAttempts attempts = {};
};

// Renders the reference of a study, then the study's runs. Any thread may call `on_samples`. If a
// run fails, the results say so. If a run is interrupted, a resumed study repeats it.
using RenderStudy =
    std::function<void(const std::function<void(uint64_t)>& on_samples, std::stop_token stop)>;

// The client must call `render` once. `samples` is the number of samples that `render` will take;
// for runs that end by time, it is an estimate.
using StudyClient = std::function<void(uint64_t samples, const RenderStudy& render)>;

// Runs a study on `options.frame.threads` threads and writes its files. `folder` is the client's
// name for the option that sets the results folder. Throws UsageError, InputError and RenderError.
StudyOutcome execute_study(const StudyOptions& options, const std::string& folder,
                           const StudyClient& client);

}  // namespace emberline
