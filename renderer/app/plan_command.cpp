#include <algorithm>
#include <cmath>

#include "renderer/app/command_frame.h"
#include "renderer/app/commands.h"
#include "renderer/core/errors.h"
#include "renderer/core/hash.h"
#include "renderer/core/option_values.h"
#include "renderer/output/option_rules.h"
#include "renderer/output/sample_plan_file.h"

namespace emberline {
namespace {

// The pilot, a cheap frame that measures the noise, takes 1 / kPilotFraction of the frame's
// samples, but at least kMinPilotSamples per pixel.
constexpr uint32_t kPilotFraction = 8, kMinPilotSamples = 16;
// Gives the pilot other samples than the frame. The sample counts then do not depend on the frame's
// own samples, so the frame is unbiased (Kirk & Arvo 1991, "Unbiased Sampling Techniques for Image
// Synthesis").
constexpr uint32_t kPilotSeed = 0x9170u;

// Returns the options of the pilot: an adaptive frame whose error estimates decide the sample
// counts.
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

}  // namespace

int run_plan(const PlanOptions& options) {
  RenderOptions planned = options.frame;
  // A settings file may contain these settings. They are ignored, because they limit a run or name
  // the plan that is written here.
  planned.plan.clear();
  planned.time_limit_s.reset();
  planned.time_budget_s.reset();
  planned.part.reset();
  planned.sample_range.reset();
  if (options.output.empty()) throw UsageError("plan needs an output: -o FILE.plan");
  // The rules of the setting `plan` say which frames can be planned. The frame's outputs are not
  // known yet, so an EXR is assumed.
  RenderOptions checked = planned;
  checked.plan = options.output;
  checked.outputs = {"frame.exr"};
  check_options(checked);
  check_plan_output(options.output);
  const RenderOptions pilot = pilot_of(planned);
  RenderRun run(pilot);
  CommandFrame frame(run, pilot);
  frame.load();
  frame.build();
  frame.render();
  const int exit_code = frame.write_plan(planned, options.output);
  run.end(exit_code);
  return exit_code;
}

}  // namespace emberline
