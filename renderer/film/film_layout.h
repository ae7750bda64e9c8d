// The sums that a film keeps for each pixel. They are divided into blocks, and the channels in use
// decide which blocks a film has.
//
// A block knows how to add a sample, merge the sums of two films and validate loaded sums. Copying
// and saving work the same way for all blocks. Each block is a plane of the film's single buffer,
// so code that resolves or relights a picture reads only the planes that it needs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "renderer/film/channels.h"
#include "renderer/film/cryptomatte_sums.h"
#include "renderer/film/film_extras.h"
#include "renderer/film/film_sample.h"
#include "renderer/film/light_group_sums.h"

namespace emberline {

// Sums over a pixel's samples, each multiplied by its filter weight.
struct PixelSums {
  double rgb[2][3];  // for each stream
  double alpha;
  uint32_t count[2];
  uint32_t non_finite;
  uint32_t id;

  double samples() const { return double(count[0]) + double(count[1]); }
};

// Sums of velocities in pixels per frame. They are over the samples that hit a surface, or over all
// samples if none did.
struct VelocitySums {
  double x, y;
  uint32_t count;
  uint32_t surfaces_only;  // 1 if the sums are over surfaces, else 0
};

// The channels and extras of a film.
struct FilmContents {
  AovSet aovs;
  FilmExtras extras;
};

// The blocks of sums, in the order in which checkpoints store them.
enum class Sums : uint8_t {
  kPixel,    // PixelSums; always present
  kSquares,  // double[3]: squares of weighted R G B
  kRays,     // uint32_t: rays traced for the pixel
  kSurface,  // the sums of a SumGroup
  kPositionUv,
  kVelocity,  // VelocitySums
  kClamped,
  kSeconds,  // float
  kStop,     // uint8_t: stop_value()
  kLights,   // LightGroupSums, in two blocks
  kLightRemainders,
  kLayers,  // LightGroupSums of PathLayers
  kLayerRemainders,
  kShadow,
  kHalves,      // HalfSums
  kHalfLights,  // LightGroupSums of the second half of the samples
  kHalfLightRemainders,
  kMattes,  // CryptomatteSums, in two blocks
  kMatteWeights,
  kRow,  // sums (double) or counters (uint32_t) of a row outside all groups; any number of blocks
};
inline constexpr size_t kNamedSums = size_t(Sums::kRow);

// A pixel of a film: its index, and the start of each block's plane.
struct FilmPixel {
  std::byte* const* planes;
  size_t index;
};

class FilmLayout {
 public:
  explicit FilmLayout(const FilmContents& contents);

  // How the film stores one block.
  struct Part {
    Sums block = Sums::kPixel;
    size_t index = 0;   // index among the parts
    size_t bytes = 0;   // per pixel; 0: the film lacks the block
    size_t offset = 0;  // bytes per pixel of the preceding planes
    // For a SumGroup or kRow: the rows, the total number of their sums, and whether only samples
    // that hit a surface count. If so, the number of those samples (uint32_t) follows the sums.
    std::span<const ChannelRow> rows = {};
    size_t sums = 0;
    bool hits_only = false;
  };
  const FilmContents& contents() const { return contents_; }
  // One part per block, in the order of Sums, including the blocks that the film lacks.
  const std::vector<Part>& parts() const { return parts_; }
  const Part& part(Sums block) const { return parts_[size_t(block)]; }
  bool has(Sums block) const { return part(block).bytes > 0; }
  size_t bytes_per_pixel() const { return bytes_; }

  // The part that contains a row's sums or counters, and the index of the row's first sum within
  // the part.
  struct RowSums {
    const Part* part;
    size_t first;
  };
  RowSums sums_of(const ChannelRow& row) const;

  // Adds a sample to a pixel. A pixel's samples must come in index order. If `finite` is false, the
  // sample counts as black.
  void add(const FilmPixel& at, const FilmSample& sample, bool finite) const;
  // Adds another film's sums of the pixel. Both films must have the same layout.
  void merge(const FilmPixel& at, const FilmPixel& more) const;
  // Whether samples can have produced these sums, that is, whether the sums are finite and within
  // the limits of the arithmetic.
  bool is_valid(const FilmPixel& at) const;
  // Prefetches a pixel's memory ahead of add().
  void prefetch(const FilmPixel& at) const;

 private:
  FilmContents contents_;
  std::vector<Part> parts_;
  std::vector<Part> sampled_parts_;  // parts to which samples are added, except PixelSums
  size_t bytes_ = 0;
};

template <class T>
T* sums_at(const FilmLayout::Part& part, const FilmPixel& at) {
  return reinterpret_cast<T*>(at.planes[part.index] + part.bytes * at.index);
}
// Returns the number of samples that hit a surface, for a part with hits_only.
inline uint32_t& hits_at(const FilmLayout::Part& part, const FilmPixel& at) {
  return *reinterpret_cast<uint32_t*>(sums_at<double>(part, at) + part.sums);
}
// `block` is the first of the two blocks of light sums.
LightGroupSums lights_at(const FilmLayout& layout, Sums block, const FilmPixel& at);
CryptomatteSums mattes_at(const FilmLayout& layout, const FilmPixel& at);

}  // namespace emberline
