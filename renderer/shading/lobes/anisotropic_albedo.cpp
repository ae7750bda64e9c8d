// The table behind AnisotropicAlbedo, by quadrature over bounded visible normals.

#include <algorithm>
#include <array>
#include <memory>

#include "renderer/shading/gauss_legendre.h"
#include "renderer/shading/lobes/anisotropic_ggx.h"

namespace emberline {

namespace {

// Nodes over cosine, azimuth, alpha_y and alpha_x.
constexpr int kCosines = 20, kAzimuths = 8, kNarrow = 16, kWide = 12;
constexpr int kPolar = 24, kTurns = 48;  // of the quadrature

constexpr float kFirstRoughness = 0.0316227766f;  // sqrt(kMirrorAlpha)

// Widths, both even in roughness = sqrt(alpha): y from the mirror's to 1, x from y's to 1.
float narrow_at(float position) {
  return square(kFirstRoughness + (1 - kFirstRoughness) * position);
}
float wide_at(float position, float alpha_y) {
  const float r = std::sqrt(alpha_y);
  return square(r + (1 - r) * position);
}

// The lobe's width in the azimuth of (x, y), alpha^2 = (alpha_x^2 x^2 + alpha_y^2 y^2) / (x^2 +
// y^2), and where it lies between alpha_y and alpha_x, even in sqrt(alpha); the limit cos^2 where
// both are equal.
struct Azimuth {
  float alpha, position;
  Azimuth(float alpha_x, float alpha_y, float x, float y) {
    const float x2 = square(x), sum = x2 + square(y);
    const float cos2 = sum > 0 ? x2 / sum : 0.5f;
    alpha = std::sqrt(lerp(square(alpha_y), square(alpha_x), cos2));
    position = (alpha_x + alpha_y) * cos2 / (alpha + alpha_y) *
               (std::sqrt(alpha_x) + std::sqrt(alpha_y)) / (std::sqrt(alpha) + std::sqrt(alpha_y));
  }
};
// cos^2 of the azimuth at a position.
float cos2_at(float position, float alpha_x, float alpha_y) {
  const float ry = std::sqrt(alpha_y), rx = std::sqrt(alpha_x);
  if (!(rx - ry > 1e-4f * rx)) return position;
  const float alpha2 = square(square(ry + (rx - ry) * position));
  return std::clamp((alpha2 - square(alpha_y)) / (square(alpha_x) - square(alpha_y)), 0.0f, 1.0f);
}

// The coordinate of specular_albedo.h and its inverse.
float column_of(float mu, float alpha) {
  return std::sqrt((1 + 2 * alpha) * mu / (mu + 2 * alpha));
}
float cosine_at(float column, float alpha) {
  const float x2 = square(column), a = 2 * alpha;
  return std::min(1.0f, x2 * a / (1 + a - x2));
}

struct Position {
  size_t index;
  float fraction;
  Position(float at, int size) {
    const float clamped = std::clamp(at, 0.0f, 1.0f) * float(size - 1);
    const int i = std::min(int(clamped), size - 2);
    index = size_t(i);
    fraction = clamped - float(i);
  }
};

struct Quadrature {
  std::array<float, kTurns> cos_phi, sin_phi;  // even: the integrand is periodic
  std::array<float, kPolar> u, weight;
  Quadrature() {
    const GaussLegendre<kPolar> rule;
    for (size_t i = 0; i < kPolar; ++i) {
      u[i] = float(rule.x[i]);
      weight[i] = float(rule.w[i]) / float(kTurns);
    }
    for (size_t i = 0; i < kTurns; ++i) {
      const double phi = 2 * kPiD * (double(i) + 0.5) / kTurns;
      cos_phi[i] = float(std::cos(phi));
      sin_phi[i] = float(std::sin(phi));
    }
  }
};

// E and B, as in specular_albedo.cpp.
void integrate(const Quadrature& rule, const Vec3f& w, float ax, float ay, float* e, float* b) {
  const float ax2 = square(ax), ay2 = square(ay), mu = w.z;
  const float sin2 = fma(w.x, w.x, square(w.y));
  const float t = std::sqrt(ax2 * square(w.x) + ay2 * square(w.y) + square(mu));
  const float s2 = square(1 + std::sqrt(sin2)), narrow2 = std::min(ax2, ay2);
  const float k = (1 - narrow2) * s2 / (s2 + narrow2 * square(mu));
  const float ix = ax * w.x / t, iy = ay * w.y / t, iz = mu / t, bound = k * iz;
  float sum_e = 0, sum_b = 0;
  for (size_t j = 0; j < kPolar; ++j) {
    const float one_minus_z = rule.u[j] * (1 + bound);
    const float z = 1 - one_minus_z, r = safe_sqrt(one_minus_z * (1 + z)), mz = z + iz;
    float row_e = 0, row_b = 0;
    for (size_t i = 0; i < kTurns; ++i) {  // vectorises: no call, no branch
      const float mx = ax * (r * rule.cos_phi[i] + ix), my = ay * (r * rule.sin_phi[i] + iy);
      const float length2 = square(mx) + square(my) + square(mz);
      const float cos_d = w.x * mx + w.y * my + mu * mz;  // times the length of m
      const float twice = 2 * cos_d / length2;
      const float wx = twice * mx - w.x, wy = twice * my - w.y;
      const float mu_i = std::max(0.0f, twice * mz - mu);
      const float t_i = std::sqrt(ax2 * square(wx) + ay2 * square(wy) + square(mu_i));
      const float weight = mu_i * (k * mu + t) / (mu_i * t + mu * t_i + 1e-30f);
      const float m = 1 - std::min(1.0f, cos_d / std::sqrt(length2));
      row_e += weight;
      row_b += weight * square(square(m)) * m;
    }
    sum_e += rule.weight[j] * row_e;
    sum_b += rule.weight[j] * row_b;
  }
  *e = std::min(1.0f, sum_e);
  *b = sum_b;
}

float pow5(float x) { return square(square(x)) * x; }

}  // namespace

struct AnisotropicAlbedo::Tables {
  std::array<Node, size_t(kNarrow* kWide* kAzimuths* kCosines)> nodes;
  // Of the averages: the loss over that of the isotropic lobe with the mean alpha^2, and what the
  // Schlick part has beyond that lobe's.
  std::array<Node, size_t(kNarrow* kWide)> averages = {};

