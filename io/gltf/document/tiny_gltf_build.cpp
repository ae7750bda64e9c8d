// The one place where tinygltf's functions are compiled.
#include <fstream>
#include <nlohmann/json.hpp>

#define TINYGLTF_IMPLEMENTATION
#include "io/gltf/document/tiny_gltf_renamed.h"
