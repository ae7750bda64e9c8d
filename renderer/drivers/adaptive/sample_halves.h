// The two halves of a pixel's samples as a second look shows them: what `nested` judges by.
//
// Every aligned block of a power of two of a scrambled Sobol' sequence is a net like any other
// (samplers/sobol_sampler.h), so the means M1, M2 of a stream's halves have the same variance
// V(n/2) and, by symmetry, the same covariance with their mean M, V(n). Hence
//     E (M1 - M)^2 = E ((M1 - M2) / 2)^2 = V(n/2) - V(n),
// what the last doubling has brought. It is V(n) itself where V ~ 1/n, and too large where
// stratification does better: 1.8 times for edges (V ~ n^-1.5), 3 times for V ~ n^-2.
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

class Archive;

// Which of a pixel's counts part its samples in two.
enum class SampleParts {
  // The last power of two, from 8 on; what has come since is looked at when it is half as many, or
  // as many: nets then, and both large enough that a rare bright sample shows, whichever it is in.
  kPowersOfTwo,
  // That of the last look, whatever it was: for rounds that are independent of each other.
  kEveryLook,
};

class SampleHalves {
 public:
  explicit SampleHalves(SampleParts parts) : parts_(parts) {}

  // Looks at statistics of a crop, always the same one, and puts into the place of the two
  // streams' difference that of the means of a pixel's two parts. As if they were halves of all n
  // samples: second_count is n / 2, and the expected square of the difference 4 / n times the
  // variance of a sample, if that of a mean falls as 1 / n. Both are 0 until there are two parts;
  // between two counts to be looked at, the last look's stands.
  void look(PixelStatistics* pixels);

  void archive(Archive& archive, size_t pixels);
  uint64_t bytes() const;

 private:
  void look_at(size_t begin, size_t end, PixelStatistics* pixels);

  SampleParts parts_;
  std::vector<float> count_;                // of the first part to come
  std::array<std::vector<float>, 3> mean_;  // of its samples
  // Of the last two parts: the weight a b / (a + b) of their counts, 0 before there are two, and
  // the difference of their means.
  std::vector<float> weight_;
  std::array<std::vector<float>, 3> difference_;
};

}  // namespace emberline
