// Validates OpenColorIO configs before OpenColorIO follows the references in them.
#pragma once

#include <OpenColorIO/OpenColorIO.h>

#include <string>
#include <vector>

namespace emberline {

// Checks what the config refers to, because OpenColorIO 2 follows any reference. Throws InputError
// at `place` if a space, look, view or named transform refers to itself or expands to more than
// 100,000 transforms. Also throws InputError if a referenced file exists but is not regular or is
// too large. Returns the referenced files that exist.
std::vector<std::string> check_ocio_config(const OCIO_NAMESPACE::ConstConfigRcPtr& config,
                                           const std::string& place);

// Checks a config's text before it is parsed, because nested YAML aliases can make the parsed
// config exponentially large. Throws InputError.
void check_ocio_aliases(const std::string& text, const std::string& place);

}  // namespace emberline
