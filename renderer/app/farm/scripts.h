// The commands and scripts that render the parts of a farm and merge them. File names are quoted.
#pragma once

#include <string>

#include "renderer/app/farm/folder.h"
#include "renderer/output/render_options.h"

namespace emberline {

struct FarmFrame {
  RenderOptions options;  // absolute paths; outputs and heatmaps have the frame's number
  FarmFolder folder;
  uint32_t parts = 1;
  std::string program;  // path of this executable
};

// Each function returns a command of one line. `part` and `parts` are inserted unquoted, so they
// may be shell text such as "$part".
std::string part_command(const FarmFrame& frame, const std::string& part, const std::string& parts);
std::string merge_command(const FarmFrame& frame);

// Runs as "sh part.sh K"; in a task of a Slurm array, K is the task's number. With `stage`, the
// scene and its files are first copied once to the machine's scratch folder; if that fails, the
// part reads the originals. Throws InputError for a scene that cannot be read.
std::string part_script(const FarmFrame& frame, bool stage);
std::string merge_script(const FarmFrame& frame);

}  // namespace emberline
