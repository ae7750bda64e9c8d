#include "renderer/shading/lobes/wavelength.h"

#include <array>

#include "renderer/shading/lobes/colour_matching.h"

namespace emberline {

namespace {

// The responses are linear between nodes and normalised by the integrals of these polylines, so the
// mean weight is 1 up to rounding. The nodes end at 700 nm. Beyond that, the fit of the matching
// functions turns green, and only 1/400 of the red response lies there.
constexpr int kNodes = 161;
constexpr double kStep = 2.0;
constexpr int kGuide = 256;
static_assert(kFirstNanometre + (kNodes - 1) * kStep == 700.0);

struct Table {
  std::array<Rgb, size_t(kNodes)> response;   // each channel's integral over steps is 1
  std::array<float, size_t(kNodes)> density;  // mean of the three channels
  std::array<float, size_t(kNodes)> cdf;      // integral of the density up to the node
  std::array<uint8_t, size_t(kGuide)> guide;  // last node whose cdf is <= i / kGuide

  Table() {
    std::array<Vec3d, size_t(kNodes)> exact;
    Vec3d sum(0.0);
    for (int i = 0; i < kNodes; ++i) {
      const Vec3d r = rec709_response(kFirstNanometre + kStep * i);
      const Vec3d cut(std::max(r.x, 0.0), std::max(r.y, 0.0), std::max(r.z, 0.0));
      exact[size_t(i)] = cut;
      sum += cut * (i == 0 || i == kNodes - 1 ? 0.5 : 1.0);
    }
    double before = 0, total = 0;
    for (size_t i = 0; i < size_t(kNodes); ++i) {
      const Vec3d r(exact[i].x / sum.x, exact[i].y / sum.y, exact[i].z / sum.z);
      const double mean = (r.x + r.y + r.z) / 3;
      if (i > 0) total += 0.5 * (before + mean);
      before = mean;
      response[i] = Rgb(float(r.x), float(r.y), float(r.z));
      density[i] = float(mean);
      cdf[i] = float(total);
    }
    cdf.back() = 1.0f;
    for (int i = 0, node = 0; i < kGuide; ++i) {
      while (node < kNodes - 2 && cdf[size_t(node + 1)] <= float(i) / kGuide) ++node;
      guide[size_t(i)] = uint8_t(node);
    }
  }
};

}  // namespace

SampledWavelength sample_wavelength(float u) {
  static const Table table;
  size_t i = table.guide[std::min(size_t(u * float(kGuide)), size_t(kGuide - 1))];
  while (i < size_t(kNodes - 2) && table.cdf[i + 1] <= u) ++i;
  // Solve area = p0 t + (p1 - p0) t^2 / 2 for t in [0, 1] in a form that does not cancel.
  const float p0 = table.density[i], p1 = table.density[i + 1];
  const float area = std::max(0.0f, u - table.cdf[i]);
  const float root = safe_sqrt(fma(2.0f * (p1 - p0), area, square(p0)));
  const float t = std::min(1.0f, 2.0f * area / (p0 + root));
  const Rgb response = lerp(table.response[i], table.response[i + 1], t);
  return {float(kFirstNanometre) + float(kStep) * (float(i) + t),
          response / ((response.x + response.y + response.z) * (1.0f / 3.0f))};
}

float ior_at(float ior_d, float dispersion, float nanometres) {
  // Fraunhofer's F, d and C lines, in nanometres.
  constexpr double kF = 486.13, kD = 587.56, kC = 656.27;
  // The next two constants are 523655 and 1.5168 in the extension's text.
  constexpr double kPerSquare = 1.0 / (1.0 / (kF * kF) - 1.0 / (kC * kC));
  constexpr float kScale = float(kPerSquare / (kD * kD));
  if (ior_d == 0.0f) return 0.0f;
  const float ratio = float(kD) / nanometres;
  const float spread = (ior_d - 1.0f) * (dispersion * (1.0f / 20.0f)) * kScale;
  return std::max(1.0f, fma(spread, (ratio - 1.0f) * (ratio + 1.0f), ior_d));
}

}  // namespace emberline
