// The sums that a film keeps of each pixel: blocks, as the channels in use need them.
//
// A block knows how a sample is added, how the sums of two films are merged and whether sums that
// were loaded are sound; copying and saving are the same for all. A film has one buffer, in which
// each block is a plane, so that a picture, or one under other lights, reads only what it needs.
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

// A pixel's sums over its samples, each times its filter weight.
struct PixelSums {
  double rgb[2][3];  // by stream
  double alpha;
  uint32_t count[2];
  uint32_t non_finite;
  uint32_t id;

  double samples() const { return double(count[0]) + double(count[1]); }
};

// In pixels a frame, over the samples that hit a surface; where none did, over all samples.
struct VelocitySums {
  double x, y;
  uint32_t count;
  uint32_t of_surfaces;  // 1 or 0
};

// The channels and extras that a film is asked for.
struct FilmContents {
  AovSet aovs;
  FilmExtras extras;
};

// In the order in which checkpoints have them.
enum class Sums : uint8_t {
  kPixel,    // PixelSums; of every film
  kSquares,  // double[3]: of weighted R G B
  kRays,     // uint32_t: traced for the pixel
  kSurface,  // the sums of a SumGroup
  kPlace,
  kVelocity,  // VelocitySums
  kClamped,
  kSeconds,  // float
  kStop,     // PixelStop
  kLights,   // LightGroupSums, in two blocks
  kLightRests,
  kLayers,  // the same of PathLayers
  kLayerRests,
  kShadow,
  kHalves,      // HalfSums
  kHalfLights,  // LightGroupSums of the samples of the second half
  kHalfLightRests,
  kMattes,  // CryptomatteSums, in two blocks
  kMatteWeights,
  kOfRow,  // the sums, or the numbers (uint32_t), of a row that shares none; any number of blocks
};
inline constexpr size_t kNamedSums = size_t(Sums::kOfRow);

// A pixel of a film: its number, and where the planes of the film's parts begin.
struct FilmPixel {
  std::byte* const* planes;
  size_t number;
};

class FilmLayout {
 public:
  explicit FilmLayout(const FilmContents& contents);

  struct Part {
    Sums block = Sums::kPixel;
    size_t place = 0;   // among the parts
    size_t bytes = 0;   // a pixel; 0: the film does not have it
    size_t offset = 0;  // bytes a pixel of the planes before it
    // For a SumGroup and kOfRow: the rows, how many sums they have, and whether only samples that
    // hit a surface count; if so, the number of those samples (uint32_t) follows the sums.
    std::span<const ChannelRow> rows = {};
    size_t sums = 0;
    bool of_hits = false;
  };
  const FilmContents& contents() const { return contents_; }
  // In the order of Sums, also those that the film does not have.
  const std::vector<Part>& parts() const { return parts_; }
  const Part& part(Sums block) const { return parts_[size_t(block)]; }
  bool has(Sums block) const { return part(block).bytes > 0; }
  size_t bytes_per_pixel() const { return bytes_; }

  // A row that has sums or numbers: its part, and where they begin in it.
  struct RowSums {
    const Part* part;
    size_t first;
  };
  RowSums sums_of(const ChannelRow& row) const;

  // Adds a sample to a pixel, in index order. One that is not `finite` counts as black.
  void add(const FilmPixel& at, const FilmSample& sample, bool finite) const;
  // Adds the sums that another film with the same layout has of the pixel.
  void merge(const FilmPixel& at, const FilmPixel& more) const;
  // Whether these can be the sums of samples: finite, and within what the arithmetic is made for.
  bool is_sound(const FilmPixel& at) const;
  // Asks for the memory of a pixel ahead of add().
  void prefetch(const FilmPixel& at) const;

 private:
  FilmContents contents_;
  std::vector<Part> parts_;
  std::vector<Part> added_;  // those that take samples, beside PixelSums
  size_t bytes_ = 0;
};

// A block of a pixel.
template <class T>
T* sums_at(const FilmLayout::Part& part, const FilmPixel& at) {
  return reinterpret_cast<T*>(at.planes[part.place] + part.bytes * at.number);
}
// The number of samples in the sums of a part that counts only those that hit a surface.
inline uint32_t& hits_at(const FilmLayout::Part& part, const FilmPixel& at) {
  return *reinterpret_cast<uint32_t*>(sums_at<double>(part, at) + part.sums);
}
// Sums of light in two blocks, of which this is the first.
LightGroupSums lights_at(const FilmLayout& layout, Sums block, const FilmPixel& at);
CryptomatteSums mattes_at(const FilmLayout& layout, const FilmPixel& at);

}  // namespace emberline
