#include <Imath/ImathMatrix.h>

#include <algorithm>
#include <cmath>

#include "io/display/working_space.h"
#include "renderer/core/errors.h"

namespace emberline {
namespace {

constexpr float kTolerance = 1e-4f;  // headers state four digits

bool nearly_equal(const Chromaticities& a, const Chromaticities& b) {
  const auto near = [](float u, float v) { return std::abs(u - v) < kTolerance; };
  return std::ranges::equal(a, b, near);
}

// Returns the XYZ of a chromaticity, with X + Y + Z = 1.
Imath::V3d xyz(const Chromaticities& c, size_t i) {
  const double x = c[2 * i], y = c[2 * i + 1];
  return {x, y, 1.0 - x - y};
}

// Returns the matrix from a row vector (R, G, B) to the cone responses of Bradford's transform,
// each divided by the response to white.
Imath::M33d to_adapted_cones(const Chromaticities& c, const std::string& place) {
  // J. Lam, "Metamerism and colour constancy", 1985.
  const Imath::M33d cones(0.8951, -0.7502, 0.0389, 0.2664, 1.7135, -0.0685, -0.1614, 0.0367,
                          1.0296);
  Imath::M33d to_cones;
  for (int primary = 0; primary < 3; ++primary) {
    const Imath::V3d row = xyz(c, size_t(primary)) * cones;
    for (int cone = 0; cone < 3; ++cone) to_cones[primary][cone] = row[cone];
  }
  const Imath::V3d white = xyz(c, 3) * cones;
  const bool near = std::ranges::all_of(c, [](float v) { return std::abs(v) < 10.0f; });
  const bool is_independent = near && std::abs(to_cones.determinant()) > 1e-4;
  if (!is_independent || !(std::min({white.x, white.y, white.z}) > 1e-3)) {
    throw InputError(place, "its chromaticities do not define a colour space");
  }
  const Imath::V3d amounts = white * to_cones.inverse();  // how much of each primary is in white
  for (int primary = 0; primary < 3; ++primary) {
    for (int cone = 0; cone < 3; ++cone) to_cones[primary][cone] *= amounts[primary] / white[cone];
  }
  if (!(std::abs(to_cones.determinant()) > 1e-6)) {
    throw InputError(place, "its white point is not a mixture of its three primaries");
  }
  return to_cones;
}

}  // namespace

// The Rec. 709 values are from ITU-R BT.709-6, section 1. The ACEScg values are from SMPTE ST
// 2065-1 and the Academy's S-2014-004.
Chromaticities chromaticities_of(WorkingSpace space) {
  if (space == WorkingSpace::kAcesCg) {
    return {0.713f, 0.293f, 0.165f, 0.830f, 0.128f, 0.044f, 0.32168f, 0.33767f};
  }
  return {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};
}

WorkingSpace working_space_of(const Chromaticities& chromaticities) {
  const bool acescg = nearly_equal(chromaticities, chromaticities_of(WorkingSpace::kAcesCg));
  return acescg ? WorkingSpace::kAcesCg : WorkingSpace::kRec709;
}

ToWorkingSpace to_rec709(const Chromaticities& chromaticities, const std::string& place) {
  const Chromaticities rec709 = chromaticities_of(WorkingSpace::kRec709);
  if (nearly_equal(chromaticities, rec709)) return nullptr;
  const Imath::M33d m =
      to_adapted_cones(chromaticities, place) * to_adapted_cones(rec709, place).inverse();
  const auto weights = [&](int c) { return Vec3f(float(m[0][c]), float(m[1][c]), float(m[2][c])); };
  return std::make_shared<const ColourMatrix>(ColourMatrix{weights(0), weights(1), weights(2)});
}

}  // namespace emberline
