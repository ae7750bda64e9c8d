// A clean picture from few samples, and how wrong it still is.
//
// Each pixel is the mean of first-order regressions over the features of the pixels around it,
// weighted by how alike their colours are (Bitterli et al. 2016, "Nonlinearly Weighted First-order
// Regression for Denoising Monte Carlo Renderings"). A frame's samples come as two independent
// halves: each half is filtered by the other's weights, so that noise does not choose its own
// weights; what the two filtered halves differ by, and what the filtered picture differs from the
// raw one, says how wrong each candidate is (Rousselle et al. 2012, 2013), and the best is taken
// pixel by pixel, the raw picture among them.
#pragma once

#include <array>
#include <span>
#include <stop_token>
#include <vector>

namespace emberline {

// One plane of a frame, row by row: the means over the samples of each half.
struct HalfPlanes {
  std::span<const float> a, b;
};
using HalfColour = std::array<HalfPlanes, 3>;  // linear Rec. 709

// Everything has width * height values. NaN and infinities count as 0. A pixel without samples in a
// half counts as unknown there.

struct DenoiseInput {
  int width = 0, height = 0;
  int x0 = 0, y0 = 0;  // of the first pixel, where this is a part of a frame
  HalfPlanes samples;  // how many
  HalfColour colour;
  HalfColour albedo;                 // empty spans: unknown; also a feature
  std::vector<HalfPlanes> features;  // one channel each, of any scale: normals, depth, visibility …
  std::vector<HalfColour> parts;     // pictures that add up to `colour`, such as light groups
  // The same picture of each pixel's samples and those around it that count for it, too
  // (renderer/film/shared_samples.h): half the noise before any filter. Empty spans: unknown. Parts
  // have no such picture: they are filtered as they are, and what their sum then lacks of the whole
  // is split in proportion to them.
  HalfColour shared;
};

struct DenoisedPicture {
  std::array<std::vector<float>, 3> colour;
  std::vector<float> error;  // expected RMS error of the displayed pixel (display_error.h)
  std::vector<std::array<std::vector<float>, 3>> parts;  // by the same weights: they still add up
  double squared_error_before = 0.0;  // displayed, summed over pixels; of the raw picture
  double squared_error_after = 0.0;
  size_t kept = 0;  // pixels left as they were
};

// A row is decided by the rows around it, as far as this; so a band of a large frame has the bits
// of the whole when its input has this many rows more above and below (fewer at the frame's
// border).
inline constexpr int kDenoiseMargin = 46;
// Of a band, if there are as many: its margins are filtered for it alone.
inline constexpr int kDenoiseBandRows = 384;

// Rows [begin, end) of the input; all of it by default. The same bits whatever the threads (TBB's
// current arena) and whatever the bands. Empty when the stop was asked for.
DenoisedPicture denoise(const DenoiseInput& input, int begin, int end,
                        const std::stop_token& stop = {});
DenoisedPicture denoise(const DenoiseInput& input, const std::stop_token& stop = {});

}  // namespace emberline
