// What this loader makes of each glTF extension. To add one: a row in the table of
// gltf_extensions.cpp, its members in gltf_schema.cpp, and the code that reads it.
#pragma once

#include <string_view>

#include "io/gltf_document.h"
#include "renderer/description/scene_description.h"

namespace emberline {

enum class ExtensionSupport : uint8_t {
  kHonoured,
  kApproximated,  // rendered, but not to the letter, even when required
  kIgnored,
};

struct ExtensionInfo {
  std::string_view name;
  ExtensionSupport support;
  std::string_view remark;  // what is done, or what is missing from the picture
};

// Null for a name that is not in the table (treated as kIgnored).
const ExtensionInfo* find_extension_info(std::string_view name);

// Throws InputError for the first of extensionsRequired that is not honoured.
void check_required_extensions(const GltfDocument& document);

// Sorts extensionsUsed into the report and warns of what has no or another effect.
void report_extensions(const GltfDocument& document, CoverageReport& coverage);

// Adds `text` once and warns of it: "FILE: TEXT has no effect" or the like.
void report_ignored(const std::string& file, const std::string& what, CoverageReport& coverage);
void report_approximated(const std::string& file, const std::string& what,
                         CoverageReport& coverage);

}  // namespace emberline
