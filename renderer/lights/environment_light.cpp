#include "renderer/lights/environment_light.h"

#include <Imath/half.h>
#ifdef __F16C__
#include <immintrin.h>
#endif

#include <cassert>
#include <cstring>
#include <limits>

#include "renderer/core/branch_free.h"
#include "renderer/core/color4.h"
#include "renderer/core/constants.h"
#include "renderer/core/fast_angle.h"
#include "renderer/core/memory_budget.h"
#include "renderer/core/parallel.h"
#include "renderer/core/ray.h"
#include "renderer/core/warps.h"
#include "renderer/description/scene_description.h"
#include "renderer/lights/fixed_cdf.h"

namespace emberline {
namespace {

// Lower limit of sin theta, which keeps the density finite at the poles, where a row of the map
// shrinks to a point.
constexpr float kMinSine = 1e-7f;

// Angles are computed in groups of this size, because a loop of fixed length vectorises.
constexpr size_t kGroup = 8;
static_assert(kRayBatch % kGroup == 0);

Color4 load(const float* texel) { return Color4{texel[0], texel[1], texel[2], 0.0f}; }

Color4 load(const half* texel) {
#ifdef __F16C__
  // Use two loads, since a copy of six bytes through memory would stall on store forwarding.
  uint32_t red_green;
  uint16_t blue;
  std::memcpy(&red_green, texel, sizeof red_green);
  std::memcpy(&blue, texel + 2, sizeof blue);
  const uint64_t bits = red_green | uint64_t(blue) << 32;
  return Color4(_mm_cvtph_ps(_mm_cvtsi64_si128(int64_t(bits))));
#else
  return Color4{float(texel[0]), float(texel[1]), float(texel[2]), 0.0f};
#endif
}

template <class Texel>
Color4 load(const void* texels, size_t index) {
  return load(static_cast<const Texel*>(texels) + 3 * index);
}

// Returns max(x, limit), or limit for NaN, so that the result can be converted to an integer.
float clamp_below(float x, float limit) { return x > limit ? x : limit; }

// Samples a tent filter, by the inverse of its integral. Maps r in [0, 1) to [-1, 1].
float sample_tent(float r) {
  return r < 0.5f ? std::sqrt(2.0f * r) - 1.0f : 1.0f - std::sqrt(2.0f * (1.0f - r));
}

// Samples an offset from the row's centre, in units of rows, in proportion to the row's bilinear
// weight. The weight is a tent, but in the first and last row it is 1 between the map's edge and
// the row's centre. Each side of the centre is chosen with probability 1/2.
float sample_row_shape(int row, int height, float r) {
  const bool first = row == 0, last = row == height - 1;
  if ((first && r < 0.5f) || (last && r >= 0.5f)) return r - 0.5f;
  return sample_tent(r);
}

// Returns the integral of a row's bilinear weight times sin theta, which is the row's solid angle
// divided by 2 pi. The weight of an interior row is a tent. In the first and the last row, the tent
// is clamped at the map's edge, and the closed form differs.
double row_weight(int row, int height) {
  const double step = kPiD / height;
  if (height == 1) return 2.0;
  if (row == 0 || row == height - 1)
    return 1.0 - (std::sin(1.5 * step) - std::sin(0.5 * step)) / step;
  const double half_sine = std::sin(0.5 * step);
  return std::sin((row + 0.5) * step) * 4.0 * half_sine * half_sine / step;
}

// The coefficient of limb darkening, which is modelled as linear in the cosine. The value 0.6 is
// that of the sun in green light (C. Allen, "Astrophysical Quantities", 1973).
constexpr float kLimbDarkening = 0.6f;

constexpr size_t kRowGrain = 16;

}  // namespace

EnvironmentLight::EnvironmentLight(const Rgb& constant, const EnvironmentLightSettings& settings)
    : map_constant_(constant), map_mean_luminance_(luminance(constant)) {
  if (settings.to_working) to_working_ = *settings.to_working;
  adjust({});
}

EnvironmentLight::EnvironmentLight(std::shared_ptr<const Image> image, float strength,
                                   float rotation_degrees, const EnvironmentLightSettings& settings)
    : image_(std::move(image)),
      sun_disc_(settings.sun ? std::make_shared<const SunDisc>(*settings.sun) : nullptr) {
  assert(image_ && image_->channels == 3 && image_->width > 0 && image_->height > 0);
  assert(image_->type == TexelType::kHalf || image_->type == TexelType::kFloat);
  if (settings.to_working) to_working_ = *settings.to_working;
  width_ = image_->width;
  height_ = image_->height;
  half_ = image_->type == TexelType::kHalf;
  texels_ = image_->texels.data();
  column_scale_ = float(width_ / (2.0 * kPiD));
  row_scale_ = float(height_ / kPiD);
  build_tables(settings.mis_compensation);
  if (sun_disc_) choose_sun_share();
  adjust({strength, Rgb(1.0f), rotation_degrees});
}

EnvironmentLight::~EnvironmentLight() = default;

uint64_t EnvironmentLight::table_bytes(const Image& image) {
  return bytes_of(bytes_of(uint64_t(image.width), uint64_t(image.height)), 2 * sizeof(uint32_t));
}

void EnvironmentLight::adjust(const EnvironmentAdjustment& adjustment) {
  adjustment_ = adjustment;
  const auto& [strength, tint, rotation_degrees] = adjustment;
  factor_ = color4(tint * strength);
  constant_ = to_working_space(map_constant_ * (tint * strength));
  // `tinted` is the factor by which the tint changes the mean luminance of a grey map. It is
  // exactly 1 without a tint. The mean decides only how often this light is chosen, so the exact
  // mean of a coloured map is not worth another pass over its texels.
  const double tinted = double(luminance(tint)) / double(luminance(Rgb(1.0f)));
  mean_luminance_ = std::min(map_mean_luminance_ * double(strength) * tinted,
                             double(std::numeric_limits<float>::max()));
  if (!(mean_luminance_ > 0)) mean_luminance_ = 0;
  // Rotating the map by +90 degrees moves +X (phi = 0) to -Z (phi = -90), so lookups use phi +
  // rotation. The offset is in [-0.5, width - 0.5), so columns are at most one width off the map.
  double turns = 0.5 + double(rotation_degrees) / 360.0;
  turns -= std::floor(turns);
  column_offset_ = float(turns * width_ - 0.5);
  if (sun_.share > 0.0f) update_sun();
}

// Chooses the sun's share of the samples. It is a power of two, because such a share divides
// (0, 2)-sequences exactly.
void EnvironmentLight::choose_sun_share() {
  const double sun = double(luminance(sun_disc_->irradiance)), sky = kPiD * map_mean_luminance_;
  if (!(sun > 0) || !(sky > 0)) return;  // in front of a black map, the sun is ignored
  double share = 0.5;
  while (share > 1e-3 && 0.5 * share * (sun + sky) > sun) share *= 0.5;
  sun_.share = float(share);
  map_mean_luminance_ += sun / (4 * kPiD);
}

void EnvironmentLight::update_sun() {
  const double turned = -double(adjustment_.rotation_degrees) / 180.0 * kPiD;
  const double c = std::cos(turned), s = std::sin(turned);
  const Vec3d d = to_double(sun_disc_->direction);
  sun_.direction = to_float(Vec3d(c * d.x - s * d.z, d.y, s * d.x + c * d.z).normalized());
  sun_.frame = ShadingFrame::from_normal(sun_.direction);
  const double half_chord = std::sin(0.5 * double(sun_disc_->radius));
  sun_.radius2 = float(4 * square(half_chord));
  const double solid_angle = 4 * kPiD * square(half_chord);
  sun_.density = float(1 / solid_angle);
  sun_.center_radiance =
      to_working_space(sun_disc_->irradiance * (adjustment_.tint * adjustment_.strength)) *
      float(1 / (solid_angle * (1 - double(kLimbDarkening) / 3)));
}

Rgb EnvironmentLight::sun_radiance(const Vec3f& direction) const {
  // Use chords, since a cosine would be too imprecise for angles this small.
  const float out = (direction - sun_.direction).length2() / sun_.radius2;
  if (direction.y < 0.0f) return Rgb(0.0f);
  return sun_.center_radiance *
         (1.0f - kLimbDarkening * (1.0f - std::sqrt(std::max(0.0f, 1.0f - out))));
}

void EnvironmentLight::add_sun(std::span<const Vec3f> directions, Rgb* radiance, float* pdf) const {
  for (size_t i = 0; i < directions.size(); ++i) {
    if (pdf) pdf[i] *= 1.0f - sun_.share;
    if (!((directions[i] - sun_.direction).length2() < sun_.radius2)) continue;
    radiance[i] += sun_radiance(directions[i]);
    if (pdf) pdf[i] += sun_.share * sun_.density;
  }
}

float EnvironmentLight::texel_luminance(size_t row, size_t column) const {
  const size_t index = row * size_t(width_) + column;
  return luminance(to_rgb(half_ ? load<half>(texels_, index) : load<float>(texels_, index)));
}

// Each row is summed in order by one thread, and the sums are added in order by the caller, so the
// tables do not depend on the number of threads.
double EnvironmentLight::build_columns(std::vector<double>* row_totals) {
  const size_t width = size_t(width_);
  parallel_each(size_t(height_), kRowGrain, [&](size_t row) {
    std::vector<double> weights(width);
    double row_total = 0;
    for (size_t column = 0; column < width; ++column) {
      weights[column] = double(weight(texel_luminance(row, column)));
      row_total += weights[column];
    }
    (*row_totals)[row] = row_total * row_weight(int(row), height_);
    build_fixed_cdf(weights, &column_sums_[row * (width + 1)],
                    &column_guides_[row * column_guide_words_]);
  });
  double total = 0;
  for (double row_total : *row_totals) total += row_total;
  return total;
}

void EnvironmentLight::build_tables(float mis_compensation) {
  const size_t width = size_t(width_), height = size_t(height_);
  column_bits_ = guide_bits(width);
  row_bits_ = guide_bits(height);
  column_guide_words_ = guide_words(width);

  std::vector<double> row_sum(height);
  parallel_each(size_t(height_), kRowGrain, [&](size_t row) {
    double sum = 0;
    for (size_t column = 0; column < width; ++column) sum += double(texel_luminance(row, column));
    row_sum[row] = sum;
  });
  double sum = 0, solid = 0;
  for (size_t row = 0; row < height; ++row) {
    sum += row_sum[row] * row_weight(int(row), height_);
    solid += row_weight(int(row), height_) * double(width);
  }
  const double mean = sum / solid;
  if (!(mean > 0)) return;
  map_mean_luminance_ = mean;

  column_sums_.resize(height * (width + 1));
  column_guides_.resize(height * column_guide_words_);
  row_sums_.resize(height + 1);
  row_guide_.resize(guide_words(height));
  // Scale weights by a power of two to about 1, so that densities stay within float's range.
  weight_scale_ = std::ldexp(1.0f, std::clamp(-std::ilogb(mean), -126, 126));
  threshold_ = float(double(mis_compensation) * mean * double(weight_scale_));
  double total = build_columns(&row_sum);
  // If no texel is brighter than the mean, the map is constant and is sampled without compensation.
  // An excess below a millionth is only a rounding error of the mean.
  if (!(total > 1e-6 * sum * double(weight_scale_))) {
    threshold_ = 0.0f;
    total = build_columns(&row_sum);
  }
  build_fixed_cdf(row_sum, row_sums_.data(), row_guide_.data());

  // In texel coordinates (s, t), the density is (row probability) x (column probability),
  // interpolated. It is converted to solid angle by ds dt = width height / (2 pi^2 sin theta) d
  // omega.
  row_density_.resize(height);
  const double scale = double(width) * double(height) / (2.0 * kPiD * kPiD) / total;
  for (size_t row = 0; row < height; ++row)
    row_density_[row] = float(row_weight(int(row), height_) * scale);
}

void EnvironmentLight::find_taps(size_t count, const float* column, const float* row,
                                 BilinearTaps* out) const {
  for (size_t first = 0; first < count; first += kGroup) {
    for (size_t i = first; i < first + kGroup; ++i) {
      const float column_floor = std::floor(column[i]), row_floor = std::floor(row[i]);
      out->to_column1[i] = column[i] - column_floor;
      out->to_row1[i] = row[i] - row_floor;
      int c = int(column_floor);
      c += c < 0 ? width_ : 0;
      c -= c >= width_ ? width_ : 0;
      c = std::clamp(c, 0, width_ - 1);
      out->column0[i] = c;
      out->column1[i] = c + 1 == width_ ? 0 : c + 1;
      const int r = int(row_floor);
      out->row0[i] = std::clamp(r, 0, height_ - 1);
      out->row1[i] = std::clamp(r + 1, 0, height_ - 1);
    }
  }
}

void EnvironmentLight::find_taps(std::span<const Vec3f> directions, BilinearTaps* out) const {
  assert(directions.size() <= size_t(kRayBatch));
  alignas(64) float x[kRayBatch] = {}, y[kRayBatch] = {}, z[kRayBatch] = {};
  for (size_t i = 0; i < directions.size(); ++i) {
    x[i] = directions[i].x;
    y[i] = directions[i].y;
    z[i] = directions[i].z;
  }
  const float min_column = -float(width_);
  alignas(64) float column[kRayBatch], row[kRayBatch];
  for (size_t first = 0; first < directions.size(); first += kGroup) {
    for (size_t i = first; i < first + kGroup; ++i) {
      const float sine = std::sqrt(fma(x[i], x[i], z[i] * z[i]));
      // acos(y) would be inaccurate near the poles, where its error is the square root of float's
      // rounding error.
      const float theta = fast_atan2(sine, y[i]);
      const float phi = fast_atan2(z[i], x[i]);
      column[i] = clamp_below(fma(phi, column_scale_, column_offset_), min_column);
      row[i] = clamp_below(fma(theta, row_scale_, -0.5f), -1.0f);
      out->sin_theta[i] = sine;
    }
  }
  find_taps(directions.size(), column, row, out);
}

struct EnvironmentLight::Corners {
  Color4 upper0, upper1, lower0, lower1;

