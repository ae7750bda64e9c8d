// Says how this loader treats each glTF extension. To add an extension, add a row to the table in
// gltf/document/extensions.cpp, add its members to gltf/document/schema.cpp, and write the code
// that reads it.
#pragma once

#include <string_view>

#include "io/gltf/document/document.h"
#include "renderer/description/scene_description.h"

namespace emberline {

bool is_supported(std::string_view extension);

// Throws InputError for the first unsupported extension in extensionsRequired.
void check_required_extensions(const GltfDocument& document);

// Adds extensionsUsed to the report. Warns about extensions that have no effect, with the reason.
void report_extensions(const GltfDocument& document, CoverageReport& coverage);

// If the file has a later minor version than 2.0, reports those members of nodes, meshes and
// materials that this program does not know, and warns about them.
void report_unknown_members(const GltfDocument& document, CoverageReport& coverage);

// These add `what` to the report once, with a warning such as "FILE: ignored: WHAT (WHY)".
void report_ignored(const std::string& file, const std::string& what, CoverageReport& coverage);
void report_approximated(const std::string& file, const std::string& what,
                         CoverageReport& coverage);
// Like report_approximated(), but without the warning.
void note_approximated(const std::string& what, CoverageReport& coverage);

}  // namespace emberline
