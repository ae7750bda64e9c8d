#include "renderer/app/command_frame.h"
#include "renderer/app/commands.h"
#include "renderer/core/errors.h"
#include "renderer/output/option_rules.h"
#include "renderer/output/outputs.h"
#include "renderer/output/plan_pilot.h"
#include "renderer/output/sample_plan_file.h"

namespace emberline {

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
  RenderOptions pilot = pilot_of(planned);
  if (pilot.resume) pilot.checkpoint = options.output + ".checkpoint";
  RenderRun run(pilot);
  FileRegister& files = run.names.emplace();
  register_inputs(pilot, files);
  files.write("-o", options.output);
  register_frame_outputs(pilot, files);
  register_run_outputs(pilot, files);
  CommandFrame frame(run, pilot);
  frame.load();
  frame.build();
  frame.resume();
  frame.render();
  const int exit_code = frame.write_plan(planned, options.output);
  run.end(exit_code);
  return exit_code;
}

}  // namespace emberline
