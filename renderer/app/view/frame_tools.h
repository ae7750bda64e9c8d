// What a session's frames need beside scene and camera, made anew only when the settings change.
#pragma once

#include <memory>
#include <string>

#include "integrators/integrator.h"
#include "renderer/app/sampling_plan.h"
#include "renderer/app/view/view_settings.h"
#include "renderer/film/filter.h"
#include "samplers/sampler.h"

namespace emberline {

// The options that a window's settings come to: those of the driver that does the main work, with
// a budget that lasts as long as somebody looks. `live` stands for adaptive here.
RenderOptions main_options(const ViewSettings& settings);

// The channels that the settings ask for, the overlay's included.
AovSet wanted_aovs(const ViewSettings& settings);

// Whether a frame rendered by the settings `a` has the samples and, among others, the channels that
// the settings `b` ask for.
bool frames_serve(const ViewSettings& a, const ViewSettings& b);

struct FrameTools {
  // Throws UsageError for settings that make no sense.
  explicit FrameTools(const ViewSettings& settings);

  RenderOptions options;
  bool live;
  bool light_groups;  // asked for, and possible
  SamplingPlan plan;
  DriverSettings drivers;
  AovSet aovs;
  std::unique_ptr<Integrator> integrator;
  std::unique_ptr<Sampler> sampler;
  PixelFilter filter;
};

}  // namespace emberline
