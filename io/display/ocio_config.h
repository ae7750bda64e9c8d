// OpenColorIO configs, looked at before OpenColorIO follows them.
#pragma once

#include <OpenColorIO/OpenColorIO.h>

#include <string>
#include <vector>

namespace emberline {

// OpenColorIO 2 follows what a config refers to wherever it leads. So this throws InputError at
// `place` where a space, look, view or named transform leads back to itself or comes to more than
// 100,000 transforms, and where a file that one names is there and is no regular file, or too
// large. Returns those that are there.
std::vector<std::string> check_ocio_config(const OCIO_NAMESPACE::ConstConfigRcPtr& config,
                                           const std::string& place);

// A config's text before it is parsed: aliases in aliases grow without end. Throws InputError.
void check_ocio_aliases(const std::string& text, const std::string& place);

}  // namespace emberline
