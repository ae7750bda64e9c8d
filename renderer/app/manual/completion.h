// What a shell completes after `emberline`: commands, options, names that an option takes, files by
// their suffix.
#pragma once

#include <string>

#include "renderer/app/manual/command_help.h"

namespace emberline {

// To be sourced; needs bash 4 and no other file.
std::string bash_completion(const CommandHelp& root);
// For a folder of $fpath, as _emberline.
std::string zsh_completion(const CommandHelp& root);

}  // namespace emberline
