#include "renderer/shading/lobes/specular_albedo.h"

#include <array>
#include <cassert>

#include "renderer/core/constants.h"
#include "renderer/shading/gauss_legendre.h"
#include "renderer/shading/lobes/table_position.h"

namespace emberline {

namespace {

// Nodes per dimension of the integral over microfacet normals. With 32 nodes, the error is 3e-4
// (the integrand has a kink where reflections fall below the horizon). With 40 nodes, it is 2e-4.
constexpr int kNodes = 40;

struct Quadrature {
  std::array<float, kNodes> cos_phi, phi_weight, u, u_weight;
  Quadrature() {
    const GaussLegendre<kNodes> rule;
    for (size_t i = 0; i < kNodes; ++i) {
      cos_phi[i] = float(std::cos(kPiD * rule.x[i]));  // [0, pi]: the lobe is symmetric
      phi_weight[i] = u_weight[i] = float(rule.w[i]);
      u[i] = float(rule.x[i]);
    }
  }
};

// Computes E and B as means over bounded visible normals (see ggx.h for the map and its weight), so
// that the integrand stays in [0, 1] for every alpha and mu.
void integrate(const Quadrature& rule, float mu, float alpha, double* e, double* b) {
  const float alpha2 = square(alpha);
  const float sin_o = safe_sqrt(1 - square(mu));
  const float t = std::sqrt(alpha2 * square(sin_o) + square(mu));
  const float s2 = square(1 + sin_o);
  const float k = (1 - alpha2) * s2 / (s2 + alpha2 * square(mu));
  const float ix = alpha * sin_o / t, iz = mu / t, bound = k * iz;
  double sum_e = 0, sum_b = 0;
  for (size_t j = 0; j < kNodes; ++j) {
    const float one_minus_z = rule.u[j] * (1 + bound);
    const float z = 1 - one_minus_z;
    const float r = safe_sqrt(one_minus_z * (1 + z));
    float row_e = 0, row_b = 0;
    for (size_t i = 0; i < kNodes; ++i) {  // vectorises: no call, no branch
      const float hx = r * rule.cos_phi[i] + ix;
      const float hy2 = square(r) * (1 - square(rule.cos_phi[i]));
      const float mx = alpha * hx, mz = z + iz;
      const float length2 = square(mx) + alpha2 * hy2 + square(mz);
      const float cos_d = (sin_o * mx + mu * mz);  // times the length of m
      const float mu_i = std::max(0.0f, 2 * cos_d * mz / length2 - mu);
      const float t_i = std::sqrt(alpha2 + (1 - alpha2) * square(mu_i));
      const float weight = mu_i * (k * mu + t) / (mu_i * t + mu * t_i + 1e-30f);
      const float m = 1 - std::min(1.0f, cos_d / std::sqrt(length2));
      row_e += rule.phi_weight[i] * weight;
      row_b += rule.phi_weight[i] * weight * square(square(m)) * m;
    }
    sum_e += double(rule.u_weight[j]) * double(row_e);
    sum_b += double(rule.u_weight[j]) * double(row_b);
  }
  *e = sum_e;
  *b = sum_b;
}

// Rows are evenly spaced in roughness = sqrt(alpha), with alpha from kMirrorAlpha to 1. `y` in [0,
// 1] is a position along the rows.
constexpr float kFirstRoughness = 0.0316227766f;
static_assert(kFirstRoughness * kFirstRoughness / kMirrorAlpha - 1 < 1e-6f &&
              1 - kFirstRoughness * kFirstRoughness / kMirrorAlpha < 1e-6f);
constexpr float kPerRoughness = 1.0f / (1.0f - kFirstRoughness);
float alpha_at(float y) { return square(kFirstRoughness + (1 - kFirstRoughness) * y); }

}  // namespace

struct SpecularAlbedo::Tables {
  std::array<Node, size_t(kRows* kColumns)> nodes;
  // The averages at each alpha. The loss is divided by alpha^2: at mu >> alpha, it falls as
  // (alpha / mu)^2, so the quotient varies slowly with alpha.
  std::array<float, size_t(kAverages)> average_loss_over_alpha2, average_schlick;

