#include "renderer/lights/environment_light.h"

#include <Imath/half.h>

#include <cassert>
#include <cstring>

#include "renderer/core/constants.h"
#include "renderer/core/parallel.h"
#include "renderer/core/warps.h"
#include "renderer/lights/fast_angle.h"
#include "renderer/lights/fixed_cdf.h"
#include "renderer/scene/scene_description.h"

namespace emberline {
namespace {

// Keeps a density finite at the poles, where a row of the map shrinks to a point: below any angle
// that a float direction can tell from the pole.
constexpr float kLeastSine = 1e-7f;

template <class Texel>
Rgb load(const Texel* texel) {
  return {float(texel[0]), float(texel[1]), float(texel[2])};
}

template <class Texel>
Rgb load(const void* texels, size_t index) {
  return load(static_cast<const Texel*>(texels) + 3 * index);
}

// A limit that also catches what is not a number, before it becomes an integer.
float at_least(float x, float limit) { return x > limit ? x : limit; }

// Inverse of the tent's running integral, r in [0, 1), to [-1, 1].
float sample_tent(float r) {
  return r < 0.5f ? std::sqrt(2.0f * r) - 1.0f : 1.0f - std::sqrt(2.0f * (1.0f - r));
}

// Where in t a row's influence lies, relative to its centre. Rows clamp, so the first and the last
// are 1 from the edge of the map to their centre: half of their mass, and half a tent the rest.
float sample_row_shape(int row, int height, float r) {
  const bool first = row == 0, last = row == height - 1;
  if ((first && r < 0.5f) || (last && r >= 0.5f)) return r - 0.5f;
  return sample_tent(r);
}

// Integral of a row's influence times sin theta, in radians: what solid angle it stands for,
// divided by a column's width. Closed form of the tent (interior) and of the clamped half tents.
double row_weight(int row, int height) {
  const double step = kPiD / height;
  if (height == 1) return 2.0;
  if (row == 0 || row == height - 1)
    return 1.0 - (std::sin(1.5 * step) - std::sin(0.5 * step)) / step;
  const double half_sine = std::sin(0.5 * step);
  return std::sin((row + 0.5) * step) * 4.0 * half_sine * half_sine / step;
}

}  // namespace

EnvironmentLight::EnvironmentLight(const Rgb& constant)
    : constant_(constant), mean_luminance_(luminance(constant)) {}

EnvironmentLight::EnvironmentLight(std::shared_ptr<const Image> image, float strength,
                                   float rotation_degrees, const EnvironmentLightSettings& settings)
    : image_(std::move(image)), strength_(strength) {
  assert(image_ && image_->channels == 3 && image_->width > 0 && image_->height > 0);
  assert(image_->type == TexelType::kHalf || image_->type == TexelType::kFloat);
  width_ = image_->width;
  height_ = image_->height;
  half_ = image_->type == TexelType::kHalf;
  texels_ = image_->texels.data();
  // Turning the map by +90 degrees brings what was at +X (phi = 0) to -Z (phi = -90): a direction
  // looks up the angle phi + rotation. The offset is in [0, width), so that columns are within
  // one width of the map on either side.
  double turns = 0.5 + double(rotation_degrees) / 360.0;
  turns -= std::floor(turns);
  column_scale_ = float(width_ / (2.0 * kPiD));
  column_offset_ = float(turns * width_ - 0.5);
  row_scale_ = float(height_ / kPiD);
  build_tables(settings.mis_compensation);
}

EnvironmentLight::~EnvironmentLight() = default;

void EnvironmentLight::build_tables(float mis_compensation) {
  const size_t width = size_t(width_), height = size_t(height_);
  column_bits_ = guide_bits(width);
  row_bits_ = guide_bits(height);
  column_guide_words_ = guide_words(width);

  const auto texel_luminance = [this, width](size_t row, size_t column) {
    const size_t index = row * width + column;
    return double(luminance(half_ ? load<half>(texels_, index) : load<float>(texels_, index)));
  };
  const auto for_rows = [height](const auto& body) {
    parallel_ranges(height, 16, [&](size_t begin, size_t end) {
      for (size_t row = begin; row < end; ++row) body(row);
    });
  };

  // Each row is summed in order by one thread, and the rows in order by this one: the tables are
  // the same for any number of threads.
  std::vector<double> row_sum(height);
  for_rows([&](size_t row) {
    double sum = 0;
    for (size_t column = 0; column < width; ++column) sum += texel_luminance(row, column);
    row_sum[row] = sum;
  });
  double sum = 0, solid = 0;
  for (size_t row = 0; row < height; ++row) {
    sum += row_sum[row] * row_weight(int(row), height_);
    solid += row_weight(int(row), height_) * double(width);
  }
  const double mean = sum / solid;
  mean_luminance_ = mean * strength_;
  if (!(mean_luminance_ > 0)) {
    mean_luminance_ = 0;
    return;
  }

  column_sums_.resize(height * (width + 1));
  column_guides_.resize(height * column_guide_words_);
  row_sums_.resize(height + 1);
  row_guide_.resize(guide_words(height));
  double total = 0;
  for (double factor : {double(mis_compensation), 0.0}) {
    const double threshold = factor * mean;
    for_rows([&](size_t row) {
      std::vector<double> weights(width);
      double row_total = 0;
      for (size_t column = 0; column < width; ++column) {
        weights[column] = std::max(0.0, texel_luminance(row, column) - threshold);
        row_total += weights[column];
      }
      row_sum[row] = row_total * row_weight(int(row), height_);
      build_fixed_cdf(weights, &column_sums_[row * (width + 1)],
                      &column_guides_[row * column_guide_words_]);
    });
    total = 0;
    for (double row_total : row_sum) total += row_total;
    // Nothing is brighter than the mean (a constant map): sample it as it is. Below a millionth
    // it is rounding of the mean that stands out, not light.
    if (total > 1e-6 * sum) break;
  }
  build_fixed_cdf(row_sum, row_sums_.data(), row_guide_.data());

  // In texel coordinates the density is (row probability) x (column probability), interpolated;
  // ds dt = width height / (2 pi^2 sin theta) d omega.
  row_density_.resize(height);
  const double steps = double(kCdfTotal);
  const double scale = double(width) * double(height) / (2.0 * kPiD * kPiD) / (steps * steps);
  for (size_t row = 0; row < height; ++row)
    row_density_[row] = float(double(row_sums_[row + 1] - row_sums_[row]) * scale);
}

EnvironmentLight::Place EnvironmentLight::place(const Vec3f& d) const {
  const float sin_theta = std::sqrt(d.x * d.x + d.z * d.z);
  // acos(y) would lose the rows near the poles: its error there is the root of a float's.
  const float theta = fast_atan2(sin_theta, d.y);
  const float phi = fast_atan2(d.z, d.x);
  const float column = at_least(phi * column_scale_ + column_offset_, -float(width_));
  const float row = at_least(theta * row_scale_ - 0.5f, -1.0f);
  const float column_floor = std::floor(column), row_floor = std::floor(row);
  Place p;
  p.to_column1 = column - column_floor;
  p.to_row1 = row - row_floor;
  p.sin_theta = sin_theta;
  int c = int(column_floor);
  c += c < 0 ? width_ : 0;
  c -= c >= width_ ? width_ : 0;
  p.column0 = std::clamp(c, 0, width_ - 1);
  p.column1 = p.column0 + 1 == width_ ? 0 : p.column0 + 1;
  const int r = int(row_floor);
  p.row0 = std::clamp(r, 0, height_ - 1);
  p.row1 = std::clamp(r + 1, 0, height_ - 1);
  return p;
}

namespace {

template <class Texel>
Rgb bilinear(const void* texels, int width, int column0, int column1, int row0, int row1, float s,
             float t) {
  const Texel* const upper = static_cast<const Texel*>(texels) + 3 * size_t(row0) * size_t(width);
  const Texel* const lower = static_cast<const Texel*>(texels) + 3 * size_t(row1) * size_t(width);
  // Products, not differences: a weight of -1e-8 beside a sun would be negative light.
  return load(upper + 3 * column0) * ((1.0f - s) * (1.0f - t)) +
         load(upper + 3 * column1) * (s * (1.0f - t)) +
         load(lower + 3 * column0) * ((1.0f - s) * t) + load(lower + 3 * column1) * (s * t);
}

}  // namespace

Rgb EnvironmentLight::radiance_at(const Place& p) const {
  const Rgb value = half_ ? bilinear<half>(texels_, width_, p.column0, p.column1, p.row0, p.row1,
                                           p.to_column1, p.to_row1)
                          : bilinear<float>(texels_, width_, p.column0, p.column1, p.row0, p.row1,
                                            p.to_column1, p.to_row1);
  return value * strength_;
}

float EnvironmentLight::pdf_at(const Place& p) const {
  const size_t stride = size_t(width_) + 1;
  const uint32_t* const upper = &column_sums_[size_t(p.row0) * stride];
  const uint32_t* const lower = &column_sums_[size_t(p.row1) * stride];
  const auto steps = [&p](const uint32_t* sums) {
    return lerp(float(sums[p.column0 + 1] - sums[p.column0]),
                float(sums[p.column1 + 1] - sums[p.column1]), p.to_column1);
  };
  const float density = lerp(row_density_[size_t(p.row0)] * steps(upper),
                             row_density_[size_t(p.row1)] * steps(lower), p.to_row1);
  return density / std::max(p.sin_theta, kLeastSine);
}

Rgb EnvironmentLight::radiance(const Vec3f& direction) const {
  return image_ ? radiance_at(place(direction)) : constant_;
}

float EnvironmentLight::pdf(const Vec3f& direction) const {
  if (black()) return 0.0f;
  return image_ ? pdf_at(place(direction)) : square_to_sphere_pdf(direction);
}

Rgb EnvironmentLight::radiance_and_pdf(const Vec3f& direction, float* pdf) const {
  if (!image_ || black()) {
    *pdf = black() ? 0.0f : square_to_sphere_pdf(direction);
    return constant_;
  }
  const Place p = place(direction);
  *pdf = pdf_at(p);
  return radiance_at(p);
}

EnvironmentSample EnvironmentLight::sample(const Vec2f& u) const {
  if (black()) return {};
  if (!image_) {
    const Vec3f w = square_to_sphere(u);
    return {w, constant_, square_to_sphere_pdf(w)};
  }
  const CdfChoice row = choose_entry(row_sums_.data(), row_guide_.data(), row_bits_, u.y);
  const CdfChoice column =
      choose_entry(&column_sums_[row.index * (size_t(width_) + 1)],
                   &column_guides_[row.index * column_guide_words_], column_bits_, u.x);
  const float s = float(column.index) + sample_tent(column.remainder);
  const float t = float(row.index) + sample_row_shape(int(row.index), height_, row.remainder);
  const float theta = (t + 0.5f) / row_scale_;
  const float phi = (s - column_offset_) / column_scale_;
  const float sin_theta = std::sin(theta);
  const Vec3f w(sin_theta * std::cos(phi), std::cos(theta), sin_theta * std::sin(phi));
  // Looked up again from the rounded direction, so that radiance and density are those that a ray
  // along it would find, to the bit.
  EnvironmentSample result;
  result.direction = w;
  result.radiance = radiance_and_pdf(w, &result.pdf);
  return result;
}

float EnvironmentLight::power(float scene_radius) const {
  return float(mean_luminance_ * 4.0 * kPiD * kPiD * square(double(scene_radius)));
}

uint64_t EnvironmentLight::bytes() const {
  const size_t words = column_sums_.size() + column_guides_.size() + row_sums_.size() +
                       row_guide_.size() + row_density_.size();
  return words * sizeof(uint32_t) + (image_ ? image_->texels.size() : 0);
}

}  // namespace emberline
