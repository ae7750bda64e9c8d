// Denoises an image of few samples, and estimates the remaining error.
//
// Each pixel is the mean of first-order regressions over the features of the pixels around it,
// weighted by the similarity of their colours (Bitterli et al. 2016, "Nonlinearly Weighted
// First-order Regression for Denoising Monte Carlo Renderings"). A frame's samples come as two
// independent halves. Each half is filtered with the weights of the other half, so that its own
// noise does not influence these weights. The error of each filtered image is measured by the
// difference of its two halves and by its difference from the raw image (Rousselle et al. 2012,
// 2013). For each pixel the best combination of the filtered images and the raw image is chosen.
//
// In a sequence, the halves that are filtered can be means over several frames
// (renderer/reconstruction/accumulate.h). Their error is still measured against the raw image of
// the frame alone, so light that has changed since the neighbouring frames is not blended in.
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
// a half is unknown in that half.

struct DenoiseInput {
  int width = 0, height = 0;
  int x0 = 0, y0 = 0;  // the first pixel's position, if this is a part of a frame
  HalfPlanes samples;  // sample counts
  HalfColour colour;
  HalfColour albedo;                 // also used as a feature; empty if unknown
  std::vector<HalfPlanes> features;  // one channel each, in any scale: normals, depth, visibility …
  // The difference that each feature may have in another frame and still belong to the same
  // surface. Used only with neighbours. If the list is shorter than `features`, only the first
  // features are compared.
  std::vector<float> tolerances;
  std::vector<HalfColour> parts;  // images whose sum is `colour`, such as light groups
  // The image in which each pixel's samples are combined with those of its neighbours
  // (renderer/film/shared_samples.h). This halves the noise before any filter. The spans are empty
  // if the image is unknown. Parts have no such image: their own samples are filtered, and the
  // difference between the whole and the sum of the parts is distributed in proportion to the
  // parts.
  HalfColour shared;
};

// A frame of the sequence near the frame that is denoised.
struct NeighbourFrame {
  // Has the same width and the same kinds of planes as the denoised frame's input, but may have
  // other rows.
  DenoiseInput input;
  // For each pixel of the denoised frame's input, the position in this `input` of the surface point
  // that the pixel shows. 0 is the centre of the first pixel. NaN if the point is not visible there
  // or its position is unknown. `input` must include all rows of the neighbouring frame within
  // kNeighbourReach of a position.
  std::span<const float> x, y;
};
inline constexpr int kNeighbourReach = 4;

struct DenoisedPicture {
  std::array<std::vector<float>, 3> colour;
  std::vector<float> error;  // expected RMS error of the displayed pixel (display_error.h)
  std::vector<std::array<std::vector<float>, 3>> parts;  // filtered; their sum is `colour`
  double squared_error_before = 0.0;  // of the displayed raw image, summed over pixels
  double squared_error_after = 0.0;
  size_t unchanged_pixels = 0;  // number of pixels that filtering does not change visibly
  double frames = 0.0;          // number of frames that a pixel combines, summed over pixels
};

// A row depends on this many rows above it and below it, or on kDenoiseMargin + kAcrossMargin rows
// if there are neighbours. The input of a band of a large frame must include this margin, or less
// at the frame's border. The band is then bit-identical to the same rows of the whole frame.
inline constexpr int kDenoiseMargin = 46;
inline constexpr int kAcrossMargin = 11;

// Denoises rows [begin, end) of the input, or all rows. The result's bits depend neither on the
// threads (TBB's current arena) nor on the bands. Returns an empty picture after a stop request.
DenoisedPicture denoise(const DenoiseInput& input, int begin, int end,
                        const std::stop_token& stop = {},
                        std::span<const NeighbourFrame> neighbours = {});
DenoisedPicture denoise(const DenoiseInput& input, const std::stop_token& stop = {},
                        std::span<const NeighbourFrame> neighbours = {});

}  // namespace emberline
