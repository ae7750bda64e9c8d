// Measures the errors of a picture against a reference that is itself rendered and therefore noisy.
//
// The reference consists of two pictures A and B with independent noise. If x is independent of
// both, the expectation of (x - A)(x - B) is the squared error of x against the truth. The variance
// of A adds to (x - A)^2 and that of B adds to (x - B)^2, but neither adds to the product. The
// drawback is that a mean of products may be negative if x is closer to the truth than A and B are.
// mse, relmse, trimmed relmse and display_mse are computed in this way.
//
// Metrics that are not means of squares (FLIP, percentiles) compare x with the mean of A and B, so
// they include the noise of this mean. The noise also affects the weights of relmse. It also
// affects which pixels are trimmed, because these are the pixels with the largest squared
// differences from the mean. The signed bias includes the noise of the reference's sum, which
// `noise_bias` estimates.
#pragma once

#include <vector>

#include "renderer/statistics/error_metrics.h"
#include "renderer/statistics/study_results.h"

namespace emberline {

class ReferencePicture {
 public:
  // The halves must have equal size and must not be empty (asserted). Pixels with a NaN or infinity
  // in either half are excluded from all metrics.
  ReferencePicture(const RgbImage& a, const RgbImage& b);
  // Treats a single picture as the truth, so that errors are plain squares.
  explicit ReferencePicture(const RgbImage& picture);

  // `picture` must have the size of the reference (asserted) and must be finite. The result is
  // bit-identical for any number of threads.
  StudyError measure(const RgbImage& picture) const;
  // Returns the FLIP error of each pixel against the mean of the halves; see flip.h.
  std::vector<float> flip(const RgbImage& picture) const;

  const RgbImage& mean() const { return mean_; }
  double epsilon() const { return epsilon_; }  // of relmse: 0.01 (mean r)^2; 0.01 if mean r is 0
  // Sets epsilon and the noise of the mean in `out`. The noise is 0 if the reference is a single
  // picture.
  void set_noise(StudyReference* out) const;

 private:
  RgbImage a_, b_, mean_;
  std::vector<uint8_t> masked_;
  RgbImage display_a_, display_b_, display_mean_;
  double epsilon_ = 0, sum_ = 0;
  size_t pixels_ = 0;  // number of unmasked pixels
};

}  // namespace emberline
