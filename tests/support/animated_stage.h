// A file that animates everything that can be animated, together with static objects.
#pragma once

#include "support/gltf_builder.h"

namespace emberline::test {

// Two seconds: a stage with a lamp flush in its floor; a box that turns; two boxes of one mesh, one
// of which rises; a box that is visible from 0.5 s to 1.5 s; a flag with two joints; a sail that
// morphs; a moving triangle lamp and a moving point light; materials, a light and a camera that
// animation pointers change.
struct AnimatedStage {
  AnimatedStage();

  GltfBuilder gltf;
};

}  // namespace emberline::test
