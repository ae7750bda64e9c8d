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
#include <vector>

#include "renderer/core/archive.h"
#include "renderer/film/film.h"

namespace emberline {

class RoundAverages {
 public:
  // Adds the mean of the samples that each pixel has got since the last call, with this weight.
  // Every pixel must have got some.
  void add_round(const FilmTile& film, double weight);
  bool empty() const { return rounds_.empty(); }
  // R G B A of pixel i of the film. Finite.
  void resolve(size_t i, float* rgba) const;
  // How many samples of a plain mean are as sure as pixel i's average, if the variance of a round's
  // mean falls as 1 / n: W^2 / sum(w^2 / n). All of the pixel's where they came as the weights are.
  double effective_samples(size_t i) const { return weight_ * weight_ / rounds_[i].noise; }
  void archive(Archive& archive, const FilmTile& film);
  uint64_t bytes() const { return rounds_.capacity() * sizeof(Pixel); }

 private:
  struct Pixel {
    std::array<double, 4> average;  // times the weights so far
    std::array<double, 4> sums;     // of all samples up to the last round
    double samples;
    double noise;  // sum of w^2 / n
  };
  std::vector<Pixel> rounds_;
  double weight_ = 0.0;
};

}  // namespace emberline
