// A small glTF with many features, for tests that damage it.
#pragma once

#include "support/gltf_builder.h"

namespace emberline::test {

// A textured, normal-mapped quad with sparse positions, a skin, morph targets, instances, a camera
// and a light.
GltfBuilder dense_gltf();

}  // namespace emberline::test
