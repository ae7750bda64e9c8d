#include "renderer/output/plan_pilot.h"

#include <algorithm>
#include <cmath>

#include "renderer/core/errors.h"
#include "renderer/core/hash.h"
#include "renderer/core/option_values.h"
#include "renderer/engine/render_plan.h"

namespace emberline {
namespace {

// The pilot takes 1 / kPilotFraction of the frame's samples, but at least kMinPilotSamples per
// pixel.
constexpr uint32_t kPilotFraction = 8, kMinPilotSamples = 16;
// Gives the pilot other samples than the frame. The sample counts then do not depend on the frame's
// own samples, so the frame is unbiased (Kirk & Arvo 1991, "Unbiased Sampling Techniques for Image
// Synthesis").
constexpr uint32_t kPilotSeed = 0x9170u;

}  // namespace

RenderOptions pilot_of(const RenderOptions& planned) {
  RenderOptions pilot = planned;
  pilot.seed = hash_combine(planned.seed, kPilotSeed);
  pilot.min_spp.reset();
  if (const uint32_t budget = RenderPlan(planned).samples_per_pixel; budget > 0) {
    pilot.spp = std::min(budget, std::max(kMinPilotSamples, budget / kPilotFraction));
  }
  // The variance of a mean is inversely proportional to the number of samples.
  const float scale = std::sqrt(float(kPilotFraction));
  if (planned.noise_threshold) pilot.noise_threshold = *planned.noise_threshold * scale;
  // The pilot needs only the layers that `judge` names.
  std::vector<JudgedChannel> judged = judged_channels_of(planned);
  pilot.denoise = pilot.light_groups = false;
  pilot.aovs.clear();
  for (JudgedChannel& channel : judged) {
    channel.threshold *= scale;
    pilot.light_groups |= channel.name == "light.*";
    const std::vector<std::string_view> aovs = split_list(planned.aovs);
    if (std::ranges::find(aovs, channel.name) != aovs.end()) {
      pilot.aovs += (pilot.aovs.empty() ? "" : ",") + channel.name;
    }
  }
  set_judged_channels(judged, pilot);
  pilot.cryptomattes.clear();
  pilot.half.clear();
  return pilot;
}

SamplePlan planned_samples(const RenderJob& pilot, const RenderOptions& planned) {
  RenderOptions limits = planned;
  limits.plan.clear();  // with a plan, RenderPlan has no adaptive settings
  const RenderPlan plan(limits);
  SamplePlan samples{plan.crop, pilot.planned_counts(plan.driver_settings.adaptive)};
  if (samples.counts.empty()) throw RenderError("the pilot has no error estimates");
  return samples;
}

}  // namespace emberline
