// The structure of a glTF file: its members, their types, and what their indices refer to.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "io/gltf/document/faults.h"
#include "io/json/schema_property.h"

namespace emberline {

// Checks every member that this loader reads against the schemas of glTF 2.0 and of the supported
// extensions: type, required members, array lengths, index ranges. Integers written with a fraction
// or exponent (2.0, 1e3) become integers. Other members are ignored.
//
// Faults that can be isolated go to `faults`. Broken elements of the file's arrays, and broken
// attributes of primitives, become null and are noted. Faulty members that have a default, and
// faulty parts of optional extensions, are removed. Every other fault throws InputError with its
// JSON pointer. Extensions found on objects are added to extensionsUsed.
void check_schema(nlohmann::json& root, const std::string& file, GltfFaults& faults);

// Returns those members of nodes, meshes, materials and their sub-objects that the tables do not
// list, as "\"foo\" of meshes/primitives". Ignores extras and extensions.
std::vector<std::string> unknown_members(const nlohmann::json& root);

// Returns the property at a JSON pointer ("/materials/3/pbrMetallicRoughness/metallicFactor"), or
// null if this loader does not read the property. The file need not contain it.
const schema::Property* find_property(std::string_view pointer);

}  // namespace emberline
