#include "io/gltf_specular_glossiness.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace emberline {
namespace {

constexpr double kDielectricF0 = 0.04;  // index of refraction 1.5, glTF 2.0 appendix B.3.1

// The metalness m at which a metallic-roughness material of base colour B has the diffuse
// reflectance d and the specular reflectance s, in perceived brightness. With left = 1 - max s:
//   d left = B (1 - 0.04) (1 - m)   and   s = 0.04 (1 - m) + B m;
// without B this is 0.04 m^2 + (d left / 0.96 + s - 0.08) m + 0.04 - s = 0.
double solve_metallic(double d, double s, double left) {
  if (s <= kDielectricF0) return 0.0;
  const double a = kDielectricF0;
  const double b = d * left / (1.0 - kDielectricF0) + s - 2.0 * kDielectricF0;
  const double c = kDielectricF0 - s;
  return std::clamp((-b + std::sqrt(std::max(0.0, b * b - 4.0 * a * c))) / (2.0 * a), 0.0, 1.0);
}

// As the extension's conversion notes weigh it: root of the weighted squares.
double brightness(const double (&c)[3]) {
  return std::sqrt(0.299 * c[0] * c[0] + 0.587 * c[1] * c[1] + 0.114 * c[2] * c[2]);
}

}  // namespace

void convert_specular_glossiness(const nlohmann::json& extension, MaterialDescription& material) {
  const auto diffuse = extension.value("diffuseFactor", std::vector<double>{1, 1, 1, 1});
  const auto specular = extension.value("specularFactor", std::vector<double>{1, 1, 1});
  const double glossiness = std::clamp(extension.value("glossinessFactor", 1.0), 0.0, 1.0);
  double d[3], s[3];
  for (size_t c = 0; c < 3; ++c) {
    d[c] = std::clamp(diffuse[c], 0.0, 1.0);
    s[c] = std::clamp(specular[c], 0.0, 1.0);
  }
  material.alpha = float(std::clamp(diffuse[3], 0.0, 1.0));

  if (extension.contains("specularGlossinessTexture")) {
    material.base_color = Rgb(float(d[0]), float(d[1]), float(d[2]));
    material.metallic = 0.0f;
    material.roughness = 0.5f;  // chosen by us: the texture's mean is not known
    return;
  }
  const double left = 1.0 - std::max({s[0], s[1], s[2]});
  const double metallic = solve_metallic(brightness(d), brightness(s), left);
  for (int c = 0; c < 3; ++c) {
    const double from_diffuse =
        d[c] * left / (1.0 - kDielectricF0) / std::max(1.0 - metallic, 1e-6);
    const double from_specular =
        (s[c] - kDielectricF0 * (1.0 - metallic)) / std::max(metallic, 1e-6);
    const double weight = metallic * metallic;
    material.base_color[c] =
        float(std::clamp(from_diffuse + (from_specular - from_diffuse) * weight, 0.0, 1.0));
  }
  material.metallic = float(metallic);
  material.roughness = float(1.0 - glossiness);
}

}  // namespace emberline
