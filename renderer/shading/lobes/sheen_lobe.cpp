#include "renderer/shading/lobes/sheen_lobe.h"

#include <array>
#include <bit>
#include <vector>

#include "renderer/core/branch_free.h"
#include "renderer/core/constants.h"
#include "renderer/shading/gauss_legendre.h"
#include "renderer/shading/lobes/table_position.h"

namespace emberline {

namespace {

// Table 1 of Estevez & Kulla 2017: log L(x) = a / (1 + b x^c) + d x + e. Each coefficient is
// interpolated between its values at roughness 1 and 0. The value at roughness 0 has the weight
// (1 - alpha)^2.
struct Shadowing {
  double a, b, c, d, e;
  explicit Shadowing(double alpha) {
    const double t = square(1 - alpha);
    const auto mix = [t](double rough, double smooth) { return rough + (smooth - rough) * t; };
    a = mix(21.5473, 25.3245);
    b = mix(3.82987, 3.32435);
    c = mix(0.19823, 0.16801);
    d = mix(-1.97760, -1.27393);
    e = mix(-4.32054, -4.85967);
  }
  double low(double x) const { return a / (1 + b * std::pow(x, c)) + d * x + e; }
  double lambda(double mu) const {
    return std::exp(mu < 0.5 ? low(mu) : 2 * low(0.5) - low(1 - mu));
  }
};

// ---- tables ------------------------------------------------------------------------------------

constexpr int kColumns = 144, kRows = 64;
constexpr int kCosines = 48, kAzimuths = 16;  // quadrature nodes

// The columns are evenly spaced in mu^(1/4), from kSheenMinCosine to 1. The rows are evenly spaced
// in roughness^(1/4), from kSheenMinRoughness to 1.
constexpr float kFirstColumn = 0.1f;
const float kFirstRow = std::sqrt(std::sqrt(kSheenMinRoughness));
static_assert(kSheenMinCosine == 1e-4f);

// Requires a cosine of at least kSheenMinCosine.
TablePosition find_column(float mu) {
  return TablePosition((std::sqrt(std::sqrt(mu)) - kFirstColumn) / (1 - kFirstColumn), kColumns);
}
TablePosition row_of(float roughness) {
  return TablePosition((std::sqrt(std::sqrt(roughness)) - kFirstRow) / (1 - kFirstRow), kRows);
}
double cosine_at(int column) {
  const double x = double(kFirstColumn) + (1 - double(kFirstColumn)) * column / (kColumns - 1);
  return std::min(1.0, square(square(x)));
}
double roughness_at(int row) {
  return square(square(double(kFirstRow) + (1 - double(kFirstRow)) * row / (kRows - 1)));
}

// Returns the s for which the density (1 + s) / (1 + s mu)^2 has the mean `mean`. The mean falls as
// s grows.
double slope_of_mean(double mean) {
  double low = std::log(0.1), high = std::log(1e5);  // log(1 + s)
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high), s = std::expm1(middle);
    const double m =
        std::abs(s) < 1e-3 ? 0.5 - s / 6 : (1 + s) / square(s) * (middle - s / (1 + s));
    (m > mean ? low : high) = middle;
  }
  return std::expm1(0.5 * (low + high));
}

// Returns the distance from 1 within which the corner of max(1, r) is rounded off, because the
// table could not represent a sharp corner. At high roughness, this distance is small, since R is
// at most 0.953 there and the max must remain 1. For narrower lobes, the distance is larger,
// because R is steeper.
float rounding_at(float roughness) {
  return lerp(0.15f, 0.045f, std::clamp((roughness - 0.15f) / (0.285f - 0.15f), 0.0f, 1.0f));
}
float limit(float r, float round) {
  if (r < 1 - round) return 1;
  return r < 1 + round ? 1 + square(r - (1 - round)) / (4 * round) : r;
}

}  // namespace

struct SheenNode {
  float raw;            // R of the published lobe
  float albedo;         // albedo of the limited lobe
  float slope;          // s, see sheen_lobe.h
  float concentration;  // of the azimuth
};

