// Checks a JSON document against the tables of gltf/document/schema.cpp.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "io/gltf/document/faults.h"
#include "io/json/schema_property.h"

namespace emberline::schema {

// Checks the whole document; see check_schema (gltf/document/schema.h).
void check_document(nlohmann::json& root, const std::string& file, GltfFaults& faults,
                    Schema schema);

}  // namespace emberline::schema
