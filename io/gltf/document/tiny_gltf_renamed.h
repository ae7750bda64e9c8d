// tinygltf under a namespace of our own.
//
// Debian's libdraco.so carries an older tinygltf with other class layouts under the same exported
// names. In a program linked with both libraries the loader mixes the two and destroys objects
// that were never built. So tinygltf is compiled into this library
// (gltf/document/tiny_gltf_build.cpp) under another name, without its image and file functions,
// which are not used here.
#pragma once

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_FS
#define TINYGLTF_NO_INCLUDE_JSON
#define tinygltf emberline_tinygltf
#include <tiny_gltf.h>
#undef tinygltf
