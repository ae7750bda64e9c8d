// Light that --clamp-indirect removes from a frame, in total and for each light group.
//
// Radiance is summed in integer multiples of a unit that is far below the limit. So the total does
// not depend on the order in which the sums of threads and parts are added.
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
  // `limit` is the largest channel value that is not clamped; it must be finite and positive.
  // `groups` is the number of light groups that are counted separately.
  ClampedLight(float limit, int groups);

  bool clamps() const { return limit_ > 0.0f; }
  float limit() const { return limit_; }

  // add_removed() adds the radiance that was removed from a contribution of a light group; `group`
  // is ignored if groups are not counted separately. add_remaining() adds the final radiance of a
  // sample. Both radiances must be finite.
  void add_removed(uint32_t group, const Rgb& radiance);
  void add_remaining(const Rgb& radiance) { add(&remaining_, radiance); }
  // `other` must be from the same frame.
  void merge(const ClampedLight& other);
  // Saves or loads the sums. Loading accepts only sums with the same limit and number of groups.
  void archive(Archive& archive);

  // Returns the radiance that was removed from the picture, as a mean over `samples` samples.
  Rgb removed(uint64_t samples) const { return mean(removed_, samples); }
  Rgb removed_of_group(size_t group, uint64_t samples) const {
    return mean(groups_[group], samples);
  }
  size_t groups() const { return groups_.size(); }
  // Returns the fraction of the luminance that clamping has removed; 0 if there was no light.
  double fraction() const;

 private:
  using Sum = std::array<uint64_t, 3>;
  double unit() const;
  void add(Sum* sum, const Rgb& radiance) const;
  Rgb mean(const Sum& sum, uint64_t samples) const;

  float limit_ = 0.0f;
  double units_per_radiance_ = 0.0;  // 1 / unit()
  Sum removed_{}, remaining_{};
  std::vector<Sum> groups_;
};

}  // namespace emberline
