// A latitude-longitude environment with bilinear radiance and exact importance sampling.
//
// u = 0.5 + atan2(z, x) / 2 pi, v = acos(y) / pi, top row +Y; u wraps, v clamps. Radiance is the
// bilinear interpolation of texels. The sampling density is the bilinear interpolation of per-texel
// weights (luminance x solid angle, MIS-compensated after Karlik et al. 2019, "MIS Compensation:
// Optimizing Sampling Techniques in Multiple Importance Sampling"), so a one-texel sun is sampled
// in proportion to its radiance.
//
// A sun (SunDisc) may be in front of the map: half of the samples go to it, or fewer if it is dim,
// and its density is added to that of the map.
//
// All const functions are pure and thread-safe. Directions are unit vectors in world space.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "renderer/core/color4.h"
#include "renderer/core/colour_matrix.h"
#include "renderer/core/frame.h"
#include "renderer/core/ray.h"
#include "renderer/core/vector.h"

namespace emberline {

struct Image;
struct SunDisc;

struct EnvironmentSample {
  Vec3f direction = Vec3f(0.0f);
  Rgb radiance = Rgb(0.0f);
  float pdf = 0.0f;  // per solid angle; 0: nothing sampled
};

// Factor of MIS compensation: weight = max(0, radiance - factor x mean), so light up to this
// multiple of the mean is left to BSDF sampling. Karlik et al. 2019 derive 1 for MIS with a uniform
// technique, and pbrt-v4 uses it; the best equal mixture with a uniform technique would need 1/2.
// For five HDRIs with Lambertian and glossy surfaces, 1/2, 3/4 and 1 reduced the variance to 0.87,
// 0.86 and 0.86 (tests/bench/results). 1 is best for a sun in an even sky, because the sky is then
// left entirely to BSDF sampling, which has no variance there.
inline constexpr float kMisCompensation = 1.0f;

struct EnvironmentLightSettings {
  // 0 disables compensation. Use 0 if light sampling is the only technique, since a compensated
  // density is 0 in directions darker than the mean.
  float mis_compensation = kMisCompensation;
  const SunDisc* sun = nullptr;              // copied
  const ColourMatrix* to_working = nullptr;  // converts the radiance; copied
};

// Settings that can change without reading the map.
struct EnvironmentAdjustment {
  float strength = 1.0f;
  Rgb tint = Rgb(1.0f);
  float rotation_degrees = 0.0f;
};

class EnvironmentLight {
 public:
  // Constant radiance, which needs no tables and is sampled uniformly over the sphere.
  explicit EnvironmentLight(const Rgb& constant, const EnvironmentLightSettings& settings = {});
  // `image` must be kHalf or kFloat with 3 channels, finite and non-negative (io guarantees this).
  // It is shared, not copied. `rotation_degrees` is as in EnvironmentDescription.
  EnvironmentLight(std::shared_ptr<const Image> image, float strength, float rotation_degrees,
                   const EnvironmentLightSettings& settings = {});
  ~EnvironmentLight();
  // Memory that sampling an image needs in addition to its texels: two numbers per texel.
  static uint64_t table_bytes(const Image& image);

  // Changes strength, tint and rotation. The result is the same to the bit as that of a new light
  // with these settings, but this is cheap, since the tables depend on none of the three. Not
  // thread-safe.
  void adjust(const EnvironmentAdjustment& adjustment);
  const EnvironmentAdjustment& adjustment() const { return adjustment_; }

  // Computes the radiance of at most kRayBatch directions at once, so that the angles vectorise.
  void radiance(std::span<const Vec3f> directions, Rgb* out) const;
  EnvironmentSample sample(const Vec2f& u) const;
  // Up to kRayBatch samples at once, so that cache misses in the large tables overlap.
  void sample(std::span<const Vec2f> u, EnvironmentSample* out) const;
  // Computes both for little more than the cost of one; for rays that leave the scene.
  void radiance_and_pdf(std::span<const Vec3f> directions, Rgb* radiance, float* pdf) const;
  Rgb radiance_and_pdf(const Vec3f& direction, float* pdf) const;

  const Image* image() const { return image_.get(); }              // null: constant
  bool black() const { return mean_luminance_ == 0.0; }            // no radiance anywhere
  float mean_luminance() const { return float(mean_luminance_); }  // over the sphere
  uint64_t bytes() const;                                          // tables and texels

 private:
  friend class EnvironmentGuide;

