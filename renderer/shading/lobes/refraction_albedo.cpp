// Builds the table of refraction_albedo() by quadrature. The table holds the sum of reflection and
// transmission of a rough solid interface.

#include <algorithm>
#include <array>
#include <cmath>

#include "renderer/core/constants.h"
#include "renderer/shading/gauss_legendre.h"
#include "renderer/shading/lobes/table_position.h"
#include "renderer/shading/lobes/transmission_lobe.h"

namespace emberline {

namespace {

constexpr int kMus = 20, kRoughnesses = 16, kEtas = 16;
constexpr int kNodes = 24;
// The coordinate z = sqrt((n - 1) / (n + 1)) spreads indices of refraction n evenly (as in Cycles).
// The last z, 0.8, corresponds to n = 4.6.
constexpr float kLastZ = 0.8f;
constexpr float kFirstRoughness = 0.0316227766f;  // sqrt(kMirrorAlpha)

struct Quadrature {
  std::array<float, kNodes> cos_phi, u, weight;
  Quadrature() {
    const GaussLegendre<kNodes> rule;
    for (size_t i = 0; i < kNodes; ++i) {
      cos_phi[i] = float(std::cos(kPiD * rule.x[i]));
      u[i] = float(rule.x[i]);
      weight[i] = float(rule.w[i]);
    }
  }
};

// Returns the mean, over visible normals, of a sum: F G2/G1 if the reflected direction is above the
// surface, plus (1 - F) G2/G1 if the refracted direction is below the surface.
float integrate(const Quadrature& rule, float mu, float alpha, float eta) {
  const float alpha2 = square(alpha);
  const float sin_o = safe_sqrt(1 - square(mu));
  const float t = std::sqrt(alpha2 * square(sin_o) + square(mu));
  const float ox = alpha * sin_o / t, oz = mu / t;
  float sum = 0;
  for (size_t j = 0; j < kNodes; ++j) {
    const float one_minus_z = rule.u[j] * (1 + oz);
    const float z = 1 - one_minus_z, r = safe_sqrt(one_minus_z * (1 + z));
    float row = 0;
    for (size_t i = 0; i < kNodes; ++i) {  // vectorises
      const float mx = alpha * (r * rule.cos_phi[i] + ox);
      const float my2 = alpha2 * square(r) * (1 - square(rule.cos_phi[i]));
      const float mz = z + oz;
      const float scale = 1 / std::sqrt(square(mx) + my2 + square(mz));
      const float cos_d = std::min(1.0f, (sin_o * mx + mu * mz) * scale);
      const float nz = mz * scale;
      const float cos2_t = 1 - (1 - square(cos_d)) / square(eta);
      const float cos_t = safe_sqrt(cos2_t);
      const float parallel = (eta * cos_d - cos_t) / (eta * cos_d + cos_t);
      const float perpendicular = (cos_d - eta * cos_t) / (cos_d + eta * cos_t);
      const float f = cos2_t <= 0 ? 1.0f : 0.5f * (square(parallel) + square(perpendicular));
      const auto masked = [&](float mu_i) {
        const float t_i = std::sqrt(alpha2 + (1 - alpha2) * square(mu_i));
        return mu_i * (mu + t) / (mu_i * t + mu * t_i + 1e-30f);
      };
      const float up = std::max(0.0f, 2 * cos_d * nz - mu);
      const float down = std::max(0.0f, mu / eta - (cos_d / eta - cos_t) * nz);
      row += rule.weight[i] * (f * masked(up) + (1 - f) * masked(down));
    }
    sum += rule.weight[j] * row;
  }
  return sum;
}

struct Table {
  // [inside][eta][roughness][mu]
  std::array<float, size_t(2 * kEtas * kRoughnesses * kMus)> values;

  Table() {
    const Quadrature rule;
    size_t n = 0;
    for (int side = 0; side < 2; ++side)
      for (int e = 0; e < kEtas; ++e) {
        const float z = kLastZ * float(e) / float(kEtas - 1);
        const float index = (1 + square(z)) / (1 - square(z));
        for (int j = 0; j < kRoughnesses; ++j) {
          const float roughness = lerp(kFirstRoughness, 1.0f, float(j) / float(kRoughnesses - 1));
          const float a = 2 * square(roughness);
          for (int i = 0; i < kMus; ++i) {
            const float x2 = square(float(i) / float(kMus - 1));
            const float mu = std::min(1.0f, x2 * a / (1 + a - x2));
            values[n++] =
                integrate(rule, std::max(mu, 1e-6f), square(roughness), side ? 1 / index : index);
          }
        }
      }
  }
};

}  // namespace

float refraction_albedo(float mu, float roughness, float eta) {
  static const Table table;
  const float a = 2 * square(roughness);
  const TablePosition x(std::sqrt((1 + a) * mu / (mu + a)), kMus);
  const TablePosition y((roughness - kFirstRoughness) / (1 - kFirstRoughness), kRoughnesses);
  const float index = std::max(eta, 1 / eta);
  const TablePosition z(std::sqrt((index - 1) / (index + 1)) / kLastZ, kEtas);
  const float* base = table.values.data() + size_t(eta < 1 ? kEtas * kRoughnesses * kMus : 0);
  const auto row = [&](size_t e, size_t j) {
    const float* p = base + (e * kRoughnesses + j) * kMus + x.index;
    return lerp(p[0], p[1], x.fraction);
  };
  const auto plane = [&](size_t e) {
    return lerp(row(e, y.index), row(e, y.index + 1), y.fraction);
  };
  return lerp(plane(z.index), plane(z.index + 1), z.fraction);
}

}  // namespace emberline
