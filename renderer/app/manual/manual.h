// Man pages.
#pragma once

#include <string>

#include "renderer/app/manual/command_help.h"

namespace emberline {

// man(7) of one command; those below the root have pages of their own, those below them a section.
std::string manual_page(const CommandHelp& command);
// "emberline-render.1"
std::string manual_name(const CommandHelp& command);

}  // namespace emberline
