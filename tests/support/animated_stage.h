// A file in which everything moves that can, beside things that do not.
#pragma once

#include "support/gltf_builder.h"

namespace emberline::test {

// Two seconds: a stage with a lamp flush in its floor; a box that turns, one that comes twice and
// of which one goes up; one that is to be seen from 0.5 s to 1.5 s; a flag of two joints, a sail
// that morphs; a lamp of triangles and a point light that move; materials, a light and a camera
// that pointers change.
struct AnimatedStage {
  AnimatedStage();

  GltfBuilder gltf;
};

}  // namespace emberline::test