  Tables() {
    const Quadrature quadrature;
    for (int j = 0; j < kRows; ++j) {
      const float alpha = alpha_at(float(j) / float(kRows - 1));
      const double a = 2.0 * double(alpha);
      for (int i = 0; i < kColumns; ++i) {
        const double x2 = square(double(i) / (kColumns - 1));
        const double mu = x2 * a / (1 + a - x2);
        double e, b;
        integrate(quadrature, float(std::min(mu, 1.0)), alpha, &e, &b);
        e = std::min(e, 1.0);
        nodes[size_t(j * kColumns + i)] = {float(1 - e), float(b - std::pow(1 - mu, 5) * e)};
      }
    }
    for (int j = 0; j < kAverages; ++j) {
      SpecularAlbedo row;
      const float y = float(j) / float(kAverages - 1);
      row.select(*this, y);
      double loss = 0, schlick = 0;
      row.integrate_average(&loss, &schlick);
      average_loss_over_alpha2[size_t(j)] = float(loss / square(double(alpha_at(y))));
      average_schlick[size_t(j)] = float(schlick);
    }
  }
};

// Integrates cell by cell, since the interpolant has a kink at every node. After the first cell,
// the variable is log(mu), because for small alpha the last cell reaches from mu = 36 alpha to 1.
void SpecularAlbedo::integrate_average(double* loss, double* schlick) const {
  static const GaussLegendre<4> kShort;
  static const GaussLegendre<24> kLong;
  const auto add = [&](double mu, double weight) {
    const Value value = at(float(mu));
    *loss += 2 * mu * weight * double(value.loss);
    *schlick += 2 * mu * weight * double(value.schlick);
  };
  const auto mu_at = [this](int column) {
    const double x2 = square(double(column) / (kColumns - 1)), a = double(two_alpha_);
    return x2 * a / (1 + a - x2);
  };
  const double first = mu_at(1);
  for (size_t i = 0; i < 4; ++i) add(first * kShort.x[i], first * kShort.w[i]);
  const auto add_cells = [&](double from, double to, const auto& rule) {
    const double range = std::log(to / from);
    for (size_t i = 0; i < rule.x.size(); ++i) {
      const double mu = from * std::exp(range * rule.x[i]);
      add(mu, mu * range * rule.w[i]);
    }
  };
  for (int c = 1; c < kColumns - 2; ++c) add_cells(mu_at(c), mu_at(c + 1), kShort);
  add_cells(mu_at(kColumns - 2), 1.0, kLong);
}

const SpecularAlbedo::Tables& SpecularAlbedo::tables() {
  static const Tables instance;  // C++ makes this thread-safe
  return instance;
}

void SpecularAlbedo::select(const Tables& tables, float y) {
  const TablePosition row(y, kRows);
  row_ = tables.nodes.data() + row.index * kColumns;
  y_ = row.fraction;
  two_alpha_ = 2 * alpha_at(y);
  scale_ = 1 + two_alpha_;
}

SpecularAlbedo::SpecularAlbedo(float roughness) {
  assert(roughness >= 0 && roughness <= 1);
  const float alpha = square(roughness);
  if (alpha < kMirrorAlpha) return;
  const Tables& t = tables();
  const float y = std::clamp((roughness - kFirstRoughness) * kPerRoughness, 0.0f, 1.0f);
  select(t, y);
  const auto [n, f] = TablePosition(y, kAverages);
  average_loss_ =
      square(alpha) * lerp(t.average_loss_over_alpha2[n], t.average_loss_over_alpha2[n + 1], f);
  average_schlick_ = lerp(t.average_schlick[n], t.average_schlick[n + 1], f);
}

}  // namespace emberline
