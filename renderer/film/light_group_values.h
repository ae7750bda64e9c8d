// What each light group gave to each sample of a batch, on its way from the integrator to the film.
//
// A group is a number; whose light it is, renderer/scene/light_groups.h says. A sample that a group
// did not reach costs nothing: a bit says so, and its value is neither cleared nor added.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "renderer/core/ray.h"
#include "renderer/core/vector.h"

namespace emberline {

// As many as a word has bits.
inline constexpr int kMostLightGroups = 64;

class LightGroupValues {
 public:
  explicit LightGroupValues(int groups = 0)
      : groups_(groups), values_(kRayBatch * size_t(groups)) {}

  // No light in any sample; and in one.
  void clear() {
    for (uint64_t& lit : lit_) lit = 0;
  }
  void clear(int lane) { lit_[lane] = 0; }

  // Adds throughput x radiance to what the group gave the lane's sample.
  void add(int lane, uint32_t group, const Rgb& throughput, const Rgb& radiance);

  // body(group, radiance) for each group that reached the sample, in ascending order.
  template <typename Body>
  void for_each(int lane, const Body& body) const {
    for (uint64_t left = lit_[lane]; left != 0; left &= left - 1) {
      const auto group = size_t(std::countr_zero(left));
      body(group, values_[size_t(lane) * size_t(groups_) + group]);
    }
  }

 private:
  int groups_;
  uint64_t lit_[kRayBatch] = {};  // bit g: the value of group g counts
  std::vector<Rgb> values_;       // by lane, then by group
};

}  // namespace emberline
