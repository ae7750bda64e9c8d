// A denoised image from few samples, with an estimate of its remaining error.
//
// Each pixel is the mean of first-order regressions over the features of the pixels around it,
// weighted by the similarity of their colours (Bitterli et al. 2016, "Nonlinearly Weighted
// First-order Regression for Denoising Monte Carlo Renderings"). A frame's samples come as two
// independent halves, and each half is filtered with the other's weights, so that noise does not
// influence its own weights. The difference of the two filtered halves, and that of the filtered
// and the raw image, measure the error of each candidate (Rousselle et al. 2012, 2013); the best
// combination is chosen per pixel, and the raw image is one of the candidates.
#pragma once

#include <array>
#include <span>
#include <stop_token>
#include <vector>

namespace emberline {

// One plane of a frame, in row order: the sample means of each half.
struct HalfPlanes {
  std::span<const float> a, b;
};
using HalfColour = std::array<HalfPlanes, 3>;  // linear Rec. 709

// All planes have width * height values. NaN and infinities count as 0. A pixel without samples in
// a half is unknown there.

struct DenoiseInput {
  int width = 0, height = 0;
  int x0 = 0, y0 = 0;  // of the first pixel, if this is a part of a frame
  HalfPlanes samples;  // sample counts
  HalfColour colour;
  HalfColour albedo;                 // empty spans: unknown; also a feature
  std::vector<HalfPlanes> features;  // one channel each, of any scale: normals, depth, visibility …
  std::vector<HalfColour> parts;     // images whose sum is `colour`, such as light groups
  // The image from each pixel's samples and those of neighbours that count for it
  // (renderer/film/shared_samples.h), with half the noise before any filter. Empty spans: unknown.
  // Parts have no such image: they are filtered as they are, and the difference between the whole
  // and their sum is split in proportion to them.
  HalfColour shared;
};

struct DenoisedPicture {
  std::array<std::vector<float>, 3> colour;
  std::vector<float> error;  // expected RMS error of the displayed pixel (display_error.h)
  std::vector<std::array<std::vector<float>, 3>> parts;  // same weights: the sum is `colour`
  double squared_error_before = 0.0;  // displayed, summed over pixels; of the raw image
  double squared_error_after = 0.0;
  size_t unchanged_pixels = 0;  // unchanged pixels
};

// A row depends on this many rows above and below. A band of a large frame has the same bits as the
// whole if its input includes this margin (less at the frame's border).
inline constexpr int kDenoiseMargin = 46;
// Rows per band, or fewer in a small frame. The margins are filtered again for each band.
inline constexpr int kDenoiseBandRows = 384;

// Denoises rows [begin, end) of the input; all of it by default. The bits depend neither on the
// threads (TBB's current arena) nor on the bands. Empty after a stop request.
DenoisedPicture denoise(const DenoiseInput& input, int begin, int end,
                        const std::stop_token& stop = {});
DenoisedPicture denoise(const DenoiseInput& input, const std::stop_token& stop = {});

}  // namespace emberline
