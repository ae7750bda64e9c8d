// A latitude-longitude environment with bilinear radiance and exact importance sampling.
//
// A direction has the map coordinates u = 0.5 + atan2(z, x) / 2 pi and v = acos(y) / pi. The top
// row is at +Y. u wraps around, and v is clamped. Radiance is the bilinear interpolation of texels.
// The sampling density is the bilinear interpolation of per-texel weights, so even a sun that is
// one texel large is sampled in proportion to its radiance. The weight of a texel is luminance x
// solid angle, reduced by MIS compensation (Karlik et al. 2019, "MIS Compensation: Optimizing
// Sampling Techniques in Multiple Importance Sampling").
//
// A sun (SunDisc) may be in front of the map. Half of the samples go to the sun, or fewer if the
// sun is dim. The density of a direction is that of the mixture of sun and map samples.
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
  float pdf = 0.0f;  // per solid angle; 0 if nothing was sampled
};

// Factor of MIS compensation: the weight of a texel is max(0, radiance - factor x mean), so light
// up to this multiple of the mean is left to BSDF sampling. For MIS with a uniform technique,
// Karlik et al. 2019 derive a factor of 1, which pbrt-v4 uses. For an equal mixture with a uniform
// technique, a factor of 1/2 would be best. For five HDRIs with Lambertian and glossy surfaces,
// factors of 1/2, 3/4 and 1 reduced the variance to 0.87, 0.86 and 0.86 of that without
// compensation (tests/bench/results). A factor of 1 is best for a sun in an even sky, because the
// sky is then left entirely to BSDF sampling, which has no variance there.
inline constexpr float kMisCompensation = 1.0f;

struct EnvironmentLightSettings {
  // The factor of MIS compensation; 0 disables it. Use 0 if light sampling is the only technique,
  // since a compensated density is 0 in directions darker than the mean.
  float mis_compensation = kMisCompensation;
  const SunDisc* sun = nullptr;              // copied
  const ColourMatrix* to_working = nullptr;  // converts the radiance; copied
};

// Settings that can change without rebuilding the sampling tables.
struct EnvironmentAdjustment {
  float strength = 1.0f;
  Rgb tint = Rgb(1.0f);
  float rotation_degrees = 0.0f;
};

class EnvironmentLight {
 public:
  // Creates a light of constant radiance, which needs no tables and is sampled uniformly over the
  // sphere.
  explicit EnvironmentLight(const Rgb& constant, const EnvironmentLightSettings& settings = {});
  // `image` must be kHalf or kFloat with 3 channels, finite and non-negative (io guarantees this).
  // The image is shared, not copied. `rotation_degrees` is as in EnvironmentDescription.
  EnvironmentLight(std::shared_ptr<const Image> image, float strength, float rotation_degrees,
                   const EnvironmentLightSettings& settings = {});
  ~EnvironmentLight();
  // Returns the memory of the sampling tables of an image, without its texels: two words per texel.
  static uint64_t table_bytes(const Image& image);

  // Changes strength, tint and rotation. The light is then bit-identical to a new light with these
  // settings. This is cheap, since the tables depend on none of the three. Not thread-safe.
  void adjust(const EnvironmentAdjustment& adjustment);
  const EnvironmentAdjustment& adjustment() const { return adjustment_; }

  // Computes the radiance of up to kRayBatch directions at once, so that the arithmetic of their
  // angles vectorises.
  void radiance(std::span<const Vec3f> directions, Rgb* out) const;
  EnvironmentSample sample(const Vec2f& u) const;
  // Takes up to kRayBatch samples at once, so that cache misses in the large tables overlap.
  void sample(std::span<const Vec2f> u, EnvironmentSample* out) const;
  // Compute radiance and density, for rays that leave the scene. Computing both costs little more
  // than computing one.
  void radiance_and_pdf(std::span<const Vec3f> directions, Rgb* radiance, float* pdf) const;
  Rgb radiance_and_pdf(const Vec3f& direction, float* pdf) const;

  const Image* image() const { return image_.get(); }              // null: constant
  bool black() const { return mean_luminance_ == 0.0; }            // no radiance anywhere
  float mean_luminance() const { return float(mean_luminance_); }  // over the sphere
  uint64_t bytes() const;                                          // tables and texels

 private:
  friend class EnvironmentGuide;

  // The bilinear lookup of each direction: the columns and rows of the four texels around it, its
  // fractional position between them, and the sine of its angle to the pole.
  struct BilinearTaps {
    alignas(64) int column0[kRayBatch], column1[kRayBatch], row0[kRayBatch], row1[kRayBatch];
    alignas(64) float to_column1[kRayBatch], to_row1[kRayBatch], sin_theta[kRayBatch];
  };
  // `column` and `row` are texel coordinates: (0, 0) is the centre of the first texel, and columns
  // are in [-width, 2 width). The arrays must have kRayBatch elements, since more than `count`
  // elements are read.
  void find_taps(size_t count, const float* column, const float* row, BilinearTaps* out) const;
  void find_taps(std::span<const Vec3f> directions, BilinearTaps* out) const;
  struct Corners;
  // The sampling weights of the four texels around a direction.
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
  // Sample a texel coordinate around the centre of the chosen column or row, for r in [0, 1).
  static float sample_column(int column, float r);
  float sample_row(int row, float r) const;
  // Converts texel coordinates to samples and their BilinearTaps.
  void sample_taps(size_t count, const float* column, const float* row, BilinearTaps* taps,
                   EnvironmentSample* out) const;
  void sample_map(std::span<const Vec2f> u, EnvironmentSample* out) const;
  void sample_sun_or_map(std::span<const Vec2f> u, EnvironmentSample* out) const;
  // Returns the radiance of the sun in a direction.
  Rgb sun_radiance(const Vec3f& direction) const;
  // Adds the sun to the map's values. `pdf` may be null.
  void add_sun(std::span<const Vec3f> directions, Rgb* radiance, float* pdf) const;
  // Returns radiance and density of direction i, both from the same texels.
  Rgb radiance_and_pdf_at(const BilinearTaps& p, size_t i, float* pdf) const;
  // Returns the sampling weight of a texel. `luminance` is that of the map, without strength and
  // tint.
  float weight(float luminance) const {
    return std::max(0.0f, luminance * weight_scale_ - threshold_);
  }
  float texel_luminance(size_t row, size_t column) const;
  void build_tables(float mis_compensation);
  void choose_sun_share();
  void update_sun();
  // Builds the tables of columns for the current threshold. Sets the total weight of each row, and
  // returns the sum of these totals.
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

  // The running sums over the columns of each row, with width + 1 words per row, and the running
  // sums over the rows. Both have guide tables (see fixed_cdf.h). Densities are not read from these
  // tables but computed from the same texels as the radiance: pdf = interpolated (row density x
  // weight) / sin theta. These densities agree with the tables to within 2^-32, the step of the
  // sums.
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
    float share = 0.0f;               // fraction of the samples; 0 if there is no sun
    Rgb center_radiance = Rgb(0.0f);  // radiance at the centre
  };
  std::shared_ptr<const SunDisc> sun_disc_;
  Sun sun_;
};

}  // namespace emberline
