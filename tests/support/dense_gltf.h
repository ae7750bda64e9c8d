// A small glTF file with many features, for tests that damage files.
#pragma once

#include "support/gltf_builder.h"

namespace emberline::test {

// The file has a textured, normal-mapped quad with sparse positions, a skin, morph targets and
// instances, and it has a camera and a light.
GltfBuilder dense_gltf();

}  // namespace emberline::test
