#include "renderer/output/frame_extension.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "renderer/core/errors.h"
#include "renderer/engine/render_plan.h"
#include "renderer/output/checkpoint_head.h"
#include "renderer/output/render_options.h"

namespace emberline {
namespace {

// Replaces the frame's limits by the requested ones, which may only add work.
void set_more(const FrameSettings& more, const std::string& path, FrameSettings& settings) {
  const auto refuse = [&](const char* option, const auto& has) {
    throw UsageError("`{}`: {} already has {}; a frame can only be extended", option, path, has);
  };
  if (!more.spp && !more.noise_threshold && !more.max_spp) {
    throw UsageError("extend needs a new limit: `spp`, `noise-threshold` or `max-spp`");
  }
  const auto raise = [&](const char* option, std::optional<uint32_t> to, uint32_t has) {
    if (!to) return;
    if (has == 0) {
      throw UsageError("`{}`: {} has no such limit; a frame can only be extended", option, path);
    }
    if (*to < has) refuse(option, has);
  };
  const RenderPlan plan(settings);
  raise("spp", more.spp, plan.samples_per_pixel);
  raise("max-spp", more.max_spp, plan.driver_settings.adaptive.max_samples);
  if (more.noise_threshold && settings.noise_threshold &&
      *more.noise_threshold > *settings.noise_threshold) {
    refuse("noise-threshold", *settings.noise_threshold);
  }
  const bool even = shares_evenly(settings);
  if (more.spp) settings.spp = more.spp;
  if (more.noise_threshold) settings.noise_threshold = more.noise_threshold;
  if (more.max_spp) settings.max_spp = more.max_spp;
  settings.time_limit_s = more.time_limit_s;
  if (shares_evenly(settings) == even) return;
  throw UsageError("`noise-threshold`: every pixel of {} has the same number of samples; use `spp`",
                   path);
}

void check_extensible(const FrameSettings& settings, const std::string& path) {
  if (is_part(settings)) throw InputError(path, "it is a part of a frame; merge the parts first");
  const RenderPlan plan(settings);
  if (plan.half_block != RenderPlan::kStreamBlock) {
    throw InputError(path,
                     "its denoising halves are those of a frame with fewer than {} samples a "
                     "pixel; render it again",
                     kLeastStreamSamples);
  }
  if (!shares_evenly(settings)) return;
  const std::vector<std::string_view> valid = extensible_samplers();
  if (std::ranges::find(valid, settings.sampler) != valid.end()) return;
  throw InputError(path,
                   "the samples of its sampler, {}, depend on their total number; uniform frames "
                   "can be extended with {}",
                   settings.sampler, fmt::join(valid, ", "));
}

}  // namespace

FrameSettings stored_settings(const nlohmann::json& head, const std::string& path) {
  FrameSettings settings = settings_of(head, path);
  settings.scene = text_in(head, "files", "scene");
  settings.resource_root = text_in(head, "files", "resource-root");
  settings.environment = text_in(head, "files", "env");
  settings.edits = text_in(head, "files", "edits");
  return settings;
}

void extend_settings(const FrameSettings& more, const std::string& path, FrameSettings& settings) {
  try {
    check_extensible(settings, path);
  } catch (const UsageError& error) {
    throw InputError(path, "its settings are invalid: {}", error.what());
  }
  set_more(more, path, settings);
}

}  // namespace emberline
