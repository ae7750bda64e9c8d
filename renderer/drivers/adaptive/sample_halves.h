// Derives the two halves of a pixel's samples from successive states of the film. The estimator
// `nested` uses them.
//
// In a scrambled Sobol' sequence, all aligned blocks of 2^k samples are nets of the same quality
// (samplers/sobol_sampler.h). Let V(n) be the variance of the mean of n such samples, M the mean of
// n samples, and M1, M2 the means of their first and second half. M1 and M2 have the same variance
// V(n/2) and, by symmetry, the same covariance V(n) with M. Hence
//     E (M1 - M)^2 = E ((M1 - M2) / 2)^2 = V(n/2) - V(n).
// This is the variance that the last doubling removed. It equals V(n) if V ~ 1/n. It overestimates
// V(n) where stratification does better: by a factor of 1.8 for edges (V ~ n^-1.5), and by a factor
// of 3 for V ~ n^-2.
//
// The film keeps only the sum of all of a pixel's samples, so that a frame with equal counts is
// bit-identical to a uniform one. The mean of the first half was the pixel's mean when the count
// was half as large, so this class stores it at that time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "renderer/drivers/adaptive/pixel_statistics.h"

namespace emberline {

class Archive;

// Says at which counts a pixel's samples are divided into two parts.
enum class SampleParts {
  // The first part ends at the last count that is a power of two and at least 8. The later samples
  // form the second part. The parts are compared when the second part is half as large as the
  // first, and when it is as large as the first. At these counts both parts are nets, and large
  // enough for a rare bright sample to show in either part.
  kPowersOfTwo,
  // The first part ends at the count of the last update, whatever that count was. This is for
  // rounds that are independent of each other.
  kEveryUpdate,
};

class SampleHalves {
 public:
  // Compares the two parts' means of R G B and of `more` further values of each pixel.
  explicit SampleHalves(SampleParts parts, size_t more = 0)
      : parts_(parts), mean_(3 + more), difference_(3 + more) {}
  // Writes the current means of the further values of pixel i. Called concurrently.
  using ReadMeans = std::function<void(size_t i, float* means)>;

  // Replaces each stream difference in the statistics by the difference between the means of the
  // pixel's two parts, and sets second_count to n / 2. The difference is scaled as if the parts
  // were halves of all n samples: if the variance of a mean falls as 1 / n, the expected square of
  // the difference is 4 / n times the variance of a sample. second_count and the difference are 0
  // until there are two parts. Between the counts at which parts are compared, the result of the
  // last comparison is used. All calls must be for the same crop.
  void update(PixelStatistics* pixels, const ReadMeans& read_more = {});

  // Let a and b be the sample counts of a pixel's two parts at the last comparison. weights()
  // returns a b / (a + b) for each pixel, or 0 before there are two parts. differences() returns
  // the difference of the parts' means for one of the further values. The weight times the squared
  // difference estimates the variance of a sample, if the variance of a mean falls as 1 / n.
  std::span<const float> weights() const { return weight_; }
  std::span<const float> differences(size_t further) const { return difference_[3 + further]; }

  void archive(Archive& archive, size_t pixels);
  uint64_t bytes() const;

 private:
  void update_range(size_t begin, size_t end, const ReadMeans& read_more, PixelStatistics* pixels);

  SampleParts parts_;
  std::vector<float> count_;              // samples of the first part in the next comparison
  std::vector<std::vector<float>> mean_;  // mean of that part's samples, for R, G, B and the rest
  std::vector<float> weight_;
  std::vector<std::vector<float>> difference_;
};

}  // namespace emberline
