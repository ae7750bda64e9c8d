// Filters a live picture with the fast filter (renderer/reconstruction/fast_filter.h).
#pragma once

#include <span>
#include <vector>

#include "renderer/reconstruction/fast_filter.h"

namespace emberline {

class AovSet;
class LivePicture;
struct PixelLattice;

// Keeps its memory from picture to picture; one at a time.
class LiveDenoiser {
 public:
  // Adds the channels that the filter needs.
  static void add_channels(AovSet& aovs);
  static bool has_channels(const AovSet& aovs);

  static constexpr uint64_t kBytesPerPixel = FastFilter::kBytesPerPixel;

  struct Source {
    const LivePicture& picture;
    const LivePicture* region;    // a part of it, used where it has more samples; or null
    const PixelLattice* lattice;  // the pixels that have samples; null: all have
    double samples_per_pixel;
    bool mixed;  // light groups are: the colours are not the film's
  };
  // Filters R G B A of every pixel of the picture, interleaved, as they are shown. Pixels outside
  // the lattice take the colour of the nearest one on it. Uses TBB's current arena.
  void denoise(const Source& source, std::span<const float> rgba, std::span<float> denoised);

 private:
  void denoise_lattice(const Source& source, std::span<const float> rgba,
                       std::span<float> denoised);

  FastFilter filter_;
  std::vector<float> small_, small_denoised_;  // of a lattice
};

}  // namespace emberline
