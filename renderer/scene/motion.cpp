#include "renderer/scene/motion.h"

#include "renderer/description/transform_parts.h"

namespace emberline::scene_detail {

std::vector<RTCQuaternionDecomposition> decompose(std::span<const Mat44d> steps) {
  std::vector<RTCQuaternionDecomposition> result;
  Imath::Quatd before;
  for (const Mat44d& step : steps) {
    const TransformParts p(step);
    const Imath::Quatd q = (p.rotation ^ before) < 0 ? -p.rotation : p.rotation;
    before = q;
    RTCQuaternionDecomposition d;
    rtcInitQuaternionDecomposition(&d);
    rtcQuaternionDecompositionSetScale(&d, float(p.size.x), float(p.size.y), float(p.size.z));
    rtcQuaternionDecompositionSetSkew(&d, float(p.skew_xy), float(p.skew_xz), float(p.skew_yz));
    rtcQuaternionDecompositionSetQuaternion(&d, float(q.r), float(q.v.x), float(q.v.y),
                                            float(q.v.z));
    rtcQuaternionDecompositionSetTranslation(&d, float(p.translation.x), float(p.translation.y),
                                             float(p.translation.z));
    result.push_back(d);
  }
  return result;
}

}  // namespace emberline::scene_detail
