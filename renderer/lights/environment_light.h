// A latitude-longitude environment with bilinear radiance and exact importance sampling.
//
// u = 0.5 + atan2(z, x) / 2 pi, v = acos(y) / pi, top row +Y; u wraps, v clamps. Radiance is the
// bilinear interpolation of texels. The sampling density is the bilinear interpolation of per-texel
// weights (luminance x solid angle, MIS-compensated after Karlik et al. 2019, "MIS Compensation:
// Optimizing Sampling Techniques in Multiple Importance Sampling"), so a one-texel sun is sampled
// in proportion to its radiance.
//
// A sun (SunDisc) may be in front of the map: half of the samples go to it, fewer if it is dim, and
// its density is added to the map's.
//
// All functions are const, pure and thread-safe. Directions are unit, in world space.
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

// Multiple of the mean radiance that the weights leave to BSDF sampling: weight = max(0, radiance -
// factor x mean). Karlik et al. 2019 derive 1 in combination with a uniform technique, and pbrt-v4
// uses it; the best equal mixture with one would give 1/2. Over five HDRIs, Lambertian and glossy,
// 1/2, 3/4 and 1 left 0.87, 0.86 and 0.86 of the variance (tests/bench/results). 1 is best for a
// sun in an even sky, because the sky is then left entirely to the BSDF, which has no variance
// there.
inline constexpr float kMisCompensation = 1.0f;

struct EnvironmentLightSettings {
  // 0 disables compensation. This is needed if light sampling is the only technique, since a
  // compensated density is 0 in directions darker than the mean.
  float mis_compensation = kMisCompensation;
  const SunDisc* sun = nullptr;              // copied
  const ColourMatrix* to_working = nullptr;  // for its radiance; copied
};

// Settings that can change without reading the map.
struct EnvironmentAdjustment {
  float strength = 1.0f;
  Rgb tint = Rgb(1.0f);
  float rotation_degrees = 0.0f;
};

class EnvironmentLight {
 public:
  // Constant radiance, without tables; sampled uniformly over the sphere.
  explicit EnvironmentLight(const Rgb& constant, const EnvironmentLightSettings& settings = {});
  // image: kHalf or kFloat, 3 channels, finite and non-negative (guaranteed by io). It is shared,
  // not copied. `rotation_degrees` as in EnvironmentDescription.
  EnvironmentLight(std::shared_ptr<const Image> image, float strength, float rotation_degrees,
                   const EnvironmentLightSettings& settings = {});
  ~EnvironmentLight();
  // Memory for sampling an image in addition to its texels: two numbers per texel.
  static uint64_t table_bytes(const Image& image);

  // Changes strength, tint and rotation. The result has the same bits as a new light with them but
  // is cheap, since the tables depend on none of the three. Not thread-safe.
  void adjust(const EnvironmentAdjustment& adjustment);
  const EnvironmentAdjustment& adjustment() const { return adjustment_; }

  // Up to kRayBatch directions at once, so that the angles vectorise.
  void radiance(std::span<const Vec3f> directions, Rgb* out) const;
  EnvironmentSample sample(const Vec2f& u) const;
  // Up to kRayBatch at once, so that cache misses in the large tables overlap.
  void sample(std::span<const Vec2f> u, EnvironmentSample* out) const;
  // Both for little more than the cost of one, for rays that leave the scene.
  void radiance_and_pdf(std::span<const Vec3f> directions, Rgb* radiance, float* pdf) const;
  Rgb radiance_and_pdf(const Vec3f& direction, float* pdf) const;

  const Image* image() const { return image_.get(); }              // null: constant
  bool black() const { return mean_luminance_ == 0.0; }            // no radiance anywhere
  float mean_luminance() const { return float(mean_luminance_); }  // over the sphere
  uint64_t bytes() const;                                          // tables and texels

 private:
  friend class EnvironmentGuide;

  // Per direction: the four texels around it (columns and rows, and the fraction towards the second
  // of each), and the sine of its angle to the pole.
  struct BilinearTaps {
    alignas(64) int column0[kRayBatch], column1[kRayBatch], row0[kRayBatch], row1[kRayBatch];
    alignas(64) float to_column1[kRayBatch], to_row1[kRayBatch], sin_theta[kRayBatch];
  };
  // Texel coordinates: (0, 0) is the centre of the first texel; column in [-width, 2 width). The
  // arrays must have kRayBatch elements; more than `count` are read.
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
  // A sample's position around the chosen texel, r in [0, 1).
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
  // Radiance and density at one place, from the same texels.
  Rgb radiance_and_pdf_at(const BilinearTaps& p, size_t i, float* pdf) const;
  // The weight of a texel's luminance, before strength.
  float weight(float luminance) const {
    return std::max(0.0f, luminance * weight_scale_ - threshold_);
  }
  float texel_luminance(size_t row, size_t column) const;
  void build_tables(float mis_compensation);
  void choose_sun_share();
  void update_sun();
  // Builds the tables within rows for the current threshold; returns the sum of the rows' totals.
  double build_columns(std::vector<double>* row_totals);

  // Converts the map's adjusted light to the working space.
  Rgb to_working_space(const Rgb& light) const {
    if (to_working_) [[unlikely]]
      return *to_working_ * light;
    return light;
  }

  EnvironmentAdjustment adjustment_;
  std::optional<ColourMatrix> to_working_;
  Rgb map_constant_ = Rgb(0.0f);  // if there is no image
  Rgb constant_ = Rgb(0.0f);      // map_constant_, adjusted
  std::shared_ptr<const Image> image_;
  const void* texels_ = nullptr;
  bool half_ = false;
  int width_ = 0, height_ = 0;
  Color4 factor_ = color4(Rgb(1.0f));  // strength and tint
  float column_scale_ = 0.0f, column_offset_ = 0.0f, row_scale_ = 0.0f;
  double map_mean_luminance_ = 0.0;
  double mean_luminance_ = 0.0;  // with strength and tint

  // Running column sums of all rows, width + 1 words each, and their guide tables; then the rows'
  // own. See fixed_cdf.h. Densities are not looked up in them but computed from the same texels as
  // the radiance: pdf = interpolated (row density x weight) / sin theta. This agrees with the sums
  // up to their step of 2^-32.
  std::vector<uint32_t> column_sums_, column_guides_, row_sums_, row_guide_;
  std::vector<float> row_density_;
  float weight_scale_ = 1.0f, threshold_ = 0.0f;
  int column_bits_ = 0, row_bits_ = 0;
  size_t column_guide_words_ = 0;

  struct Sun {
    Vec3f direction = Vec3f(0.0f);  // in world space
    ShadingFrame frame;
    float radius2 = 0.0f;             // squared chord from its centre to its edge
    float density = 0.0f;             // pdf of directions to it, per solid angle
    float share = 0.0f;               // fraction of the samples; 0: there is no sun
    Rgb center_radiance = Rgb(0.0f);  // radiance at the centre
  };
  std::shared_ptr<const SunDisc> sun_disc_;
  Sun sun_;
};

}  // namespace emberline
