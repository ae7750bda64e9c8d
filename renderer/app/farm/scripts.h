// The commands of a farm: a part, the merge, and the scripts around them. Whatever stands in the
// names of files is quoted.
#pragma once

#include <string>

#include "renderer/app/farm/folder.h"
#include "renderer/output/render_options.h"

namespace emberline {

struct FarmFrame {
  RenderOptions options;  // absolute paths; outputs and heatmaps with the frame's number
  FarmFolder folder;
  uint32_t parts = 1;
  std::string program;  // this one
};

// One line each. `part` and `parts` go in as they are: "$part", {part}.
std::string part_command(const FarmFrame& frame, const std::string& part, const std::string& parts);
std::string merge_command(const FarmFrame& frame);

// "sh part.sh K"; in a task of Slurm's array K is its number. With `stage` the scene and its files
// are copied to the machine's own scratch folder first, once; where that cannot be, the part reads
// them where they are. Throws InputError for a scene that cannot be read.
std::string part_script(const FarmFrame& frame, bool stage);
std::string merge_script(const FarmFrame& frame);

}  // namespace emberline
