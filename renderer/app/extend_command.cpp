#include "renderer/app/commands.h"

#include <nlohmann/json.hpp>

#include "io/files/record_file.h"
#include "io/json/input.h"
#include "renderer/core/errors.h"
#include "renderer/output/frame_extension.h"

namespace emberline {
namespace {

constexpr std::string_view kCheckpointSuffix = ".checkpoint";

}  // namespace

int run_extend(const ExtendOptions& options) {
  const std::string checkpoint =
      is_record_file(options.frame) ? options.frame : checkpoint_beside(options.frame);
  const RecordFile file(checkpoint);
  const nlohmann::json head = parse_json(file.head(), checkpoint);

  RenderOptions render = options.overrides;
  static_cast<FrameSettings&>(render) = stored_settings(head, checkpoint);
  extend_settings(options.overrides, checkpoint, render);
  if (!options.scene.empty()) render.scene = options.scene;
  if (render.outputs.empty()) {
    if (!checkpoint.ends_with(kCheckpointSuffix)) {
      throw UsageError("extend needs an output: the name of {} does not contain it; use -o FILE",
                       checkpoint);
    }
    render.outputs = {checkpoint.substr(0, checkpoint.size() - kCheckpointSuffix.size())};
  }
  render.extended = checkpoint;
  render.checkpoint = checkpoint + ".next";
  render.resumable = render.resume = true;
  return run_render(render);
}

}  // namespace emberline