  Color4 interpolate(float s, float t) const {
    // Use products for the weights. A difference could round to -1e-8, which would make the light
    // next to a sun negative.
    const Color4 upper = fma(upper1, s * (1.0f - t), upper0 * ((1.0f - s) * (1.0f - t)));
    return fma(lower1, s * t, fma(lower0, (1.0f - s) * t, upper));
  }
};

EnvironmentLight::Corners EnvironmentLight::corners(const BilinearTaps& p, size_t i) const {
  const size_t upper = size_t(p.row0[i]) * size_t(width_);
  const size_t lower = size_t(p.row1[i]) * size_t(width_);
  const auto fetch = [&]<class Texel>(const Texel*) -> Corners {
    return {load<Texel>(texels_, upper + size_t(p.column0[i])),
            load<Texel>(texels_, upper + size_t(p.column1[i])),
            load<Texel>(texels_, lower + size_t(p.column0[i])),
            load<Texel>(texels_, lower + size_t(p.column1[i]))};
  };
  return half_ ? fetch(static_cast<const half*>(nullptr))
               : fetch(static_cast<const float*>(nullptr));
}

inline void EnvironmentLight::prefetch(const BilinearTaps& p, size_t i) const {
  const size_t texel = 3 * (half_ ? sizeof(half) : sizeof(float));
  const auto* const texels = static_cast<const char*>(texels_);
  for (const int row : {p.row0[i], p.row1[i]}) {
    __builtin_prefetch(texels + texel * (size_t(row) * size_t(width_) + size_t(p.column0[i])));
  }
}

inline EnvironmentLight::CornerWeights EnvironmentLight::weights_of(const Corners& c) const {
  const auto weight_of = [this](Color4 texel) { return weight(luminance(to_rgb(texel))); };
  return {weight_of(c.upper0), weight_of(c.upper1), weight_of(c.lower0), weight_of(c.lower1)};
}

EnvironmentLight::CornerWeights EnvironmentLight::weights_at(const BilinearTaps& p,
                                                             size_t i) const {
  return weights_of(corners(p, i));
}

float EnvironmentLight::density_of(const CornerWeights& weights, const BilinearTaps& p,
                                   size_t i) const {
  const float upper = lerp(weights.upper0, weights.upper1, p.to_column1[i]);
  const float lower = lerp(weights.lower0, weights.lower1, p.to_column1[i]);
  const float density = lerp(row_density_[size_t(p.row0[i])] * upper,
                             row_density_[size_t(p.row1[i])] * lower, p.to_row1[i]);
  return std::max(density, 0.0f) / std::max(p.sin_theta[i], kMinSine);
}

Rgb EnvironmentLight::radiance_at(const BilinearTaps& p, size_t i) const {
  return to_working_space(
      to_rgb(corners(p, i).interpolate(p.to_column1[i], p.to_row1[i]) * factor_));
}

Rgb EnvironmentLight::radiance_and_pdf_at(const BilinearTaps& p, size_t i, float* pdf) const {
  const Corners c = corners(p, i);
  *pdf = density_of(weights_of(c), p, i);
  return to_working_space(to_rgb(c.interpolate(p.to_column1[i], p.to_row1[i]) * factor_));
}

void EnvironmentLight::radiance(std::span<const Vec3f> directions, Rgb* out) const {
  if (!image_) {
    std::fill_n(out, directions.size(), constant_);
    return;
  }
  BilinearTaps taps;
  find_taps(directions, &taps);
  for (size_t i = 0; i < directions.size(); ++i) prefetch(taps, i);
  for (size_t i = 0; i < directions.size(); ++i) {
    out[i] = radiance_at(taps, i);
  }
  if (sun_.share > 0.0f) [[unlikely]]
    add_sun(directions, out, nullptr);
}

void EnvironmentLight::radiance_and_pdf(std::span<const Vec3f> directions, Rgb* radiance,
                                        float* pdf) const {
  BilinearTaps taps;
  radiance_and_pdf(directions, &taps, radiance, pdf);
  if (sun_.share > 0.0f) [[unlikely]]
    add_sun(directions, radiance, pdf);
}

// Excludes the sun.
void EnvironmentLight::radiance_and_pdf(std::span<const Vec3f> directions, BilinearTaps* found,
                                        Rgb* radiance, float* pdf) const {
  if (!image_ || black()) {
    for (size_t i = 0; i < directions.size(); ++i) {
      radiance[i] = constant_;
      pdf[i] = black() ? 0.0f : square_to_sphere_pdf(directions[i]);
    }
    return;
  }
  BilinearTaps& taps = *found;
  find_taps(directions, &taps);
  for (size_t i = 0; i < directions.size(); ++i) prefetch(taps, i);
  for (size_t i = 0; i < directions.size(); ++i) {
    radiance[i] = radiance_and_pdf_at(taps, i, &pdf[i]);
  }
}

Rgb EnvironmentLight::radiance_and_pdf(const Vec3f& direction, float* pdf) const {
  Rgb result;
  radiance_and_pdf({&direction, 1}, &result, pdf);
  return result;
}

void EnvironmentLight::sample(std::span<const Vec2f> u, EnvironmentSample* out) const {
  if (sun_.share > 0.0f) [[unlikely]] {
    sample_sun_or_map(u, out);
  } else {
    sample_map(u, out);
  }
}

void EnvironmentLight::sample_sun_or_map(std::span<const Vec2f> u, EnvironmentSample* out) const {
  if (black()) {
    std::fill_n(out, u.size(), EnvironmentSample{});
    return;
  }
  Vec2f of_map[kRayBatch];
  for (size_t i = 0; i < u.size(); ++i) {
    const float x = (u[i].x - sun_.share) / (1.0f - sun_.share);
    of_map[i] = {std::clamp(x, 0.0f, kOneMinusEpsilon), u[i].y};
  }
  sample_map({of_map, u.size()}, out);
  for (size_t i = 0; i < u.size(); ++i) {
    if (u[i].x >= sun_.share) {
      add_sun({&out[i].direction, 1}, &out[i].radiance, &out[i].pdf);
      continue;
    }
    // A point that is uniform in the squared chord is uniform in solid angle.
    const Vec2f disk = square_to_disk({u[i].x / sun_.share, u[i].y});
    const float chord2 = (disk.x * disk.x + disk.y * disk.y) * sun_.radius2;
    const float aside = std::sqrt(sun_.radius2 * (1.0f - 0.25f * chord2));
    const Vec3f d = sun_.frame.to_world({disk.x * aside, disk.y * aside, 1.0f - 0.5f * chord2});
    out[i].direction = d;
    out[i].radiance = radiance_and_pdf(d, &out[i].pdf);
  }
}

float EnvironmentLight::sample_column(int column, float r) {
  return float(column) + sample_tent(r);
}

float EnvironmentLight::sample_row(int row, float r) const {
  return float(row) + sample_row_shape(row, height_, r);
}

void EnvironmentLight::sample_map(std::span<const Vec2f> u, EnvironmentSample* out) const {
  const size_t count = u.size();
  assert(count <= size_t(kRayBatch));
  if (black() || !image_) {
    for (size_t i = 0; i < count; ++i) {
      const Vec3f w = square_to_sphere(u[i]);
      out[i] =
          black() ? EnvironmentSample{} : EnvironmentSample{w, constant_, square_to_sphere_pdf(w)};
    }
    return;
  }
  CdfChoice rows[kRayBatch];
  const auto sums_of = [&](size_t i) {
    return &column_sums_[rows[i].index * (size_t(width_) + 1)];
  };
  const auto guide_of = [&](size_t i) {
    return &column_guides_[rows[i].index * column_guide_words_];
  };
  for (size_t i = 0; i < count; ++i) {
    rows[i] = choose_entry(row_sums_.data(), row_guide_.data(), row_bits_, u[i].y);
    prefetch_guide(guide_of(i), column_bits_, u[i].x);
  }
  for (size_t i = 0; i < count; ++i) prefetch_sums(sums_of(i), guide_of(i), column_bits_, u[i].x);

  // Evaluate radiance and density at the sampled texel position, not from the direction. Next to a
  // sun, the rounding of a direction would change both by more than the allowed error.
  alignas(64) float column[kRayBatch] = {}, row[kRayBatch] = {};
  for (size_t i = 0; i < count; ++i) {
    const CdfChoice chosen = choose_entry(sums_of(i), guide_of(i), column_bits_, u[i].x);
    const int y = int(rows[i].index);
    column[i] = sample_column(int(chosen.index), chosen.remainder);
    row[i] = sample_row(y, rows[i].remainder);
  }
  BilinearTaps taps;
  sample_taps(count, column, row, &taps, out);
}

void EnvironmentLight::sample_taps(size_t count, const float* column, const float* row,
                                   BilinearTaps* found, EnvironmentSample* out) const {
  BilinearTaps& taps = *found;
  find_taps(count, column, row, &taps);
  for (size_t i = 0; i < count; ++i) prefetch(taps, i);

  alignas(64) float cos_theta[kRayBatch], sin_phi[kRayBatch], cos_phi[kRayBatch];
  for (size_t first = 0; first < count; first += kGroup) {
    for (size_t i = first; i < first + kGroup; ++i) {
      const float turns = (column[i] - column_offset_) / float(width_);
      sincos_turns(turns - std::floor(turns), &sin_phi[i], &cos_phi[i]);
      sincos_turns(0.5f * (row[i] + 0.5f) / float(height_), &taps.sin_theta[i], &cos_theta[i]);
    }
  }
  for (size_t i = 0; i < count; ++i) {
    const float sine = taps.sin_theta[i];
    out[i].direction = Vec3f(sine * cos_phi[i], cos_theta[i], sine * sin_phi[i]);
    taps.sin_theta[i] = std::abs(sine);  // rounding may make it negative at the south pole
    out[i].radiance = radiance_and_pdf_at(taps, i, &out[i].pdf);
  }
}

EnvironmentSample EnvironmentLight::sample(const Vec2f& u) const {
  EnvironmentSample result;
  sample({&u, 1}, &result);
  return result;
}

uint64_t EnvironmentLight::bytes() const {
  const size_t words = column_sums_.size() + column_guides_.size() + row_sums_.size() +
                       row_guide_.size() + row_density_.size();
  return words * sizeof(uint32_t) + (image_ ? image_->texels.size() : 0);
}

}  // namespace emberline
