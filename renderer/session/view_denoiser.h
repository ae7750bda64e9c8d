// Between a frame's film and the fast filter (renderer/reconstruction/fast_filter.h).
#pragma once

#include <span>
#include <vector>

#include "renderer/reconstruction/fast_filter.h"

namespace emberline {

class AovSet;
class FilmTile;
struct PixelLattice;

// Keeps its memory from picture to picture; one at a time.
class ViewDenoiser {
 public:
  // What a frame's film needs beside R G B A.
  static void add_channels(AovSet& aovs);
  static bool has_channels(const AovSet& aovs);

  static constexpr uint64_t kBytesPerPixel = FastFilter::kBytesPerPixel;

  struct Source {
    const FilmTile& film;
    const FilmTile* region;       // of some pixels, with more samples where it has more; or null
    const PixelLattice* lattice;  // the pixels that have samples; null: all have
    double samples_per_pixel;
    bool mixed;  // light groups are: colours are not the film's
  };
  // R G B A of every pixel of the film, interleaved, as they are shown, to the same filtered.
  // Around the pixels of a lattice the others take the nearest one's colour. On TBB's current
  // arena.
  void denoise(const Source& source, std::span<const float> rgba, std::span<float> denoised);

 private:
  void denoise_lattice(const Source& source, std::span<const float> rgba,
                       std::span<float> denoised);

  FastFilter filter_;
  std::vector<float> small_, small_denoised_;  // of a lattice
};

}  // namespace emberline
