// Builds the table of AnisotropicAlbedo, by quadrature over bounded visible normals, and looks up
// values in it.
//
// The table's coordinates are chosen to minimise the interpolation error along each dimension:
// - for the cosine: sqrt(c/2 + mu/2), where c = (1 + 2 alpha) mu / (mu + 2 alpha) as in
//   specular_albedo.h, and alpha is the lobe's at the direction's azimuth. For azimuths near y,
//   values change over mu ~ alpha and, because the normals spread along x, also over mu ~ 1;
// - for the azimuth: the eighth root of the alpha at this azimuth, from alpha_y^(1/8) to
//   alpha_x^(1/8). With alpha_y = 1e-3 and alpha_x = 1, all changes are within a few degrees of y;
// - for alpha_y: its fourth root, from kMirrorAlpha^(1/4) to 1;
// - for alpha_x: its square root, from alpha_y^(1/2) to 1.
// Cubic (Lagrange) interpolation has an error of at most 1e-3 along the cosine and of at most 7e-4
// along each of the other dimensions. It needs a thirtieth of the nodes that linear interpolation
// would need. But a lookup reads one cache line for each neighbour, and cubic interpolation has
// twice as many neighbours per dimension. So after the build, the table is refined along both
// alphas, which change less often than directions, and lookups interpolate linearly along them.

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <vector>

#include "renderer/shading/gauss_legendre.h"
#include "renderer/shading/lobes/anisotropic_ggx.h"
#include "renderer/shading/lobes/table_position.h"

