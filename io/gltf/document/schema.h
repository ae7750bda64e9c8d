// The structure of a glTF file: which members it may have, of which type, pointing where.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "io/gltf/document/faults.h"
#include "io/json/schema_property.h"

namespace emberline {

// Checks every member that this loader reads against the glTF 2.0 schema (and those of the
// extensions that are honoured): type, required members, array lengths, index ranges. Integral
// numbers written with a fraction (2.0, 1e3) are turned into integers. Members that the loader
// does not read are not looked at.
//
// What is at fault and can be told apart goes to `faults`: elements of the file's arrays, and
// attributes of primitives, become null and are noted; members that the picture does without, and
// what is wrong in optional extensions, are removed and left out, down to their defaults. For all
// else it throws InputError with the JSON pointer of the first fault. Extensions that objects have
// and extensionsUsed does not list are added there.
void check_schema(nlohmann::json& root, const std::string& file, GltfFaults& faults);

// Members of nodes, meshes and materials, and of the objects in them, that the tables do not know:
// "\"foo\" of meshes/primitives". Extras and extensions are not looked at.
std::vector<std::string> unknown_members(const nlohmann::json& root);

// What stands at a JSON pointer such as "/materials/3/pbrMetallicRoughness/metallicFactor", of
// those members that this loader reads; else null. Whether the file has it is not asked.
const schema::Property* find_property(std::string_view pointer);

}  // namespace emberline
