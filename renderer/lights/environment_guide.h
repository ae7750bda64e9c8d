// Samples of an environment of which little is seen, as from inside a room: by what each region of
// the scene sees of it (SkyRegions), so that few of them end at a wall.
//
// After Atanasov et al. 2018, "Adaptive Environment Sampling on CPU and GPU" (SIGGRAPH Talks). A
// region's density is light x root mean square of visibility x cosine, tile by tile of the sphere;
// within a tile it is that of the light: what MIS compensation left of the map's texels by
// EnvironmentLight's own tables, and what it took away, evenly. Some of the samples go by light
// alone, so that what the survey has missed costs noise and nothing else.
//
// Refers to the light, which outlives it. All const functions are pure and thread-safe; batches
// hold up to kRayBatch directions.
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
  float u_part = 0.0f;  // chooses between what the tables have of a tile, and what they leave out
  Vec2f u;              // the direction
};

class EnvironmentGuide {
 public:
  // The light is not black. Without regions as yet.
  explicit EnvironmentGuide(const EnvironmentLight& light);
  void set_regions(SkyRegions regions);

  // For the survey: a tile's share of the light, and a direction in it by the light's density,
  // u_part and u in [0, 1); of a tile that has some. The light's own sun is not in it.
  double light_share(int tile) const { return mass(tile) / mass_; }
  Vec3f direction_in(int tile, float u_part, const Vec2f& u) const;

  // Whose density is that of points there; kNone: the light's own.
  int region_of(const Vec3f& point, const Vec3f& normal) const {
    return regions_.find(point, normal);
  }
  void sample(std::span<const GuidedRequest> requests, EnvironmentSample* out) const;
  // EnvironmentLight::radiance_and_pdf, the densities those of sample() for the regions.
  void radiance_and_pdf(std::span<const Vec3f> directions, std::span<const int> regions,
                        Rgb* radiance, float* pdf) const;

  std::string describe() const;  // for the report
  uint64_t bytes() const;

 private:
  // Of a map: the texels whose centres are in a tile. The columns may run past the map's width,
  // and go on at 0 then.
  struct Tile {
    int first_row = 0, end_row = 0;
    int first_column = 0, end_column = 0;
    double top = 0, bottom = 0;  // y of their upper and lower edge
    double solid_angle = sky_tiles::kSolidAngle;
    double table_mass = 0;  // their probability, by the light's tables
    double even_mass = 0;   // light that the tables leave out, in the same unit
  };
  // A texel to be chosen of a row, by its running sums in [first, last].
  struct RowChoice {
    const uint32_t* first = nullptr;
    const uint32_t* last = nullptr;
    double along = 0;
  };

  void place_tiles();
  void measure_even_light();
  double mean_left_out(const Tile& tile) const;
  void weigh(int region);
  double mass(int tile) const {
    return tiles_[size_t(tile)].table_mass + tiles_[size_t(tile)].even_mass;
  }
  const uint32_t* sums_of_row(int row) const {
    return &light_.column_sums_[size_t(row) * (size_t(light_.width_) + 1)];
  }
  double column_mass(int row, int first, int end) const;
  RowChoice choose_row(int tile, const Vec2f& u, float* row) const;
  float choose_column(const RowChoice& choice) const;
  void choose_evenly(int tile, const Vec2f& u, float* column, float* row) const;
  int choose_tile(int region, Vec2f* u) const;
  void sample_map(std::span<const GuidedRequest> requests, EnvironmentSample* out) const;
  void sample_constant(std::span<const GuidedRequest> requests, EnvironmentSample* out) const;
  float density(const EnvironmentLight::Places& places, size_t i, float light_density,
                int region) const;

  const EnvironmentLight& light_;
  SkyRegions regions_;
  std::vector<Tile> tiles_;
  double mass_ = 0;                                // of all
  std::vector<int> tile_of_row_, tile_of_column_;  // their sum is a texel's tile
  std::vector<double> row_sums_;     // per column of tiles: running masses of the map's rows in it
  std::vector<float> even_density_;  // per tile: even_mass over the solid angle
  // Per region: by how much each tile's density exceeds light's; and running probabilities, of the
  // rows and then within each row.
  std::vector<float> factors_, sums_;
  static constexpr size_t kSums =
      sky_tiles::kRows + 1 + size_t(sky_tiles::kRows) * (sky_tiles::kColumns + 1);
};

}  // namespace emberline
