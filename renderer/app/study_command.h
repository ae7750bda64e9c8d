// emberline study: speed against error of several ways to render one frame.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "renderer/app/render_options.h"

namespace emberline {

struct StudyOptions {
  // Scene, view, light, integrator, depth, filter, buckets, threads and the first seed; what is
  // compared is in the lists below.
  RenderOptions frame;
  // Lists, separated by commas. An estimator may have its allocation behind it and then `unbiased`:
  // "two-stream/mse", "two-stream/display/unbiased".
  std::string drivers = "bucket,bisection,adaptive";
  std::string estimators = "two-stream";
  std::optional<std::string> samplers;      // sobol; of --convergence all
  std::optional<std::string> spp, seconds;  // budgets; one of them at most
  std::optional<uint32_t> seeds;            // 5; of --convergence 2000
  std::string baseline;                     // a method's name; empty: bucket, or the first
  bool separate = false;                    // a run of its own for every budget
  std::string reference;                    // a picture; empty: one is rendered
  std::optional<uint32_t> reference_spp;
  std::string cache;   // folder of rendered references; empty: in the study's
  std::string folder;  // of the results
  bool restart = false;
  bool convergence = false;  // of the samples alone, without a scene
};

// Renders, measures and writes study.csv, study.json, study.html and pictures into the folder. A
// study that was stopped goes on where it was when the same command is given again.
//
// Returns kExitDone, also where some runs have failed: they are shown as failed; kExitRenderFailed
// if all have; kExitStopped after a signal. Throws UsageError, InputError, RenderError before any
// long work for whatever is wrong with the options.
int run_study(const StudyOptions& options);

}  // namespace emberline
