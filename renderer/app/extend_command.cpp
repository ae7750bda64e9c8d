#include "renderer/app/commands.h"

#include <nlohmann/json.hpp>

#include "io/files/input_file.h"
#include "io/files/record_file.h"
#include "io/image/file_completeness.h"
#include "io/json/input.h"
#include "renderer/core/errors.h"
#include "renderer/core/shell_quote.h"
#include "renderer/output/frame_extension.h"

namespace emberline {
namespace {

constexpr std::string_view kCheckpointSuffix = ".checkpoint";

// Throws an InputError that says how to keep the checkpoint. It quotes the command in the header of
// the EXR, if there is one.
[[noreturn]] void reject_missing(const std::string& frame, const std::string& checkpoint) {
  if (!InputFile::try_open(frame)) throw InputError(frame, "file not found");
  std::string command = "emberline render ... -o " + shell_quoted(frame);
  for (const auto& [name, text] : exr_texts(frame, "emberline:command")) {
    // Of all commands, only these two can keep a checkpoint.
    if (text.starts_with("emberline render ") || text.starts_with("emberline merge ")) {
      command = text;
    }
  }
  throw InputError(
      checkpoint,
      "file not found, so the frame cannot be extended; to keep a checkpoint, use: {} --resumable",
      command);
}

}  // namespace

int run_extend(const ExtendOptions& options) {
  const std::string checkpoint =
      is_record_file(options.frame) ? options.frame : checkpoint_beside(options.frame);
  if (!InputFile::try_open(checkpoint)) reject_missing(options.frame, checkpoint);
  const RecordFile file(checkpoint);
  const nlohmann::json head = parse_json(file.head(), checkpoint);

  RenderOptions render = options.overrides;
  static_cast<FrameSettings&>(render) = stored_settings(head, checkpoint);
  extend_settings(options.overrides, checkpoint, render);
  if (!options.scene.empty()) render.scene = options.scene;
  if (render.outputs.empty()) {
    if (!checkpoint.ends_with(kCheckpointSuffix)) {
      throw UsageError(
          "extend needs an output, because the name of {} does not say where the picture is; use "
          "-o FILE",
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
