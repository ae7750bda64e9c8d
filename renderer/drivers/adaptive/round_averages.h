// Means over rounds that are not biased by adaptive sampling.
//
// A pixel's number of samples in a round is fixed before the round, so the mean of the round's
// samples is unbiased, whatever decided their number. A mean over rounds is also unbiased if the
// weights of the rounds are fixed beforehand. The plain mean of all samples weights each round by
// the pixel's sample count in it, so it is biased: pixels whose samples happen to agree stop early
// (Kirk & Arvo 1991, "Unbiased Sampling Techniques for Image Synthesis"). The price of fixed
// weights is more noise where a pixel's counts differ much from the weights.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace emberline {

class Archive;
class FilmTile;

class RoundAverages {
 public:
  // Adds the mean of each pixel's samples since the last call. The weight must be at most the sum
  // of all earlier weights, except in the first call. Every pixel must have new samples, and the
  // film must have squares (FilmExtras).
  void add_round(const FilmTile& film, double weight);
  bool empty() const { return pixels_.empty(); }
  // Writes R G B A of pixel i of the film; the values are finite.
  void resolve(size_t i, float* rgba) const;
  double mean(size_t i, size_t c) const { return pixels_[i].average[c] / weight_; }
  // Estimated variance of mean(i, c), computed from the difference between each round's mean and
  // the average over all earlier rounds. Rounds are independent, so the estimate is unbiased,
  // however the samples of a round are stratified. For one pixel the estimate is unreliable, but
  // its mean over many pixels is reliable. After a single round, the variance is estimated from two
  // streams if there are two, otherwise as if samples were independent.
  double variance(size_t i, size_t c) const { return pixels_[i].variance[c]; }
  void archive(Archive& archive, const FilmTile& film);
  uint64_t bytes() const { return pixels_.capacity() * sizeof(Pixel); }

 private:
  struct Pixel {
    std::array<double, 4> average;  // sum of weight x mean so far
    std::array<double, 4> sums;     // sums of all samples up to the last round
    double samples;
    std::array<double, 3> variance;  // variance of the average
  };
  std::vector<Pixel> pixels_;
  double weight_ = 0.0;
};

}  // namespace emberline
