// How this loader treats each glTF extension. To add one: a row in the table of
// gltf/document/extensions.cpp, its members in gltf/document/schema.cpp, and the code that reads
// it.
#pragma once

#include <string_view>

#include "io/gltf/document/document.h"
#include "renderer/description/scene_description.h"

namespace emberline {

// Whether the extension is supported.
bool is_supported(std::string_view extension);

// Throws InputError for the first unsupported extension in extensionsRequired.
void check_required_extensions(const GltfDocument& document);

// Adds extensionsUsed to the report and warns about those without effect, with the reason.
void report_extensions(const GltfDocument& document, CoverageReport& coverage);

// For a file of a later minor version: reports, with a warning, members of nodes, meshes and
// materials that this version does not know.
void report_unknown_members(const GltfDocument& document, CoverageReport& coverage);

// Add `what` to the report once, with a warning: "FILE: ignored: WHAT (WHY)" or similar.
void report_ignored(const std::string& file, const std::string& what, CoverageReport& coverage);
void report_approximated(const std::string& file, const std::string& what,
                         CoverageReport& coverage);
// The same without the warning.
void note_approximated(const std::string& what, CoverageReport& coverage);

}  // namespace emberline
