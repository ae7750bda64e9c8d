// Error of a picture against a reference that is itself rendered and therefore noisy.
//
// The reference is two pictures A and B with independent noise. If x is independent of both, the
// expectation of (x - A)(x - B) is the squared error of x against the truth: the variance of A or B
// adds to (x - A)^2 or (x - B)^2, but not to the product. The price is that a mean of products may
// be negative if x is closer to the truth than A and B. This applies to mse, relmse, its trimmed
// form, and display_mse.
//
// Measures that are not means of squares (FLIP, percentiles) compare with the mean of A and B and
// include its noise. So do the choice of trimmed pixels (by squares against the mean) and the
// weights of relmse. The signed bias includes the noise of the reference's sum, which `noise_bias`
// estimates.
#pragma once

#include <vector>

#include "renderer/statistics/error_metrics.h"
#include "renderer/statistics/study_results.h"

namespace emberline {

class ReferencePicture {
 public:
  // Two halves of equal size, not empty (asserted). Pixels with a NaN or infinity in either are
  // excluded from everything.
  ReferencePicture(const RgbImage& a, const RgbImage& b);
  // A single picture that counts as the truth: errors are plain squares.
  explicit ReferencePicture(const RgbImage& picture);

  // `picture` has the reference's size (asserted) and is finite. The same bits for any number of
  // threads.
  StudyError measure(const RgbImage& picture) const;
  // FLIP per pixel against the mean; see flip.h.
  std::vector<float> flip(const RgbImage& picture) const;

  const RgbImage& mean() const { return mean_; }
  double epsilon() const { return epsilon_; }  // of relmse: 0.01 (mean r)^2, or 0.01 if that is 0
  // Sets the noise of the mean, and epsilon. The noise is 0 for a picture that counts as the truth.
  void set_noise(StudyReference* out) const;

 private:
  RgbImage a_, b_, mean_;
  std::vector<uint8_t> masked_;
  RgbImage display_a_, display_b_, display_mean_;
  double epsilon_ = 0, sum_ = 0;
  size_t pixels_ = 0;  // number of unmasked pixels
};

}  // namespace emberline
