// The visibility of the environment from the parts of a scene. A grid divides the scene into cells.
// Each cell has six regions, one for the surfaces that face mainly along each axis direction (+X,
// -X, +Y, ...). Each region stores the visibility of every tile of the sphere (sky_tiles).
// renderer/scene/light_survey.h measures the visibility with rays, and EnvironmentGuide reads it.
//
// Points are in the scene's internal space; directions are unit vectors in world space. Once the
// survey is complete, all const functions are thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "renderer/core/constants.h"
#include "renderer/core/vector.h"

namespace emberline {

// Divides the sphere into tiles of equal solid angle: rows of equal height along y, and columns
// around the y axis.
namespace sky_tiles {

inline constexpr int kColumns = 24, kRows = 12, kCount = kColumns * kRows;
inline constexpr double kSolidAngle = 4 * kPiD / kCount;

// The height of a row of tiles along y.
inline constexpr double kRowHeight = 2.0 / kRows;

int tile_of(const Vec3f& direction);
// Returns a uniformly distributed direction in the tile, for u in [0, 1)^2.
Vec3f direction_in(int tile, const Vec2f& u);

}  // namespace sky_tiles

class SkyRegions {
 public:
  static constexpr int kNone = -1;
  static constexpr int kCells = 16;  // number of cells along the longest side of the box

  SkyRegions() = default;  // no regions
  SkyRegions(const Vec3f& lower, const Vec3f& upper);
  // Returns a single region for all points, from which everything is equally visible.
  static SkyRegions single_region();

  // Returns the region of a surface point that faces along `normal`, or kNone.
  int find(const Vec3f& point, const Vec3f& normal) const {
    if (is_single_region_) return 0;
    const int64_t place = slot_of(point, normal);
    return place < 0 ? kNone : int(numbers_[size_t(place)]) - 1;
  }
  // Like find(), but adds the region if it is missing. Returns kNone if the point is outside the
  // box or there are too many regions.
  int find_or_add(const Vec3f& point, const Vec3f& normal);
  int count() const { return count_; }
  uint64_t bytes() const {
    return numbers_.size() * sizeof(uint16_t) + visibility_.size() * sizeof(float) +
           places_.size() * sizeof(uint32_t);
  }

  // Returns, for each tile, the root mean square of (visibility x cosine at the surface).
  // Visibility is 1 if nothing is in the way. It is 0 if an opaque surface is in the way, and the
  // transmittance if a translucent surface is in the way.
  std::span<float> visibility(int region) {
    return {&visibility_[first_tile(region)], sky_tiles::kCount};
  }
  // Frees the memory of the visibilities. Call this once they have been read.
  void release_visibility() { visibility_ = std::vector<float>(); }
  // The number of points in the region from which the environment was surveyed.
  uint32_t& places(int region) { return places_[size_t(region)]; }

 private:
  static constexpr int kMaxRegions = 4096;

  static size_t first_tile(int region) { return size_t(region) * sky_tiles::kCount; }
  static int face_of(const Vec3f& normal);
  int64_t slot_of(const Vec3f& point, const Vec3f& normal) const;

  Vec3f lower_ = Vec3f(0.0f);
  float cells_per_length_ = 0.0f;
  std::array<int, 3> cells_ = {0, 0, 0};
  int count_ = 0;
  bool is_single_region_ = false;
  std::vector<uint16_t> numbers_;  // per cell and direction (slot_of()): region + 1, or 0 for none
  std::vector<float> visibility_;
  std::vector<uint32_t> places_;
};

}  // namespace emberline
