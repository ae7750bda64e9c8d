// A file with static objects and every kind of animation.
#pragma once

#include "support/gltf_builder.h"

namespace emberline::test {

// An animation of two seconds. The stage has a lamp that is flush with the floor, a box that turns,
// two boxes of the same mesh, one of which rises, a box that is visible from 0.5 s to 1.5 s, a flag
// with two joints, a sail that morphs, a moving triangle lamp and a moving point light. Animation
// pointers change materials, a light and a camera.
struct AnimatedStage {
  AnimatedStage();

  GltfBuilder gltf;
};

}  // namespace emberline::test
