// Includes tinygltf in a namespace of our own.
//
// Debian's libdraco.so exports an older tinygltf under the same names with other class layouts. In
// a program linked with both versions, the dynamic loader mixes them, and objects that were never
// constructed are destroyed. Therefore tinygltf is compiled into this library
// (gltf/document/tiny_gltf_build.cpp) under another name, without its image and file functions.
#pragma once

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_FS
#define TINYGLTF_NO_INCLUDE_JSON
#define tinygltf emberline_tinygltf
#include <tiny_gltf.h>
#undef tinygltf
