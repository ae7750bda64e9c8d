// Makes the commands and scripts that render the parts of a frame and merge them. File names in
// them are quoted.
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

// These functions return a command of one line. `part` and `parts` are inserted unquoted, so
// they may be shell text such as "$part".
std::string part_command(const FarmFrame& frame, const std::string& part, const std::string& parts);
std::string plan_command(const FarmFrame& frame);
std::string merge_command(const FarmFrame& frame);

// Return the contents of plan.sh, part.sh and merge.sh. "sh part.sh K" renders part K; in a task of
// a Slurm array, K is the number of the task. With `stage`, part.sh first copies the scene and its
// files to the machine's scratch folder, unless a copy is already there. If this fails, the part
// reads the original files. part_script() throws InputError for a scene that cannot be read.
std::string plan_script(const FarmFrame& frame);
std::string part_script(const FarmFrame& frame, bool stage);
std::string merge_script(const FarmFrame& frame);

}  // namespace emberline