namespace {

// Interpolates bilinearly between the nodes of one row and the next.
[[gnu::always_inline]] inline float blend(const SheenNode* row, float row_fraction,
                                          const TablePosition& column, float SheenNode::*field) {
  const SheenNode* p = row + column.index;
  return lerp(lerp(p[0].*field, p[1].*field, column.fraction),
              lerp(p[kColumns].*field, p[kColumns + 1].*field, column.fraction), row_fraction);
}

// Computes 2^x for x <= 0 to within 1e-7, by a series around the nearest integer. The code has no
// branches, so that it vectorises.
[[gnu::always_inline]] inline float exp2_below_one(float x) {
  x = std::max(x, -126.0f);
  const float whole = std::nearbyint(x), y = (x - whole) * 0.693147181f;
  float e = fma(y, 1.0f / 5040, 1.0f / 720);
  e = fma(y, e, 1.0f / 120);
  e = fma(y, e, 1.0f / 24);
  e = fma(y, e, 1.0f / 6);
  e = fma(y, e, 0.5f);
  e = fma(y, e, 1.0f);
  e = fma(y, e, 1.0f);
  return e * std::bit_cast<float>((int(whole) + 127) << 23);
}

// A quadrature rule over the incident cosine mu and the azimuth. It yields the mean over the
// azimuth. For mu, it substitutes mu = t^4, because the shadowing is steep at 0.
struct Quadrature {
  std::array<double, kCosines> mu, sine, weight;
  std::array<TablePosition, kCosines> column;
  std::array<double, kAzimuths> cos_azimuth, azimuth_weight;

  Quadrature() {
    const GaussLegendre<kCosines> cosines;
    const GaussLegendre<kAzimuths> azimuths;
    for (size_t i = 0; i < kCosines; ++i) {
      const double t = cosines.x[i];
      mu[i] = square(square(t));
      sine[i] = std::sqrt(1 - square(mu[i]));
      const double clamped = std::max(mu[i], double(kSheenMinCosine));
      weight[i] = cosines.w[i] * 4 * t * t * t * mu[i] / clamped;
      column[i] = find_column(float(clamped));
    }
    for (size_t j = 0; j < kAzimuths; ++j) {
      cos_azimuth[j] = std::cos(kPiD * azimuths.x[j]);
      azimuth_weight[j] = azimuths.w[j];
    }
  }
};

// For one column, that is, one cosine of wo: `all` is the energy that the lobe returns towards each
// incident cosine, and `along` is the same energy weighted by the cosine of the azimuth.
struct ColumnEnergy {
  std::array<double, kCosines> all, along;
};

class Table {
 public:
  std::array<SheenNode, size_t(kRows* kColumns)> nodes;
  std::array<bool, size_t(kRows)> exceeds_one;

  Table() {
    for (size_t column = 0; column < kColumns; ++column) fill_half_sines(column);
    for (int row = 0; row < kRows; ++row) fill(row);
    half_sines_ = std::vector<HalfSines>();  // {} would keep the memory
  }

 private:
  // log2 of the squared sine of the half vector, which does not depend on the roughness.
  using HalfSines = std::array<std::array<float, kCosines>, kAzimuths>;

  void fill_half_sines(size_t column);
  void fill(int row);
  ColumnEnergy energy_of(size_t column, double alpha) const;

