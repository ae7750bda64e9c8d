// An orthonormal shading frame. In local space, the normal is +Z.
#pragma once

#include "renderer/core/vector.h"

namespace emberline {

struct ShadingFrame {
  Vec3f tangent;
  Vec3f bitangent;
  Vec3f normal;

  // Returns an arbitrary right-handed frame whose normal is n, a unit vector. The method is listing
  // 3 of Duff et al. 2017, "Building an Orthonormal Basis, Revisited", JCGT 6(1). The frame is
  // continuous except where n.z changes sign, and computing it takes no square root.
  static ShadingFrame from_normal(const Vec3f& n) {
    const float sign = std::copysign(1.0f, n.z);
    const float a = -1.0f / (sign + n.z);
    const float b = n.x * n.y * a;
    return {Vec3f(fma(sign * n.x * n.x, a, 1.0f), sign * b, -sign * n.x),
            Vec3f(b, fma(n.y * n.y, a, sign), -n.y), n};
  }

  [[gnu::always_inline]] Vec3f to_local(const Vec3f& v) const {
    return {dot(v, tangent), dot(v, bitangent), dot(v, normal)};
  }
  [[gnu::always_inline]] Vec3f to_world(const Vec3f& v) const {
    return fma(normal, v.z, fma(bitangent, v.y, tangent * v.x));
  }
};

}  // namespace emberline
