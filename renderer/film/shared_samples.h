// Combines each pixel's samples with those of its neighbours (PixelFilter::shares).
//
// With each pixel, a film stores what the pixel's samples contribute to the 3 x 3 pixels around it
// (9 x 4 values for each half), because a pixel's owner never writes to neighbouring pixels. In a
// finished frame the contributions are summed for each receiving pixel: half1.shared.{R,G,B}
// replaces half1.shared.K.{R,G,B,A}, and half2 is treated in the same way.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "renderer/core/rect.h"

namespace emberline {

// Returns the channel names after the shares are summed. Channels other than the shares keep their
// names.
std::vector<std::string> resolved_channel_names(std::span<const std::string> channels);

// Reads rows of a frame, and replaces each pixel's shares by the sums for that pixel.
class ShareResolver {
 public:
  // Reads rows of the crop with all of `channels`, interleaved. It is called more than once for
  // some rows.
  using Read = std::function<void(const Rect& rows, std::vector<float>& pixels)>;
  ShareResolver(const Rect& crop, std::span<const std::string> channels, Read read);

  // Writes rows of the crop, with the channels of resolved_channel_names(). A pixel at the crop's
  // border, or with a neighbour that has far fewer samples, gets the mean of its own samples. Uses
  // the calling thread's TBB arena. Calls must not overlap.
  void read(const Rect& rows, std::vector<float>& pixels);

 private:
  struct HalfChannels {
    size_t own, samples, shared;  // indices of channels
  };
  void sum_row(const Rect& padded_rows, int y, float* to) const;
  void put_sums(const float* pixel, size_t row_stride, bool inside, const HalfChannels& half,
                float* to) const;

  const Rect crop_;
  const size_t channels_;
  const Read read_;
  std::vector<HalfChannels> halves_;  // in channel order; empty: nothing to sum
  std::vector<float> input_rows_;
};

void resolve_shares(const Rect& crop, std::vector<std::string>& channels,
                    std::vector<float>& pixels);

}  // namespace emberline
