#include "renderer/output/frame_extension.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "io/files/record_file.h"
#include "io/json/input.h"
#include "renderer/core/errors.h"
#include "renderer/engine/render_plan.h"
#include "renderer/output/checkpoint_head.h"
#include "renderer/output/render_options.h"

namespace emberline {
namespace {

// Replaces the frame's limits with those in `more`. Throws UsageError if a new limit would stop the
// frame earlier than the present limit.
void raise_limits(const FrameSettings& more, const std::string& path, FrameSettings& settings) {
  const auto reject_lower_limit = [&](const char* option, const auto& current) {
    throw UsageError("`{}`: {} already has {}; extend needs a value that continues the render",
                     option, path, current);
  };
  if (!more.spp && !more.noise_threshold && !more.max_spp) {
    throw UsageError("extend needs a new limit: `spp`, `noise-threshold` or `max-spp`");
  }
  const auto raise = [&](const char* option, std::optional<uint32_t> to, uint32_t current) {
    if (!to) return;
    if (current == 0) {
      throw UsageError("`{}`: {} was rendered without this limit, and extend cannot add one",
                       option, path);
    }
    if (*to < current) reject_lower_limit(option, current);
  };
  const RenderPlan plan(settings);
  raise("spp", more.spp, plan.samples_per_pixel);
  raise("max-spp", more.max_spp, plan.driver_settings.adaptive.max_samples);
  if (more.noise_threshold && settings.noise_threshold &&
      *more.noise_threshold > *settings.noise_threshold) {
    reject_lower_limit("noise-threshold", *settings.noise_threshold);
  }
  const bool is_uniform = samples_uniformly(settings);
  if (more.spp) settings.spp = more.spp;
  if (more.noise_threshold) settings.noise_threshold = more.noise_threshold;
  if (more.max_spp) settings.max_spp = more.max_spp;
  settings.time_limit_s = more.time_limit_s;
  if (samples_uniformly(settings) == is_uniform) return;
  throw UsageError("`noise-threshold`: every pixel of {} has the same number of samples; use `spp`",
                   path);
}

}  // namespace

void check_extensible(const FrameSettings& settings, const std::string& path) {
  if (is_part(settings)) {
    throw InputError(
        path,
        "it is a part of a frame; join all parts with emberline merge and `resumable`, "
        "then extend the merged frame");
  }
  if (!settings.plan.empty()) {
    throw InputError(path,
                     "its sample counts come from a plan; to get more samples, make a plan with "
                     "more and render the frame again");
  }
  if (settings.time_budget_s) {
    throw InputError(path,
                     "its number of samples followed from `time-budget`; to get more samples, "
                     "render the frame again");
  }
  const RenderPlan plan = convert_usage_errors(path, [&] { return RenderPlan(settings); });
  if (plan.half_block != RenderPlan::kStreamBlock) {
    throw InputError(path,
                     "it was rendered with fewer than {} samples per pixel, so its denoising "
                     "halves cannot be extended; render it again",
                     kMinStreamSamples);
  }
  if (!samples_uniformly(settings)) return;
  const std::vector<std::string_view> valid = extensible_samplers();
  if (std::ranges::find(valid, settings.sampler) != valid.end()) return;
  throw InputError(path,
                   "its sampler, {}, needs the number of samples in advance; uniform frames can be "
                   "extended only with the samplers {}",
                   settings.sampler, fmt::join(valid, ", "));
}

FrameSettings stored_settings(const nlohmann::json& head, const std::string& path) {
  FrameSettings settings = settings_of(head, path);
  settings.scene = find_text(head, "files", "scene");
  settings.resource_root = find_text(head, "files", "resource-root");
  settings.environment = find_text(head, "files", "env");
  settings.edits = find_text(head, "files", "edits");
  return settings;
}

void extend_settings(const FrameSettings& more, const std::string& path, FrameSettings& settings) {
  check_extensible(settings, path);
  raise_limits(more, path, settings);
}

std::string checkpoint_beside(const std::string& picture) { return picture + ".checkpoint"; }

std::string extension_obstacle(const std::string& checkpoint, const RecordedSettings& picture) {
  try {
    const RecordFile file(checkpoint);
    const FrameSettings settings = stored_settings(parse_json(file.head(), checkpoint), checkpoint);
    check_extensible(settings, checkpoint);
    const std::vector<std::string> list = picture.changes(settings);
    if (list.empty()) return "";
    return fmt::format("{} belongs to another frame: {}", checkpoint, fmt::join(list, "; "));
  } catch (const EmberlineError& error) {
    return error.what();
  }
}

}  // namespace emberline
