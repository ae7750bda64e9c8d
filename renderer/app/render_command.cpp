#include "renderer/app/commands.h"

#include "renderer/app/command_frame.h"
#include "renderer/app/frame_range.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/output/finished_frame.h"
#include "renderer/output/option_rules.h"

namespace emberline {
namespace {

int replay(const RenderOptions& options) {
  RenderRun run(options);
  CommandFrame frame(run, options);
  frame.load();
  frame.build();
  return frame.replay();
}

int render_single(const RenderOptions& options) {
  RenderRun run(options);
  int exit_code = kExitDone;
  if (options.skip_existing && is_finished(options)) {
    log_info("skipped: " + skip_reason(options));
  } else {
    // render_frame() always returns a report here, because a signal that arrives before the first
    // frame begins to render ends the process.
    exit_code = render_frame(run, options)->exit_code;
  }
  run.end(exit_code);
  return exit_code;
}

}  // namespace

int run_render(const RenderOptions& options) {
  if (options.outputs.empty() && !options.replay) {
    throw UsageError("render needs an output: -o FILE.exr (or .png, .jpg)");
  }
  check_options(options);
  const std::vector<int> frames = requested_frames(options);
  if (options.replay) {
    return replay(frames.empty() ? options : options_of_frame(options, frames.front()));
  }
  if (!frames.empty()) return run_range(options, frames);
  if (options.across > 0)
    throw UsageError("--across needs several frames: --frames or --turntable");
  return render_single(options);
}

}  // namespace emberline
