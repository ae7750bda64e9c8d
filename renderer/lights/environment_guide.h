// Samples an environment that is mostly hidden, such as the sky as seen from inside a room. In each
// region of the scene (SkyRegions), the guide prefers the part of the environment that the region
// sees, so that few samples are occluded.
//
// The method follows Atanasov et al. 2018, "Adaptive Environment Sampling on CPU and GPU" (SIGGRAPH
// Talks). In a region, the guide chooses a tile of the sphere in proportion to the tile's light
// times the root mean square of (visibility x cosine). Within a tile, the density is that of
// EnvironmentLight's tables, which have MIS compensation, plus a constant for the light that the
// compensation removed. Some samples are chosen by light alone, without regard to visibility, so
// that errors in the survey cause only noise.
//
// The EnvironmentLight must outlive the guide, which refers to it. All const functions are pure and
// thread-safe, and accept up to kRayBatch directions at once.
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
  // A random number that chooses between two parts of a tile's light: the part in the tables, and
  // the part that MIS compensation removed from the tables.
  float u_part = 0.0f;
  Vec2f u;  // chooses the direction
};

class EnvironmentGuide {
 public:
  // The light must not be black. Call set_regions() once the regions are known.
  explicit EnvironmentGuide(const EnvironmentLight& light);
  void set_regions(SkyRegions regions);

  // These two functions are for the survey. light_fraction() returns a tile's fraction of all
  // light; direction_in() samples a direction in a tile in proportion to the light. u_part and u
  // must be in [0, 1), and the tile must have some light. Both functions exclude the sun.
  double light_fraction(int tile) const { return mass(tile) / mass_; }
  Vec3f direction_in(int tile, float u_part, const Vec2f& u) const;

  // Returns the region whose density applies at this point, or kNone if EnvironmentLight's own
  // density applies.
  int region_of(const Vec3f& point, const Vec3f& normal) const {
    return regions_.find(point, normal);
  }
  void sample(std::span<const GuidedRequest> requests, EnvironmentSample* out) const;
  // Like EnvironmentLight::radiance_and_pdf(), but the density of directions[i] is that of sample()
  // in regions[i].
  void radiance_and_pdf(std::span<const Vec3f> directions, std::span<const int> regions,
                        Rgb* radiance, float* pdf) const;

  std::string describe() const;  // for the report
  uint64_t bytes() const;

 private:
  // For a map, the range of texels whose centres are in the tile. Columns past the last one
  // wrap around.
  struct Tile {
    int first_row = 0, end_row = 0;
    int first_column = 0, end_column = 0;
    double top = 0, bottom = 0;  // y of the upper and lower edge of these texels
    double solid_angle = sky_tiles::kSolidAngle;
    double table_mass = 0;     // probability of these texels in the light's tables
    double residual_mass = 0;  // light that the tables leave out, in the unit of table_mass
  };
  // A choice among the texels of one row within a tile. [first, last] are their running sums, and
  // `along` is a position in the range of these sums.
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
  std::vector<int> tile_of_row_, tile_of_column_;  // a texel's tile is the sum of both
  std::vector<double> row_sums_;         // per column of tiles: running sums over the map's rows
  std::vector<float> residual_density_;  // per tile: residual_mass / solid_angle
  // For each region, factors_ has the density of each tile relative to the light's own density.
  // sums_ has the running sums of the probabilities of the rows of tiles, then those of the tiles
  // within each row.
  std::vector<float> factors_, sums_;
  static constexpr size_t kSums =
      sky_tiles::kRows + 1 + size_t(sky_tiles::kRows) * (sky_tiles::kColumns + 1);
};

}  // namespace emberline