  Quadrature light_;
  std::vector<HalfSines> half_sines_{size_t(kColumns)};
};

void Table::fill_half_sines(size_t column) {
  const double mu = cosine_at(int(column)), sine = std::sqrt(1 - mu * mu);
  for (size_t j = 0; j < kAzimuths; ++j)
    for (size_t i = 0; i < kCosines; ++i) {
      const double h2 = 2 * (1 + mu * light_.mu[i] + sine * light_.sine[i] * light_.cos_azimuth[j]);
      const double sin2 = std::max(0.0, 1 - square(mu + light_.mu[i]) / h2);
      half_sines_[column][j][i] = std::log2(float(sin2));
    }
}

ColumnEnergy Table::energy_of(size_t column, double alpha) const {
  ColumnEnergy energy = {};
  const float exponent = float(0.5 / alpha);
  for (size_t j = 0; j < kAzimuths; ++j) {
    const auto& half_sines = half_sines_[column][j];
    const double w = light_.azimuth_weight[j], along = w * light_.cos_azimuth[j];
    for (size_t i = 0; i < kCosines; ++i) {
      const double value = double(exp2_below_one(exponent * half_sines[i]));
      energy.all[i] += w * value;
      energy.along[i] += along * value;
    }
  }
  return energy;
}

void Table::fill(int row) {
  const double alpha = square(roughness_at(row));
  const float round = rounding_at(float(roughness_at(row)));
  const Shadowing shadowing(alpha);
  SheenNode* out = nodes.data() + size_t(row) * kColumns;
  std::array<double, kCosines> lambda;
  for (size_t i = 0; i < kCosines; ++i)
    lambda[i] = shadowing.lambda(std::max(light_.mu[i], double(kSheenMinCosine)));

  std::array<std::array<double, kCosines>, kColumns> towards;  // energy returned by each column
  exceeds_one[size_t(row)] = false;
  for (size_t column = 0; column < kColumns; ++column) {
    const double mu = cosine_at(int(column)), masking = 1 + shadowing.lambda(mu);
    const ColumnEnergy energy = energy_of(column, alpha);
    double sum = 0, sum_mu = 0, sum_cos = 0;
    for (size_t i = 0; i < kCosines; ++i) {
      const double scale = light_.weight[i] * (2 + 1 / alpha) / (4 * mu * (masking + lambda[i]));
      const double returned = towards[column][i] = energy.all[i] * scale;
      sum += returned;
      sum_mu += returned * light_.mu[i];
      sum_cos += energy.along[i] * scale;
    }
    SheenNode& node = out[column];
    node.raw = float(sum);
    if (sum > double(1 - round)) exceeds_one[size_t(row)] = true;
    // The densities are made wider than the moments suggest, because the lobe has longer tails than
    // these densities. This lowers the variance of the weights.
    node.slope = float(std::pow(1 + slope_of_mean(sum_mu / sum), 0.75) - 1);
    node.concentration = float(0.77 * std::max(0.0, sum_cos / sum));
  }

  std::array<double, kCosines> limits;  // towards each incident cosine
  for (size_t i = 0; i < kCosines; ++i) {
    const TablePosition& p = light_.column[i];
    limits[i] = double(limit(lerp(out[p.index].raw, out[p.index + 1].raw, p.fraction), round));
  }
  for (size_t column = 0; column < kColumns; ++column) {
    const double own = double(limit(out[column].raw, round));
    double sum = 0;
    for (size_t i = 0; i < kCosines; ++i) sum += towards[column][i] / std::max(own, limits[i]);
    out[column].albedo = float(std::min(1.0, sum));
  }
}

const Table& table() {
  static const Table instance;
  return instance;
}

}  // namespace

SheenLobe::SheenLobe(float roughness, const Vec3f& wo) : wo_(wo) {
  if (!(wo.z > 0.0f)) return;
  roughness = std::clamp(roughness, kSheenMinRoughness, 1.0f);
  const float alpha = square(roughness), mu = std::clamp(wo.z, kSheenMinCosine, 1.0f);
  const Shadowing shadowing{double(alpha)};
  a_ = float(shadowing.a);
  b_ = float(shadowing.b);
  c_ = float(shadowing.c);
  d_ = float(shadowing.d);
  e_ = float(shadowing.e);
  twice_middle_ = 2.0f * (a_ / fma(b_, std::pow(0.5f, c_), 1.0f) + fma(d_, 0.5f, e_));
  half_exponent_ = 0.5f / alpha;
  scale_ = (2.0f + 1.0f / alpha) * 0.125f * kInvPi / mu;
  masking_o_ = 1.0f + lambda(mu);
  const float sine = std::sqrt(fma(wo.x, wo.x, square(wo.y)));
  if (sine > 0.0f) axis_ = Vec2f(wo.x / sine, wo.y / sine);

  const Table& t = table();
  const TablePosition row = row_of(roughness), column = find_column(mu);
  row_ = t.nodes.data() + row.index * kColumns;
  row_fraction_ = row.fraction;
  const auto at_wo = [&](float SheenNode::*field) {
    return blend(row_, row_fraction_, column, field);
  };
  slope_ = at_wo(&SheenNode::slope);
  concentration_ = at_wo(&SheenNode::concentration);
  round_ = rounding_at(roughness);
  limit_ = limit(at_wo(&SheenNode::raw), round_);
  exceeds_one_ = t.exceeds_one[row.index] || t.exceeds_one[row.index + 1];
}