  static const Node* plane(const Tables& t, size_t narrow, size_t wide) {
    return t.nodes.data() + (narrow * kWide + wide) * kAzimuths * kCosines;
  }

  Tables() {
    const Quadrature rule;
    size_t n = 0;
    for (int j = 0; j < kNarrow; ++j)
      for (int i = 0; i < kWide; ++i) {
        const float ay = narrow_at(float(j) / float(kNarrow - 1));
        const float ax = wide_at(float(i) / float(kWide - 1), ay);
        for (int v = 0; v < kAzimuths; ++v) {
          const float cos2 = cos2_at(float(v) / float(kAzimuths - 1), ax, ay);
          const Vec2f axis(std::sqrt(cos2), std::sqrt(1 - cos2));
          const float alpha = std::sqrt(lerp(square(ay), square(ax), cos2));
          const SpecularAlbedo isotropic(std::sqrt(alpha));
          for (int c = 0; c < kCosines; ++c, ++n) {
            const float mu = cosine_at(float(c) / float(kCosines - 1), alpha);
            nodes[n] = i == 0 ? Node{0, 0} : difference(rule, isotropic, axis, mu, ax, ay);
          }
        }
      }
    for (int j = 0; j < kNarrow; ++j)
      for (int i = 0; i < kWide; ++i) {
        const float ay = narrow_at(float(j) / float(kNarrow - 1));
        averages[size_t(j * kWide + i)] =
            i == 0 ? Node{1, 0} : average(ay, wide_at(float(i) / float(kWide - 1), ay));
      }
  }

  static Node difference(const Quadrature& rule, const SpecularAlbedo& isotropic, const Vec2f& axis,
                         float mu, float ax, float ay) {
    const float sine = safe_sqrt((1 - mu) * (1 + mu));
    float e, b;
    integrate(rule, Vec3f(axis.x * sine, axis.y * sine, mu), ax, ay, &e, &b);
    const SpecularAlbedo::Value base = isotropic.at(mu);
    const float m5 = pow5(1 - mu);
    return {1 - e - base.loss, (b - m5 * e) - (base.schlick - m5 * (1 - base.loss))};
  }

