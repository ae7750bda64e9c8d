#include "renderer/film/light_group_values.h"

namespace emberline {

void LightGroupValues::add(int lane, uint32_t group, const Rgb& throughput, const Rgb& radiance) {
  if (group >= uint32_t(groups_)) return;  // the light has no group
  Rgb& value = values_[size_t(lane) * size_t(groups_) + group];
  const uint64_t bit = uint64_t(1) << group;
  if (!(lit_[lane] & bit)) {
    lit_[lane] |= bit;
    value = Rgb(0.0f);
  }
  value = fma(throughput, radiance, value);
}

}  // namespace emberline
