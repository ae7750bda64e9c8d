// What each light group, or each layer by light path, gave to a pixel of a film.
//
// A sum is two floats: the sum rounded to float, and what that left out (the double-length
// arithmetic of Dekker 1971, "A Floating-Point Technique for Extending the Available Precision").
// A float alone would lose 1e-4 of a constant background after some thousand samples; a picture of
// other weights reads the first floats alone, half the memory of doubles.
//
// There is one sum more, of the pixel's samples and their alpha, so that such a picture asks for
// nothing else of the film.
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

// A view of the sums of one pixel, which its film holds.
class LightGroupSums {
 public:
  // Half of bytes_per_pixel(groups) at each of the two. -1: nothing is kept. 0: nothing shines, but
  // pictures can be mixed.
  LightGroupSums(float* sums, float* rests, int groups)
      : sums_(sums), rests_(rests), groups_(groups) {}
  static size_t bytes_per_pixel(int groups) { return 2 * 3 * size_t(groups + 1) * sizeof(float); }

  int groups() const { return groups_; }
  // Of the pixel that is so many further on in the same film.
  LightGroupSums of_pixel(size_t further) const {
    return {sums_ + further * size(), rests_ + further * size(), groups_};
  }

  // Adds a sample: what `values` has for the lane, or no light without them, and alpha, times the
  // weight of the pixel filter. A pixel's samples have one owner, and come in index order.
  void add(float filter_weight, float alpha, const LightGroupValues* values, int lane);
  // Makes these the means of a pixel that has no samples.
  void show(std::span<const Rgb> means);
  // Adds what the other film has of the pixel.
  void merge(const LightGroupSums& more);

  // Mean over the pixel's samples; 0 without any.
  Rgb mean(int group) const;
  std::array<double, 3> sum(int group) const;
  // R G B A of the pixel with each group times its weight: see relight() in light_mix.h. Reads one
  // float beyond its sums.
  void relit(const LightMix& mix, float* rgba) const;
  // Finite, and a number of samples that means can be divided by.
  bool is_sound() const;

 private:
  // Three of (samples, alpha, unused), then three of each group.
  size_t size() const { return 3 * size_t(groups_ + 1); }
  void add_to(size_t at, Color4 value);
  double whole(size_t at) const { return double(sums_[at]) + double(rests_[at]); }

  float* sums_;
  float* rests_;  // what was left out
  int groups_;
};

}  // namespace emberline
