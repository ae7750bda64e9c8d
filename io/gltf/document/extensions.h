// What this loader makes of each glTF extension. To add one: a row in the table of
// gltf/document/extensions.cpp, its members in gltf/document/schema.cpp, and the code that reads
// it.
#pragma once

#include <string_view>

#include "io/gltf/document/document.h"
#include "renderer/description/scene_description.h"

namespace emberline {

// Whether files may use the extension as if it were part of glTF.
bool is_honoured(std::string_view extension);

// Throws InputError for the first of extensionsRequired that is not honoured.
void check_required_extensions(const GltfDocument& document);

// Sorts extensionsUsed into the report and warns of what has no effect, with the why.
void report_extensions(const GltfDocument& document, CoverageReport& coverage);

// Of a file of a later minor version: adds what nodes, meshes and materials have that this version
// cannot read, and warns of it.
void report_unknown_members(const GltfDocument& document, CoverageReport& coverage);

// Adds `what` once and warns of it: "FILE: ignored: WHAT (WHY)" or the like.
void report_ignored(const std::string& file, const std::string& what, CoverageReport& coverage);
void report_approximated(const std::string& file, const std::string& what,
                         CoverageReport& coverage);
// The same without a warning.
void note_approximated(const std::string& what, CoverageReport& coverage);

}  // namespace emberline
