// Samples an environment that is mostly hidden, as seen from inside a room. It prefers the part
// that each region of the scene sees (SkyRegions), so that few samples are occluded.
//
// After Atanasov et al. 2018, "Adaptive Environment Sampling on CPU and GPU" (SIGGRAPH Talks). A
// region samples each tile of the sphere in proportion to its light x the root mean square of
// (visibility x cosine). Within a tile, the density is that of EnvironmentLight's tables after MIS
// compensation, plus the part that compensation removed, distributed evenly. Some samples are
// chosen by light alone, so that errors of the survey cause only noise.
//
// It refers to the light, which must outlive it. All const functions are pure and thread-safe; they
// accept up to kRayBatch directions at once.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "renderer/lights/environment_light.h"
#include "renderer/lights/sky_regions.h"

namespace emberline {

struct GuidedRequest {
  int region = SkyRegions::kNone;
  // Chooses between the part of a tile's light that is in the tables and the part that they leave
  // out.
  float u_part = 0.0f;
  Vec2f u;  // chooses the direction
};

class EnvironmentGuide {
 public:
  // The light must not be black. Regions are set later.
  explicit EnvironmentGuide(const EnvironmentLight& light);
  void set_regions(SkyRegions regions);

  // For the survey: a tile's fraction of all light, and a direction in the tile, sampled in
  // proportion to the light. u_part and u must be in [0, 1), and the tile must have some light. The
  // sun is excluded.
  double light_fraction(int tile) const { return mass(tile) / mass_; }
  Vec3f direction_in(int tile, float u_part, const Vec2f& u) const;

  // The region whose density applies at this point; kNone: EnvironmentLight's own density applies.
  int region_of(const Vec3f& point, const Vec3f& normal) const {
    return regions_.find(point, normal);
  }
  void sample(std::span<const GuidedRequest> requests, EnvironmentSample* out) const;
  // Like EnvironmentLight::radiance_and_pdf(), but with the densities of sample() for the regions.
  void radiance_and_pdf(std::span<const Vec3f> directions, std::span<const int> regions,
                        Rgb* radiance, float* pdf) const;

  std::string describe() const;  // for the report
  uint64_t bytes() const;

 private:
  // For a map: the range of texels whose centres are in the tile. Columns beyond the width wrap
  // around.
  struct Tile {
    int first_row = 0, end_row = 0;
    int first_column = 0, end_column = 0;
    double top = 0, bottom = 0;  // y of the upper and lower edge of these texels
    double solid_angle = sky_tiles::kSolidAngle;
    double table_mass = 0;     // probability of the texels in the light's tables
    double residual_mass = 0;  // light that the tables leave out, in the same unit
  };
  // A choice among some texels of a row: `along` is a position in their running sums [first, last].
  struct RowChoice {
    const uint32_t* first = nullptr;
    const uint32_t* last = nullptr;
    double along = 0;
  };

  void assign_texels_to_tiles();
  void measure_residual_light();
  double mean_residual(const Tile& tile) const;
  void build_region(int region);
  double mass(int tile) const {
    return tiles_[size_t(tile)].table_mass + tiles_[size_t(tile)].residual_mass;
  }
  const uint32_t* sums_of_row(int row) const {
    return &light_.column_sums_[size_t(row) * (size_t(light_.width_) + 1)];
  }
  double column_mass(int row, int first, int end) const;
  RowChoice choose_row(int tile, const Vec2f& u, float* row) const;
  float choose_column(const RowChoice& choice) const;
  void choose_uniformly(int tile, const Vec2f& u, float* column, float* row) const;
  int choose_tile(int region, Vec2f* u) const;
  void sample_map(std::span<const GuidedRequest> requests, EnvironmentSample* out) const;
  void sample_constant(std::span<const GuidedRequest> requests, EnvironmentSample* out) const;
  float density(const EnvironmentLight::BilinearTaps& places, size_t i, float light_density,
                int region) const;

  const EnvironmentLight& light_;
  SkyRegions regions_;
  std::vector<Tile> tiles_;
  double mass_ = 0;                                // of all tiles
  std::vector<int> tile_of_row_, tile_of_column_;  // add both for a texel's tile
  std::vector<double> row_sums_;         // per column of tiles: running sums over the map's rows
  std::vector<float> residual_density_;  // per tile: residual_mass / solid_angle
  // Per region: factors_ has each tile's density relative to that of the light; sums_ has the
  // running probabilities of the rows of tiles, then of the tiles within each row.
  std::vector<float> factors_, sums_;
  static constexpr size_t kSums =
      sky_tiles::kRows + 1 + size_t(sky_tiles::kRows) * (sky_tiles::kColumns + 1);
};

}  // namespace emberline
