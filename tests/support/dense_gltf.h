// A small glTF with much in it, to be spoilt by tests of bad input.
#pragma once

#include "support/gltf_builder.h"

namespace emberline::test {

// One of most things, small: a textured, normal-mapped quad with sparse positions, a skin, morph
// targets, instances, a camera and a light.
GltfBuilder dense_gltf();

}  // namespace emberline::test
