// Derives the two halves of a pixel's samples from successive states of the film. The estimator
// `nested` uses them.
//
// In a scrambled Sobol' sequence, all aligned blocks of 2^k samples are nets of the same quality
// (samplers/sobol_sampler.h). So the means M1, M2 of a stream's two halves have the same variance
// V(n/2) and, by symmetry, the same covariance V(n) with their mean M. Hence
//     E (M1 - M)^2 = E ((M1 - M2) / 2)^2 = V(n/2) - V(n),
// the gain of the last doubling. The gain equals V(n) if V ~ 1/n, and overestimates V(n) where
// stratification does better: by a factor of 1.8 for edges (V ~ n^-1.5), and of 3 for V ~ n^-2.
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
  // are compared with the first part when they are half as many or equally many. Both parts are
  // then nets, and large enough for a rare bright sample to show in either.
  kPowersOfTwo,
  // The first part ends at the count of the last update, whatever that count was. This is for
  // rounds that are independent of each other.
  kEveryUpdate,
};

class SampleHalves {
 public:
  // Besides R G B, `more` values of each pixel are also compared between the two parts.
  explicit SampleHalves(SampleParts parts, size_t more = 0)
      : parts_(parts), mean_(3 + more), difference_(3 + more) {}
  // Writes the current means of these further values of pixel i. Called concurrently.
  using ReadMeans = std::function<void(size_t i, float* means)>;

  // Reads the statistics of a crop; all calls must be for the same crop. Replaces each stream
  // difference by the difference between the means of the pixel's two parts, scaled as if these
  // were halves of all n samples. second_count becomes n / 2. If the variance of a mean falls as 1
  // / n, the expected square of the difference is 4 / n times the variance of a sample. Until there
  // are two parts, second_count and the difference are 0. Between the counts at which parts are
  // compared, the last result is kept.
  void update(PixelStatistics* pixels, const ReadMeans& read_more = {});

  // Describe the last two parts of each pixel, with a and b samples: the weight a b / (a + b), and
  // for each further value the difference of the parts' means. The weight is 0 before there are two
  // parts. The weight times the squared difference estimates the variance of a sample, if the
  // variance of a mean falls as 1 / n.
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
