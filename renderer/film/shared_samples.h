// What the pixels around a pixel count of their samples for it (PixelFilter::shares), summed up.
//
// A film keeps it apart by the pixel it is for, nine times four numbers of each half: a pixel has
// one owner, who never writes to its neighbours. Once a frame's pixels are there, their sums are
// all that anybody wants: half1.shared.{R,G,B}, and of the second half as well, in the place of
// half1.shared.K.{R,G,B,A}.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "renderer/core/rect.h"

namespace emberline {

// The names of channels when that is done; those that have nothing to sum are as they were.
std::vector<std::string> with_shared_sums(std::span<const std::string> channels);

// Rows of a frame with the sums, made of rows of its films.
class SharedRows {
 public:
  // Fills rows of the crop, interleaved, of `channels`; some of them more than once.
  using Read = std::function<void(const Rect& rows, std::vector<float>& pixels)>;
  SharedRows(const Rect& crop, std::span<const std::string> channels, Read read);

  // Rows of the crop, as with_shared_sums() names their channels. A pixel at the crop's border, or
  // one whose neighbours have far fewer samples, has the mean of its own samples. On the calling
  // thread's TBB arena; one call at a time.
  void read(const Rect& rows, std::vector<float>& pixels);

 private:
  struct HalfPlaces {
    size_t own, samples, shared;  // of the channels
  };
  void sum_row(const Rect& around, int y, float* to) const;
  void put_sums(const float* pixel, size_t row_stride, bool inside, const HalfPlaces& half,
                float* to) const;

  const Rect crop_;
  const size_t channels_;
  const Read read_;
  std::vector<HalfPlaces> halves_;  // by their place; none where there is nothing to sum
  std::vector<float> films_;
};

// All of a picture at once.
void sum_shared(const Rect& crop, std::vector<std::string>& channels, std::vector<float>& pixels);

}  // namespace emberline
