// From the sampling options of the command line to what driver, sampler and frame are told; and
// which combinations make no sense.
#pragma once

#include "renderer/app/render_options.h"
#include "renderer/drivers/adaptive/round_planner.h"
#include "renderer/drivers/driver_table.h"
#include "samplers/sampler.h"

namespace emberline {

struct SamplingPlan {
  uint32_t samples_per_pixel = 0;  // of every pixel, or on average; 0: until the threshold is met
  StreamCount streams = StreamCount::kOne;
  AdaptiveSettings adaptive;
  bool uniform = true;  // every pixel gets samples_per_pixel
};

// Throws UsageError that names the option, the reason and what is valid.
SamplingPlan plan_sampling(const RenderOptions& options);

// What FrameRender is told.
DriverSettings driver_settings(const RenderOptions& options, const SamplingPlan& plan);

}  // namespace emberline
