// The only translation unit that compiles tinygltf's functions.
#include <fstream>
#include <nlohmann/json.hpp>

#define TINYGLTF_IMPLEMENTATION
#include "io/gltf/document/tiny_gltf_renamed.h"
