// The light of each light group, or of each light-path layer, in a pixel of a film.
//
// A sum is stored as two floats: the sum rounded to float, and the remainder (the double-length
// arithmetic of Dekker 1971, "A Floating-Point Technique for Extending the Available Precision").
// One float alone would lose 1e-4 of a constant background after a few thousand samples. Relighting
// reads only the rounded floats, which take half as much memory as doubles would.
//
// One more sum holds the pixel's sample count and alpha, so relighting needs nothing else from the
// film.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "renderer/core/color4.h"
#include "renderer/core/vector.h"

namespace emberline {

class LightGroupValues;
class LightMix;

// A view of a pixel's sums, which the film owns.
class LightGroupSums {
 public:
  // `sums` and `remainders` each point to bytes_per_pixel(groups) / 2 bytes: three floats for each
  // group, and three for the sample count and alpha. If `groups` is 0, only the sample count and
  // alpha are stored, and relighting gives black with the right alpha. If it is -1, the film does
  // not record light groups, and nothing is stored.
  LightGroupSums(float* sums, float* remainders, int groups)
      : sums_(sums), remainders_(remainders), groups_(groups) {}
  static size_t bytes_per_pixel(int groups) { return 2 * 3 * size_t(groups + 1) * sizeof(float); }

  int groups() const { return groups_; }
  // Returns the sums of the pixel whose index in the same film is higher by `offset`.
  LightGroupSums at_offset(size_t offset) const {
    return {sums_ + offset * size(), remainders_ + offset * size(), groups_};
  }

  // Adds a sample: the lane's values (null: no light) and alpha, times the pixel filter's weight.
  // One thread at a time must add a pixel's samples, in index order.
  void add(float filter_weight, float alpha, const LightGroupValues* values, int lane);
  // Sets the means of a pixel without samples.
  void set_override(std::span<const Rgb> means);
  // Adds another film's sums of the pixel.
  void merge(const LightGroupSums& more);

  // Returns the mean over the pixel's samples, or 0 if there are none.
  Rgb mean(int group) const;
  std::array<double, 3> sum(int group) const;
  // Writes R G B A of the pixel, with each group multiplied by its weight in `mix`; see relight()
  // in light_mix.h. Reads one float beyond the pixel's sums.
  void relight_pixel(const LightMix& mix, float* rgba) const;
  // Whether the sums are finite and the sample count is 0 or at least 1.
  bool is_valid() const;

 private:
  // The number of floats: (samples, alpha, unused), then R G B of each group.
  size_t size() const { return 3 * size_t(groups_ + 1); }
  void add_to(size_t at, Color4 value);
  double compensated_sum(size_t at) const { return double(sums_[at]) + double(remainders_[at]); }

  float* sums_;
  float* remainders_;
  int groups_;
};

}  // namespace emberline
