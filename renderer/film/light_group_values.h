// The radiance from each light group for each sample of a batch. The integrator fills it in for the
// film.
//
// A group is an index (renderer/scene/light_groups.h). For each sample, one bit per group marks the
// values in use. The other values are neither cleared nor read, so a group whose light does not
// reach a sample costs nothing.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "renderer/core/ray.h"
#include "renderer/core/vector.h"

namespace emberline {

// Each group has one bit in a 64-bit word.
inline constexpr int kMaxLightGroups = 64;

class LightGroupValues {
 public:
  explicit LightGroupValues(int groups = 0)
      : groups_(groups), values_(kRayBatch * size_t(groups)) {}

  // Clear the values of all samples, or of one sample.
  void clear() {
    for (uint64_t& lit : lit_) lit = 0;
  }
  void clear(int lane) { lit_[lane] = 0; }

  // Adds throughput x radiance to the group's value for the lane's sample.
  void add(int lane, uint32_t group, const Rgb& throughput, const Rgb& radiance);

  // Calls body(group, radiance) for each group whose light reached the sample, in ascending order.
  template <typename Body>
  void for_each(int lane, const Body& body) const {
    for (uint64_t left = lit_[lane]; left != 0; left &= left - 1) {
      const auto group = size_t(std::countr_zero(left));
      body(group, values_[size_t(lane) * size_t(groups_) + group]);
    }
  }

 private:
  int groups_;
  uint64_t lit_[kRayBatch] = {};  // bit g: the value of group g is in use
  std::vector<Rgb> values_;       // by lane, then by group
};

}  // namespace emberline
