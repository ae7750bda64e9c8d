// The two halves of a pixel's samples, derived from successive states of the film; `nested` uses
// them.
//
// Every aligned block of a scrambled Sobol' sequence with a power of two of samples is a net like
// any other (samplers/sobol_sampler.h), so the means M1, M2 of a stream's halves have the same
// variance V(n/2) and, by symmetry, the same covariance V(n) with their mean M. Hence
//     E (M1 - M)^2 = E ((M1 - M2) / 2)^2 = V(n/2) - V(n),
// the gain of the last doubling. It equals V(n) if V ~ 1/n, and overestimates V(n) where
// stratification does better: by a factor of 1.8 for edges (V ~ n^-1.5), and of 3 for V ~ n^-2.
//
// The film keeps only the sum of all of a pixel's samples, so that a frame with equal counts has
// the bits of a uniform one. The mean of the first half was the pixel's mean when the count was
// half as large; it is stored here at that update.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "renderer/drivers/adaptive/pixel_statistics.h"

namespace emberline {

class Archive;

// The counts that divide a pixel's samples into two parts.
enum class SampleParts {
  // The parts divide at the last power of two that is at least 8. The later samples are compared
  // with the first part when they are half as many or equally many. Both parts are then nets, and
  // large enough for a rare bright sample to show in either.
  kPowersOfTwo,
  // The parts divide at the count of the last update, whatever it was; for rounds that are
  // independent of each other.
  kEveryUpdate,
};

class SampleHalves {
 public:
  explicit SampleHalves(SampleParts parts) : parts_(parts) {}

  // Reads the statistics of a crop, which must be the same in all calls, and replaces the
  // difference of two streams by the difference of the means of a pixel's two parts, scaled as if
  // they were halves of all n samples: second_count is n / 2, and the expected square of the
  // difference is 4 / n times the variance of a sample, if the variance of a mean falls as 1 / n.
  // Both are 0 until there are two parts. Between counts where parts are compared, the last result
  // is kept.
  void update(PixelStatistics* pixels);

  void archive(Archive& archive, size_t pixels);
  uint64_t bytes() const;

 private:
  void update_range(size_t begin, size_t end, PixelStatistics* pixels);

  SampleParts parts_;
  std::vector<float> count_;                // samples of the first part in the next comparison
  std::array<std::vector<float>, 3> mean_;  // mean of that part's samples
  // For the last two parts, with a and b samples: the weight a b / (a + b), 0 before there are two,
  // and the difference of their means.
  std::vector<float> weight_;
  std::array<std::vector<float>, 3> difference_;
};

}  // namespace emberline
