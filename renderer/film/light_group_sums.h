// What each light group gave to each pixel of a film.
//
// A sum is two floats: the sum rounded to float, and what that left out (the double-length
// arithmetic of Dekker 1971, "A Floating-Point Technique for Extending the Available Precision").
// A float alone would lose 1e-4 of a constant background after some thousand samples; a picture of
// other weights reads the first floats alone, half the memory of doubles.
//
// Every pixel has one sum more, of its samples and their alpha, so that such a picture asks for
// nothing else of the film.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "renderer/core/color4.h"
#include "renderer/core/vector.h"
#include "renderer/core/zeroed_array.h"

namespace emberline {

class Archive;
class LightGroupValues;
class LightMix;

class LightGroupSums {
 public:
  // -1: there are none to be kept. 0: nothing shines, but pictures can be mixed.
  explicit LightGroupSums(int groups) : groups_(groups) {}

  // Clears to no samples of so many pixels, as FilmTile does.
  void reset(size_t pixels);
  bool empty() const { return sums_.empty(); }
  int groups() const { return groups_; }

  // Adds a sample: what `values` has for the lane, and alpha, times the weight of the pixel filter.
  // A pixel's samples have one owner, and come in index order.
  void add(size_t pixel, float filter_weight, float alpha, const LightGroupValues& values,
           int lane);
  // Makes these the means of a pixel that has no samples.
  void show(size_t pixel, std::span<const Rgb> means);
  void copy(const LightGroupSums& from, size_t from_pixel, size_t pixel);

  // Adds what the other has of the pixel.
  void add_sums(const LightGroupSums& from, size_t pixel);

  // Mean over the pixel's samples; 0 without any.
  Rgb mean(size_t pixel, int group) const;
  std::array<double, 3> sum(size_t pixel, int group) const;
  // R G B A of the pixel with each group times its weight: see relight() in light_mix.h.
  void relit(size_t pixel, const LightMix& mix, float* rgba) const;
  void prefetch(size_t pixel) const;

  static uint64_t bytes_per_pixel(size_t groups) { return 2 * 3 * (groups + 1) * sizeof(float); }
  // Of so many pixels as reset() was told. Throws InputError.
  void archive(Archive& archive);
  uint64_t bytes() const { return (sums_.capacity() + rests_.capacity()) * sizeof(float); }

 private:
  // Per pixel: three of (samples, alpha, unused), then three of each group.
  size_t stride() const { return 3 * (size_t(groups_) + 1); }
  void add_to(size_t at, Color4 value);
  double whole(size_t at) const { return double(sums_[at]) + double(rests_[at]); }

  int groups_;
  ZeroedArray<float> sums_, rests_;
};

}  // namespace emberline