namespace emberline {

namespace {

constexpr int kCosines = 18, kAzimuths = 14, kNarrow = 24, kWide = 20;
constexpr int kNarrowBuilt = 12, kWideBuilt = 10;  // by quadrature; the rest are interpolated
constexpr size_t kPlane = size_t(kAzimuths) * kCosines;
constexpr int kPolar = 32, kTurns = 64;  // quadrature nodes

constexpr float kFirstRoot = 0.177827941f;  // kMirrorAlpha^(1/4)

// Return alpha_y (narrow) and alpha_x (wide) at positions in [0, 1] along the table.
float narrow_at(float position) { return square(square(lerp(kFirstRoot, 1.0f, position))); }
float wide_at(float position, float alpha_y) {
  return square(lerp(std::sqrt(alpha_y), 1.0f, position));
}
float position_of(int i, int size) { return float(i) / float(size - 1); }
// Returns cos^2 of the azimuth at node i.
float cos2_at(int i, float alpha_x, float alpha_y) {
  const float position = float(i) / float(kAzimuths - 1);
  const float x = std::pow(alpha_x, 0.125f), y = std::pow(alpha_y, 0.125f);
  if (!(x - y > 1e-5f)) return position;
  const float alpha2 = std::pow(lerp(y, x, position), 16.0f);
  const float cos2 = (alpha2 - square(alpha_y)) / (square(alpha_x) - square(alpha_y));
  return i == kAzimuths - 1 ? 1.0f : std::clamp(cos2, 0.0f, 1.0f);
}
float cosine_coordinate(float mu, float alpha) {
  const float a = 2 * alpha;
  return std::sqrt(0.5f * ((1 + a) * mu / (mu + a) + mu));
}
float cosine_at(int i, float alpha) {
  const double g = square(double(i) / (kCosines - 1)), a = 2 * double(alpha);
  const double b = 1 + 2 * (a - g), root = std::sqrt(b * b + 8 * g * a);
  return float(std::min(1.0, b > 0 ? 4 * g * a / (b + root) : 0.5 * (root - b)));
}

// The four nodes around a position in [0, 1], with their weights for cubic interpolation.
struct Cubic {
  size_t first;
  float weight[4];
  Cubic(float position, int size) {
    const float x = std::clamp(position, 0.0f, 1.0f) * float(size - 1);
    const int i = std::clamp(int(x) - 1, 0, size - 4);
    first = size_t(i);
    const float t = x - float(i), t1 = t - 1, t2 = t - 2, t3 = t - 3;
    weight[0] = t1 * t2 * t3 * (-1.0f / 6);
    weight[1] = t * t2 * t3 * 0.5f;
    weight[2] = t * t1 * t3 * -0.5f;
    weight[3] = t * t1 * t2 * (1.0f / 6);
  }
};

struct Quadrature {
  std::array<float, kTurns> cos_phi, sin_phi;  // evenly spaced: the integrand is periodic
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

// Computes E and B for the direction w, as in specular_albedo.cpp.
void integrate(const Quadrature& rule, const Vec3f& w, float ax, float ay, float* e, float* b) {
  const float ax2 = square(ax), ay2 = square(ay), mu = w.z;
  const float t = std::sqrt(ax2 * square(w.x) + ay2 * square(w.y) + square(mu));
  const float s2 = square(1 + std::sqrt(square(w.x) + square(w.y))), narrow2 = std::min(ax2, ay2);
  const float k = (1 - narrow2) * s2 / (s2 + narrow2 * square(mu));
  const float ix = ax * w.x / t, iy = ay * w.y / t, iz = mu / t, bound = k * iz;
  float sum_e = 0, sum_b = 0;
  for (size_t j = 0; j < kPolar; ++j) {
    const float one_minus_z = rule.u[j] * (1 + bound);
    const float z = 1 - one_minus_z, r = safe_sqrt(one_minus_z * (1 + z)), mz = z + iz;
    float row_e = 0, row_b = 0;
    for (size_t i = 0; i < kTurns; ++i) {
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

// Returns the isotropic lobe whose averages approximate those of the anisotropic lobe.
SpecularAlbedo mean_width(float ax, float ay) {
  return SpecularAlbedo(std::sqrt(std::sqrt(0.5f * (square(ax) + square(ay)))));
}

}  // namespace

struct AnisotropicAlbedo::Tables {
  std::array<Node, kPlane * kNarrow * kWide> nodes;  // [alpha_y][alpha_x][azimuth][cosine]
  // Averages over the hemisphere, relative to the isotropic lobe of mean_width(): the loss divided
  // by that lobe's loss, and the Schlick part minus that lobe's Schlick part.
  std::array<Node, size_t(kNarrow* kWide)> averages = {};

  Tables() {
    const Quadrature rule;
    std::vector<Node> built(kPlane * kNarrowBuilt * kWideBuilt);
    for (int j = 0; j < kNarrowBuilt; ++j)
      for (int i = 0; i < kWideBuilt; ++i) {
        const float ay = narrow_at(position_of(j, kNarrowBuilt));
        const float ax = wide_at(position_of(i, kWideBuilt), ay);
        fill(rule, ax, ay, built.data() + size_t(j * kWideBuilt + i) * kPlane);
      }
    for (int j = 0; j < kNarrow; ++j)
      for (int i = 0; i < kWide; ++i)
        refine(built, Cubic(position_of(j, kNarrow), kNarrowBuilt),
               Cubic(position_of(i, kWide), kWideBuilt),
               nodes.data() + size_t(j * kWide + i) * kPlane);
    for (int j = 0; j < kNarrow; ++j)
      for (int i = 0; i < kWide; ++i) {
        const float ay = narrow_at(position_of(j, kNarrow));
        averages[size_t(j * kWide + i)] = average(wide_at(position_of(i, kWide), ay), ay);
      }
  }

  static void refine(const std::vector<Node>& built, const Cubic& narrow, const Cubic& wide,
                     Node* out) {
    for (size_t n = 0; n < kPlane; ++n) {
      out[n] = {0, 0};
      for (size_t j = 0; j < 4; ++j)
        for (size_t i = 0; i < 4; ++i) {
          const float weight = narrow.weight[j] * wide.weight[i];
          const Node& from = built[((narrow.first + j) * kWideBuilt + wide.first + i) * kPlane + n];
          out[n].loss = fma(weight, from.loss, out[n].loss);
          out[n].rest = fma(weight, from.rest, out[n].rest);
        }
    }
  }

  static void fill(const Quadrature& rule, float ax, float ay, Node* out) {
    for (int v = 0; v < kAzimuths; ++v) {
      const float cos2 = cos2_at(v, ax, ay);
      const float alpha = std::sqrt(lerp(square(ay), square(ax), cos2));
      const SpecularAlbedo isotropic(std::sqrt(alpha));
      for (int c = 0; c < kCosines; ++c, ++out) {
        *out = {0, 0};
        if (!(ax > ay * 1.00001f)) continue;
        const float mu = std::max(1e-7f, cosine_at(c, alpha)), sine = safe_sqrt(1 - square(mu));
        float e, b;
        integrate(rule, Vec3f(std::sqrt(cos2) * sine, std::sqrt(1 - cos2) * sine, mu), ax, ay, &e,
                  &b);
        const SpecularAlbedo::Value base = isotropic.at(mu);
        const float m5 = pow5(1 - mu);
        *out = {1 - e - base.loss, (b - m5 * e) - (base.schlick - m5 * (1 - base.loss))};
      }
    }
  }

  // Returns the cosine-weighted means of at() over the hemisphere, relative to the lobe of
  // mean_width(). The quadrature nodes are spread over log(cosine) and over a stretched azimuth, so
  // that narrow features and the rest of the hemisphere both get nodes. The azimuth is stretched by
  // sqrt(ax / ay).
  Node average(float ax, float ay) const {
    if (!(ax > ay * 1.00001f)) return {1, 0};
    static const GaussLegendre<32> cosines;
    static const GaussLegendre<16> azimuths;
    const AnisotropicAlbedo one(ax, ay, *this);
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
    const SpecularAlbedo isotropic = mean_width(ax, ay);
    return {float(loss / area) / isotropic.average_loss(),
            float(schlick / area) - isotropic.average_schlick()};
  }
};

const AnisotropicAlbedo::Tables& AnisotropicAlbedo::tables() {
  static const auto instance = std::make_unique<const Tables>();
  return *instance;
}

AnisotropicAlbedo::AnisotropicAlbedo(float alpha_x, float alpha_y, const Tables& tables) {
  const float ay = std::clamp(alpha_y, kMirrorAlpha, 1.0f), ax = std::clamp(alpha_x, ay, 1.0f);
  alpha_x2_ = square(ax);
  alpha_y2_ = square(ay);
  float x = ax, y = ay;
  sums_ = 1;
  for (float& root : roots_y_) {
    root = y;
    sums_ *= x + y;
    x = std::sqrt(x);
    y = std::sqrt(y);
  }
  const TablePosition narrow((roots_y_[2] - kFirstRoot) / (1 - kFirstRoot), kNarrow);
  const TablePosition wide((std::sqrt(ax) - roots_y_[1]) / std::max(1 - roots_y_[1], 1e-6f), kWide);
  const size_t first = narrow.index * kWide + wide.index;
  nodes_ = tables.nodes.data() + first * kPlane;
  narrow_ = narrow.fraction;
  wide_ = wide.fraction;
  const auto blend = [&](float Node::*field) {
    const Node* p = tables.averages.data() + first;
    return lerp(lerp(p[0].*field, p[1].*field, wide_),
                lerp(p[kWide].*field, p[kWide + 1].*field, wide_), narrow_);
  };
  const SpecularAlbedo isotropic = mean_width(ax, ay);
  average_loss_ = blend(&Node::loss) * isotropic.average_loss();
  average_schlick_ = isotropic.average_schlick() + blend(&Node::rest);
}

AnisotropicAlbedo::AnisotropicAlbedo(float alpha_x, float alpha_y)
    : AnisotropicAlbedo(alpha_x, alpha_y, tables()) {}

SpecularAlbedo::Value AnisotropicAlbedo::at(const Vec3f& w) const {
  const float mu = std::clamp(w.z, 0.0f, 1.0f);
  const float x2 = square(w.x), sin2 = fma(w.y, w.y, x2);
  const float cos2 = sin2 > 0 ? x2 / sin2 : 0.5f;
  // Computes the alpha `a` in w's azimuth, and its position between y = alpha_y and x = alpha_x.
  // The position is (a^p - y^p) / (x^p - y^p) with p = 1/8. The code computes it as cos^2 times a
  // ratio of two products of sums. This form follows from a^2 - y^2 = (x^2 - y^2) cos^2, and does
  // not cancel where x approaches y.
  const float alpha = std::sqrt(lerp(alpha_y2_, alpha_x2_, cos2)), root = std::sqrt(alpha);
  const float root4 = std::sqrt(root), root8 = std::sqrt(root4);
  const float sums =
      (alpha + roots_y_[0]) * (root + roots_y_[1]) * (root4 + roots_y_[2]) * (root8 + roots_y_[3]);
  const Cubic v(cos2 * sums_ / sums, kAzimuths);
  const Cubic x(cosine_coordinate(mu, alpha), kCosines);

  // Processes four neighbours along the cosine at once, with loss and rest interleaved.
  using Float8 [[gnu::vector_size(32)]] = float;
  Float8 sum = {};
  const Node* start = nodes_ + v.first * kCosines + x.first;
  const float weights[4] = {(1 - narrow_) * (1 - wide_), (1 - narrow_) * wide_,
                            narrow_ * (1 - wide_), narrow_ * wide_};
  for (size_t corner = 0; corner < 4; ++corner) {
    const Node* p = start + (corner / 2 * kWide + corner % 2) * kPlane;
    Float8 row = {};
    for (size_t k = 0; k < 4; ++k) {
      Float8 four;
      std::memcpy(&four, p + k * kCosines, sizeof(four));
      row += four * v.weight[k];
    }
    sum += row * weights[corner];
  }
  float more_loss = 0, rest = 0;
  for (int i = 0; i < 4; ++i) {
    more_loss = fma(x.weight[i], sum[2 * i], more_loss);
    rest = fma(x.weight[i], sum[2 * i + 1], rest);
  }
  const SpecularAlbedo::Value base = SpecularAlbedo(root).at(mu);
  const float loss = std::clamp(base.loss + more_loss, 0.0f, 1.0f);
  // base.schlick contains (1 - mu)^5 E, where E is that of the isotropic lobe. The next line
  // replaces this E by that of the anisotropic lobe.
  return {loss, std::clamp(fma(pow5(1 - mu), base.loss - loss, base.schlick + rest), 0.0f, 1.0f)};
}

}  // namespace emberline
