// The error of a picture against a reference that is itself rendered, and so noisy.
//
// The reference is two pictures A and B of independent noise. Where x is independent of both, the
// expectation of (x - A)(x - B) is the squared error of x against the truth: what A and B add to
// (x - A)^2 is their own variance, and there is none in the product of two different ones. The
// price is that a mean of products may come out negative, where x is nearer to the truth than A and
// B are. Taken so are mse, relmse, its trimmed form, and display_mse.
//
// What is no mean of squares (FLIP, percentiles) is against the mean of A and B and has its noise
// in it; so have the choice of the pixels that are trimmed (by squares against the mean) and the
// weights of relmse. The signed bias has the noise of the reference's own sum, which
// `noise_bias` tells.
#pragma once

#include <vector>

#include "renderer/statistics/error_metrics.h"
#include "renderer/statistics/study_results.h"

namespace emberline {

class ReferencePicture {
 public:
  // Two halves of equal size, not empty (asserted). Pixels with a NaN or an infinity in either are
  // left out of everything.
  ReferencePicture(const RgbImage& a, const RgbImage& b);
  // One picture that is taken for the truth: errors are plain squares.
  explicit ReferencePicture(const RgbImage& picture);

  // `picture` has the reference's size (asserted) and is finite. The same bits for any number of
  // threads.
  StudyError measure(const RgbImage& picture) const;
  // FLIP per pixel against the mean, flip.h's map.
  std::vector<float> flip(const RgbImage& picture) const;

  const RgbImage& mean() const { return mean_; }
  double epsilon() const { return epsilon_; }  // of relmse: 0.01 (mean r)^2, 0.01 if that is 0
  // Fills in the noise of the mean and epsilon. Noise is 0 for a picture taken for the truth.
  void describe(StudyReference* out) const;

 private:
  RgbImage a_, b_, mean_;
  std::vector<uint8_t> masked_;
  RgbImage display_a_, display_b_, display_mean_;
  double epsilon_ = 0, sum_ = 0;
  size_t pixels_ = 0;  // that are not masked
};

}  // namespace emberline