  // Means of at() over the hemisphere: even in log(cosine), and in an azimuth stretched half as far
  // as the lobe, so that neither narrow layers nor the rest go without nodes.
  Node average(float ay, float ax) const {
    static const GaussLegendre<32> cosines;
    static const GaussLegendre<12> azimuths;
    AnisotropicAlbedo one(ax, ay, *this);
    const double range = std::log(1e5), g = std::sqrt(double(ax) / double(ay));
    double loss = 0, schlick = 0, area = 0;
    for (size_t j = 0; j < azimuths.x.size(); ++j) {
      const double tangent = std::tan(0.5 * kPiD * azimuths.x[j]), tan2 = square(g * tangent);
      const double weight = azimuths.w[j] * g * (1 + square(tangent)) / (1 + tan2);
      const double cosine = 1 / std::sqrt(1 + tan2), sine = g * tangent * cosine;
      for (size_t i = 0; i < cosines.x.size(); ++i) {
        const double mu = std::exp(-range * cosines.x[i]), r = std::sqrt(1 - mu * mu);
        const SpecularAlbedo::Value value =
            one.at(Vec3f(float(cosine * r), float(sine * r), float(mu)));
        const double w = weight * cosines.w[i] * range * 2 * mu * mu;
        loss += w * double(value.loss);
        schlick += w * double(value.schlick);
        area += w;
      }
    }
    const SpecularAlbedo isotropic(mean_roughness(ax, ay));
    return {float(loss / area) / isotropic.average_loss(),
            float(schlick / area) - isotropic.average_schlick()};
  }

  static float mean_roughness(float ax, float ay) {
    return std::sqrt(std::sqrt(0.5f * (square(ax) + square(ay))));
  }
};

const AnisotropicAlbedo::Tables& AnisotropicAlbedo::tables() {
  static const auto instance = std::make_unique<const Tables>();
  return *instance;
}

AnisotropicAlbedo::AnisotropicAlbedo(float alpha_x, float alpha_y, const Tables& tables)
    : alpha_x_(std::max(alpha_x, alpha_y)), alpha_y_(alpha_y) {
  const float ry = std::sqrt(alpha_y_), rx = std::sqrt(alpha_x_);
  const Position narrow((ry - kFirstRoughness) / (1 - kFirstRoughness), kNarrow);
  const Position wide((rx - ry) / std::max(1 - ry, 1e-6f), kWide);
  const auto weigh = [&](size_t j, size_t i) {
    return (j ? narrow.fraction : 1 - narrow.fraction) * (i ? wide.fraction : 1 - wide.fraction);
  };
  const SpecularAlbedo isotropic(Tables::mean_roughness(alpha_x_, alpha_y_));
  float ratio = 0, more = 0;
  for (size_t corner = 0; corner < 4; ++corner) {
    const size_t j = corner / 2, i = corner % 2;
    weights_[corner] = weigh(j, i);
    corners_[corner] = Tables::plane(tables, narrow.index + j, wide.index + i);
    const Node& a = tables.averages[(narrow.index + j) * kWide + wide.index + i];
    ratio = fma(weights_[corner], a.loss, ratio);
    more = fma(weights_[corner], a.rest, more);
  }
  average_loss_ = ratio * isotropic.average_loss();
  average_schlick_ = isotropic.average_schlick() + more;
}

AnisotropicAlbedo::AnisotropicAlbedo(float alpha_x, float alpha_y)
    : AnisotropicAlbedo(alpha_x, alpha_y, tables()) {}

SpecularAlbedo::Value AnisotropicAlbedo::at(const Vec3f& w) const {
  const float mu = std::clamp(w.z, 0.0f, 1.0f);
  const Azimuth azimuth(alpha_x_, alpha_y_, w.x, w.y);
  const SpecularAlbedo::Value base = SpecularAlbedo(std::sqrt(azimuth.alpha)).at(mu);
  const Position v(azimuth.position, kAzimuths);
  const Position x(column_of(mu, azimuth.alpha), kCosines);
  const size_t at = v.index * kCosines + x.index;
  float loss = base.loss, rest = 0;
  for (size_t corner = 0; corner < 4; ++corner) {
    const Node* p = corners_[corner] + at;
    const auto blend = [&](float Node::*field) {
      return lerp(lerp(p[0].*field, p[1].*field, x.fraction),
                  lerp(p[kCosines].*field, p[kCosines + 1].*field, x.fraction), v.fraction);
    };
    loss = fma(weights_[corner], blend(&Node::loss), loss);
    rest = fma(weights_[corner], blend(&Node::rest), rest);
  }
  loss = std::clamp(loss, 0.0f, 1.0f);
  // base.schlick holds (1 - mu)^5 E of its own E.
  const float m5 = pow5(1 - mu);
  return {loss, std::clamp(base.schlick + rest + m5 * (base.loss - loss), 0.0f, 1.0f)};
}

}  // namespace emberline
