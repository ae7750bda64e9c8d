// Measures speed against error of several ways to render one frame: from warm-up to results.
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
  std::optional<StudyResults> results;  // empty: stopped before the reference was rendered
  WriteAttempts attempts = {};
};

// Renders a study's reference, then its runs. `on_samples` is called from any thread. Failed runs
// are recorded as failed; interrupted runs are left for the next start.
using RenderStudy =
    std::function<void(const std::function<void(uint64_t)>& on_samples, std::stop_token stop)>;

// Calls `render` once. `samples` is the number of samples to render, estimated for runs that end by
// time.
using StudyClient = std::function<void(uint64_t samples, const RenderStudy& render)>;

// Runs a study from its options to its files, on `options.frame.threads` threads. `folder` is the
// client's name for the option of the results folder. Throws UsageError, InputError and
// RenderError.
StudyOutcome execute_study(const StudyOptions& options, const std::string& folder,
                           const StudyClient& client);

}  // namespace emberline
