// A mean over rounds that adaptive sampling cannot bias.
//
// How many samples a pixel gets in a round is known before the round, so the mean of those samples
// alone has the right expectation, whatever decided their number. Weighing the rounds by numbers
// that are fixed beforehand keeps it; weighing them by the pixel's counts, as the plain mean of all
// samples does, does not: lucky pixels stop early (Kirk & Arvo 1991, "Unbiased Sampling Techniques
// for Image Synthesis"). The price is noise where a pixel's counts are far from the weights.
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
  // Adds the mean of the samples that each pixel has got since the last call, with this weight: no
  // more than all rounds before it have together. Every pixel must have got some. The film has
  // squares (FilmExtras).
  void add_round(const FilmTile& film, double weight);
  bool empty() const { return rounds_.empty(); }
  // R G B A of pixel i of the film. Finite.
  void resolve(size_t i, float* rgba) const;
  double mean(size_t i, size_t c) const { return rounds_[i].average[c] / weight_; }
  // Estimate of that mean's variance, from how far each round's mean is from that of all before it.
  // Rounds are independent, so it has the right expectation however well the samples of a round are
  // stratified. Its own spread is large: one pixel's says little, the mean of many is sure. Of one
  // round alone: from two streams, or as if samples were independent.
  double variance(size_t i, size_t c) const { return rounds_[i].variance[c]; }
  void archive(Archive& archive, const FilmTile& film);
  uint64_t bytes() const { return rounds_.capacity() * sizeof(Pixel); }

 private:
  struct Pixel {
    std::array<double, 4> average;  // times the weights so far
    std::array<double, 4> sums;     // of all samples up to the last round
    double samples;
    std::array<double, 3> variance;  // of the average
  };
  std::vector<Pixel> rounds_;
  double weight_ = 0.0;
};

}  // namespace emberline
