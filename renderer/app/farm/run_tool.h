// Runs another program of the system and waits for it: Slurm's commands.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace emberline {

struct ToolResult {
  int exit_code = 0;  // 128 and more: ended by a signal
  std::string out, err;
};

// The words are the program, which is looked for in PATH, and its arguments; no shell reads them.
// Nothing where there is no such program. Throws RenderError where the system starts none.
std::optional<ToolResult> run_tool(const std::vector<std::string>& words);

}  // namespace emberline
