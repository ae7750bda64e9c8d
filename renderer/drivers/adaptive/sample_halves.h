// The two halves of a pixel's samples as a second look shows them: what `nested` judges by
// (nested_estimator.h).
//
// The film only knows the sum of all of a pixel's samples, and keeps it that way, so that a frame
// of equal counts has the bits of a uniform one. What the first half of them came to was the
// pixel's mean when the count was half as large, and is kept here from that look.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "renderer/drivers/adaptive/pixel_statistics.h"

namespace emberline {

// Which of a pixel's counts end a part.
enum class SampleParts {
  kPowersOfTwo,  // from 8 on: in between, the samples since are no net
  kEveryLook,    // rounds that are independent of each other
};

class SampleHalves {
 public:
  explicit SampleHalves(SampleParts parts) : parts_(parts) {}

  // Looks at statistics of a window, always the same one, and puts into the place of the two
  // streams' difference that of the last two parts: a pixel's samples up to the last count but one
  // that ends a part, and those from there to the last. As if the parts were halves of all n
  // samples: second_count is n / 2, and the expected square of the difference 4 / n times the
  // variance of a sample, if that of a mean falls as 1 / n. Both are 0 until there are two parts.
  void look(PixelStatistics* pixels);

  uint64_t bytes() const;

 private:
  void look_at(size_t begin, size_t end, PixelStatistics* pixels);

  SampleParts parts_;
  std::vector<float> count_;                // of the parts up to the last
  std::array<std::vector<float>, 3> mean_;  // of their samples
  // Of the last two parts: the harmonic weight a b / (a + b) of their counts, 0 before there are
  // two, and the difference of their means.
  std::vector<float> weight_;
  std::array<std::vector<float>, 3> difference_;
};

}  // namespace emberline