  // For each direction: the columns and rows of the four texels around it, its fractional position
  // from the first to the second of each, and the sine of its angle to the pole.
  struct BilinearTaps {
    alignas(64) int column0[kRayBatch], column1[kRayBatch], row0[kRayBatch], row1[kRayBatch];
    alignas(64) float to_column1[kRayBatch], to_row1[kRayBatch], sin_theta[kRayBatch];
  };
  // `column` and `row` are texel coordinates: (0, 0) is the centre of the first texel, and columns
  // are in [-width, 2 width). The arrays must have kRayBatch elements; more than `count` are read.
  void find_taps(size_t count, const float* column, const float* row, BilinearTaps* out) const;
  void find_taps(std::span<const Vec3f> directions, BilinearTaps* out) const;
  struct Corners;
  // Weights of the four texels in the density.
  struct CornerWeights {
    float upper0, upper1, lower0, lower1;
  };
  Corners corners(const BilinearTaps& p, size_t i) const;
  CornerWeights weights_of(const Corners& c) const;
  void prefetch(const BilinearTaps& p, size_t i) const;
  Rgb radiance_at(const BilinearTaps& p, size_t i) const;
  CornerWeights weights_at(const BilinearTaps& p, size_t i) const;
  float density_of(const CornerWeights& weights, const BilinearTaps& p, size_t i) const;
  void radiance_and_pdf(std::span<const Vec3f> directions, BilinearTaps* taps, Rgb* radiance,
                        float* pdf) const;
  // Texel coordinates of a sample around the chosen texel, for r in [0, 1).
  static float sample_column(int column, float r);
  float sample_row(int row, float r) const;
  // Converts texel coordinates to samples and their BilinearTaps.
  void sample_taps(size_t count, const float* column, const float* row, BilinearTaps* taps,
                   EnvironmentSample* out) const;
  void sample_map(std::span<const Vec2f> u, EnvironmentSample* out) const;
  void sample_sun_or_map(std::span<const Vec2f> u, EnvironmentSample* out) const;
  // Radiance of the sun in a direction.
  Rgb sun_radiance(const Vec3f& direction) const;
  // Adds the sun to the map's values. `pdf` may be null.
  void add_sun(std::span<const Vec3f> directions, Rgb* radiance, float* pdf) const;
  // Radiance and density of one direction, from the same texels.
  Rgb radiance_and_pdf_at(const BilinearTaps& p, size_t i, float* pdf) const;
  // The sampling weight of a texel with this luminance (of the map, without strength).
  float weight(float luminance) const {
    return std::max(0.0f, luminance * weight_scale_ - threshold_);
  }
  float texel_luminance(size_t row, size_t column) const;
  void build_tables(float mis_compensation);
  void choose_sun_share();
  void update_sun();
  // Builds the tables of columns for the current threshold; returns the sum of the rows' totals.
  double build_columns(std::vector<double>* row_totals);

  // Converts the map's light, with strength and tint, to the working space.
  Rgb to_working_space(const Rgb& light) const {
    if (to_working_) [[unlikely]]
      return *to_working_ * light;
    return light;
  }

  EnvironmentAdjustment adjustment_;
  std::optional<ColourMatrix> to_working_;
  Rgb map_constant_ = Rgb(0.0f);  // radiance if there is no image
  Rgb constant_ = Rgb(0.0f);      // map_constant_ with strength and tint, in the working space
  std::shared_ptr<const Image> image_;
  const void* texels_ = nullptr;
  bool half_ = false;
  int width_ = 0, height_ = 0;
  Color4 factor_ = color4(Rgb(1.0f));  // strength and tint
  float column_scale_ = 0.0f, column_offset_ = 0.0f, row_scale_ = 0.0f;
  double map_mean_luminance_ = 0.0;
  double mean_luminance_ = 0.0;  // with strength and tint

  // Running sums over the columns of each row, width + 1 words per row, and their guide tables;
  // then the running sums over the rows (see fixed_cdf.h). Densities are not read from these tables
  // but computed from the same texels as the radiance: pdf = interpolated (row density x weight) /
  // sin theta. This agrees with the sums up to their step of 2^-32.
  std::vector<uint32_t> column_sums_, column_guides_, row_sums_, row_guide_;
  std::vector<float> row_density_;
  float weight_scale_ = 1.0f, threshold_ = 0.0f;
  int column_bits_ = 0, row_bits_ = 0;
  size_t column_guide_words_ = 0;

  struct Sun {
    Vec3f direction = Vec3f(0.0f);  // in world space
    ShadingFrame frame;
    float radius2 = 0.0f;             // squared chord from the centre of the disc to its edge
    float density = 0.0f;             // pdf of a direction in the disc, per solid angle
    float share = 0.0f;               // fraction of the samples; 0: there is no sun
    Rgb center_radiance = Rgb(0.0f);  // radiance at the centre
  };
  std::shared_ptr<const SunDisc> sun_disc_;
  Sun sun_;
};

}  // namespace emberline
