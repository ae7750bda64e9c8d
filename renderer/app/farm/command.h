// emberline farm: a frame in parts, as jobs of Slurm. Slurm schedules, watches and restarts them;
// nothing of ours does.
#pragma once

#include <cstdint>
#include <string>

#include "renderer/app/farm/slurm.h"
#include "renderer/output/render_options.h"

namespace emberline {

enum class FarmVerb : uint8_t { kSubmit, kStatus, kCancel, kRetry };

struct FarmOptions {
  FarmVerb verb = FarmVerb::kSubmit;
  RenderOptions frame;
  uint32_t parts = 0;  // 0: not given
  std::string frames = "0";
  SlurmRequest request;
  bool print = false, stage = false;
  std::string output;  // of status, cancel and retry
  bool json = false;
};

// Submits the frame, or looks after one that was submitted. Returns kExitDone. Throws UsageError,
// InputError (scene, job.json) and RenderError (no Slurm, what Slurm refuses, files).
int run_farm(const FarmOptions& options);

}  // namespace emberline
