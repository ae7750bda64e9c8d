#include "renderer/lights/sky_regions.h"

#include "renderer/core/fast_angle.h"

namespace emberline {

int sky_tiles::tile_of(const Vec3f& d) {
  const int row = std::clamp(int((1.0f - d.y) / float(kRowHeight)), 0, kRows - 1);
  const float turns = fast_atan2(d.z, d.x) / (2 * kPi);
  const int column = int((turns < 0.0f ? turns + 1.0f : turns) * float(kColumns));
  return row * kColumns + std::min(column, kColumns - 1);
}

Vec3f sky_tiles::direction_in(int tile, const Vec2f& u) {
  const double down = (tile / kColumns + double(u.y)) * kRowHeight;
  const double sine = std::sqrt(std::max(0.0, down * (2 - down)));
  const double phi = 2 * kPiD * (tile % kColumns + double(u.x)) / kColumns;
  return to_float(Vec3d(sine * std::cos(phi), 1 - down, sine * std::sin(phi)));
}

SkyRegions::SkyRegions(const Vec3f& lower, const Vec3f& upper) : lower_(lower) {
  const Vec3f size = upper - lower;
  const float longest = std::max({size.x, size.y, size.z});
  if (!(longest > 0.0f) || !std::isfinite(longest)) return;
  cells_per_length_ = float(kCells) / longest;
  if (!std::isfinite(cells_per_length_)) return;
  size_t places = 6;
  for (int c = 0; c < 3; ++c) {
    cells_[size_t(c)] = std::clamp(int(std::ceil(size[c] * cells_per_length_)), 1, kCells);
    places *= size_t(cells_[size_t(c)]);
  }
  numbers_.assign(places, 0);
}

SkyRegions SkyRegions::single_region() {
  SkyRegions regions;
  regions.count_ = 1;
  regions.is_single_region_ = true;
  regions.visibility_.assign(sky_tiles::kCount, 1.0f);
  regions.places_.assign(1, 1);
  return regions;
}

int SkyRegions::face_of(const Vec3f& n) {
  const float x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
  if (x >= y && x >= z) return n.x > 0.0f ? 0 : 1;
  if (y >= z) return n.y > 0.0f ? 2 : 3;
  return n.z > 0.0f ? 4 : 5;
}

int64_t SkyRegions::slot_of(const Vec3f& point, const Vec3f& normal) const {
  int64_t cell = 0;
  for (int c = 2; c >= 0; --c) {
    const float at = (point[c] - lower_[c]) * cells_per_length_;
    if (!(at >= 0.0f && at < float(cells_[size_t(c)]))) return -1;
    cell = cell * cells_[size_t(c)] + int(at);
  }
  return cell * 6 + face_of(normal);
}

int SkyRegions::find_or_add(const Vec3f& point, const Vec3f& normal) {
  const int64_t place = slot_of(point, normal);
  if (place < 0) return kNone;
  uint16_t& number = numbers_[size_t(place)];
  if (number == 0) {
    if (count_ == kMaxRegions) return kNone;
    number = uint16_t(++count_);
    visibility_.resize(visibility_.size() + sky_tiles::kCount, 0.0f);
    places_.push_back(0);
  }
  return number - 1;
}

}  // namespace emberline
