// What --clamp-indirect took from a frame's light, all of it and group by group.
//
// Sums are whole numbers of a unit far below the limit, so that they do not depend on the order in
// which threads and parts are added up.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "renderer/core/vector.h"

namespace emberline {

class Archive;

class ClampedLight {
 public:
  ClampedLight() = default;  // nothing is clamped
  // limit: the largest channel of a contribution that is left alone; finite, > 0. groups: light
  // groups that are told apart.
  ClampedLight(float limit, int groups);

  bool clamps() const { return limit_ > 0.0f; }
  float limit() const { return limit_; }

  // Light that was taken, of a group if those are told apart; and what a sample has in the end.
  // Finite.
  void take(uint32_t group, const Rgb& radiance);
  void keep(const Rgb& radiance) { add(&kept_, radiance); }
  // Of the same frame.
  void merge(const ClampedLight& other);
  // Loads what is of the same limit and as many groups, and nothing else.
  void archive(Archive& archive);

  // Radiance; over `samples` it is the mean that the picture lacks.
  Rgb taken(uint64_t samples) const { return mean(taken_, samples); }
  Rgb taken_of_group(size_t group, uint64_t samples) const { return mean(groups_[group], samples); }
  size_t groups() const { return groups_.size(); }
  // Of the luminance that there would be; 0 without any.
  double share() const;

 private:
  using Sum = std::array<uint64_t, 3>;
  double unit() const;
  void add(Sum* sum, const Rgb& radiance) const;
  Rgb mean(const Sum& sum, uint64_t samples) const;

  float limit_ = 0.0f;
  double per_radiance_ = 0.0;  // 1 / unit()
  Sum taken_{}, kept_{};
  std::vector<Sum> groups_;
};

}  // namespace emberline