float SheenLobe::lambda(float mu) const {
  const bool low = mu < 0.5f;
  const float x = low ? mu : 1.0f - mu;
  const float log_lambda = a_ / fma(b_, std::pow(x, c_), 1.0f) + fma(d_, x, e_);
  return std::exp(low ? log_lambda : twice_middle_ - log_lambda);
}

float SheenLobe::eval(const Vec3f& wi) const {
  if (!(wi.z > 0.0f) || !(scale_ > 0.0f)) return 0.0f;
  // Compute sin^2 of the half vector from its xy: 1 - z^2 would lose digits for narrow lobes.
  const Vec3f h = wo_ + wi;
  const float xy2 = fma(h.x, h.x, square(h.y)), length2 = fma(h.z, h.z, xy2);
  if (!(xy2 > 0.0f)) return 0.0f;
  const float mu = std::clamp(wi.z, kSheenMinCosine, 1.0f);
  const float distribution = std::pow(xy2 / length2, half_exponent_);
  float value = scale_ * distribution / (masking_o_ + lambda(mu)) * (wi.z / mu);
  if (exceeds_one_) {
    const float raw = blend(row_, row_fraction_, find_column(mu), &SheenNode::raw);
    value /= std::max(limit_, limit(raw, round_));
  }
  return value;
}

float SheenLobe::pdf(const Vec3f& wi) const {
  if (!(wi.z > 0.0f) || !(scale_ > 0.0f)) return 0.0f;
  const float sine = std::sqrt(fma(wi.x, wi.x, square(wi.y)));
  const float cos_phi = sine > 0.0f ? fma(wi.x, axis_.x, wi.y * axis_.y) / sine : 0.0f;
  const float r = concentration_, r2 = square(r);
  const float azimuth = (1.0f - r2) / fma(-2.0f * r, cos_phi, 1.0f + r2);
  return 0.5f * kInvPi * azimuth * (1.0f + slope_) / square(fma(slope_, wi.z, 1.0f));
}

Vec3f SheenLobe::sample(const Vec2f& u) const {
  const float z = (1.0f - u.y) / fma(slope_, u.y, 1.0f);
  const float sine = std::sqrt((1.0f - z) * (1.0f + z));
  // A Moebius map of the unit circle maps uniform angles to the wrapped Cauchy distribution
  // (McCullagh 1996, "Moebius Transformation and Cauchy Parameter Estimation").
  float sin_phi, cos_phi;
  sincos_turns(u.x, &sin_phi, &cos_phi);
  const float r = concentration_, r2 = square(r);
  const float inverse = sine / fma(2.0f * r, cos_phi, 1.0f + r2);
  const float x = fma(1.0f + r2, cos_phi, 2.0f * r) * inverse, y = (1.0f - r2) * sin_phi * inverse;
  return {fma(x, axis_.x, -(y * axis_.y)), fma(x, axis_.y, y * axis_.x), z};
}

TablePosition SheenLobe::column_of(float mu) {
  return find_column(std::clamp(mu, kSheenMinCosine, 1.0f));
}

float SheenLobe::albedo(const TablePosition& column) const {
  return blend(row_, row_fraction_, column, &SheenNode::albedo);
}

}  // namespace emberline
