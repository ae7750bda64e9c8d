// Filters a live picture with the fast filter (renderer/reconstruction/fast_filter.h).
#pragma once

#include <span>
#include <vector>

#include "renderer/reconstruction/fast_filter.h"

namespace emberline {

class AovSet;
class LivePicture;
struct PixelLattice;

// Reuses its memory between pictures. Not thread-safe.
class LiveDenoiser {
 public:
  // Adds the channels that the filter needs.
  static void add_channels(AovSet& aovs);
  static bool has_channels(const AovSet& aovs);

  static constexpr uint64_t kBytesPerPixel = FastFilter::kBytesPerPixel;

  struct Source {
    const LivePicture& picture;
    // A picture of a region of the frame, used for pixels that have more samples in it. May be
    // null.
    const LivePicture* region;
    const PixelLattice* lattice;  // the pixels with samples; null: all pixels
    double samples_per_pixel;
    bool mixed;  // light groups were remixed, so the colours differ from those of the film
  };
  // Filters the displayed R G B A (interleaved) of every pixel of the picture. Pixels outside the
  // lattice get the filtered value of the nearest lattice pixel. Uses TBB's current arena.
  void denoise(const Source& source, std::span<const float> rgba, std::span<float> denoised);

 private:
  void denoise_lattice(const Source& source, std::span<const float> rgba,
                       std::span<float> denoised);

  FastFilter filter_;
  std::vector<float> lattice_rgba_, lattice_denoised_;  // colours of the lattice's pixels
};

}  // namespace emberline
