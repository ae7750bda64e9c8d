// A glTF file with static objects and every kind of animation.
#pragma once

#include "support/gltf_builder.h"

namespace emberline::test {

// The animations last two seconds. The stage has a lamp that is flush with the floor, a box that
// turns, two boxes with the same mesh, a box that is visible from 0.5 s to 1.5 s, a flag with two
// joints, and a sail that morphs. One of the two boxes rises. A square lamp, a point light and the
// camera move. Animation pointers change a box's visibility, two materials and a light's intensity.
struct AnimatedStage {
  AnimatedStage();

  GltfBuilder gltf;
};

}  // namespace emberline::test
