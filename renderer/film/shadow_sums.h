// What shadow catchers receive of the lights, pixel by pixel: with all that is in the scene, and
// with what stands for the plate alone.
#pragma once

#include <cstddef>

#include "renderer/core/vector.h"
#include "renderer/core/zeroed_array.h"
#include "renderer/film/sample_value.h"

namespace emberline {

class Archive;

class ShadowSums {
 public:
  explicit ShadowSums(bool kept) : kept_(kept) {}

  // Clears to no samples of so many pixels.
  void reset(size_t pixels) { sums_.reset(kept_ ? pixels : 0); }
  bool empty() const { return sums_.empty(); }

  // Finite. A pixel's samples have one owner, and come in index order.
  void add(size_t pixel, float filter_weight, const CatcherSample& sample);
  void add_sums(const ShadowSums& from, size_t pixel);
  void copy(const ShadowSums& from, size_t from_pixel, size_t pixel);

  // What the plate is to be multiplied by where it shows: received over unshadowed on the catchers,
  // 1 beside them. In [0, 1].
  Rgb shadow(size_t pixel) const;
  // The sum over its samples of the alpha that catchers which are not to be seen have of it.
  double alpha(size_t pixel) const;

  void archive(Archive& archive);  // throws InputError
  uint64_t bytes() const { return sums_.capacity() * sizeof(Sums); }

 private:
  struct Sums {
    double received[3], unshadowed[3];
    double catcher, hidden, background;
  };

  bool kept_;
  ZeroedArray<Sums> sums_;
};

}  // namespace emberline
