// What a film keeps of each pixel: one record, laid out from the channels in use.
//
// A record is a row of blocks. Each block holds the sums that some channels need, and knows how a
// sample is added, how two films' sums are merged and whether sums that were loaded are sound;
// copying and saving are the same for all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
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

// Pixels a frame: of the samples that hit a surface, or where none did of all of them.
struct VelocitySums {
  double x, y;
  uint32_t count;
  uint32_t of_surfaces;  // 1 or 0
};

// Of a film that was asked for these channels and extras.
struct FilmContents {
  AovSet aovs;
  FilmExtras extras;
};

// In the order in which checkpoints have them.
enum class Sums : uint8_t {
  kPixel,    // PixelSums; the first in every record
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

class RecordLayout {
 public:
  explicit RecordLayout(const FilmContents& contents);

  struct Part {
    Sums block = Sums::kPixel;
    size_t bytes = 0, offset = 0;  // bytes 0: the film does not have it
    // Of a SumGroup or kOfRow: its rows, how many sums they have, and whether these are of the
    // samples that hit a surface alone; their number (uint32_t) follows then.
    std::span<const ChannelRow> rows = {};
    size_t sums = 0;
    bool of_hits = false;
  };
  const FilmContents& contents() const { return contents_; }
  // In the order of Sums, also those that the film does not have.
  const std::vector<Part>& parts() const { return parts_; }
  const Part& part(Sums block) const { return parts_[size_t(block)]; }
  bool has(Sums block) const { return part(block).bytes > 0; }
  size_t stride() const { return stride_; }

  // Where in a record the sums or numbers of a row are that has some, and the number of their
  // samples if these are not all of the pixel's.
  struct SumPlace {
    size_t sums;
    std::optional<size_t> hits;
  };
  SumPlace place_of(const ChannelRow& row) const;

  // A sample of the pixel, in index order; not `finite`: it counts as black.
  void add(std::byte* record, const FilmSample& sample, bool finite) const;
  // What another film with the same layout has of the pixel.
  void merge(std::byte* record, const std::byte* more) const;
  // Whether these can be the sums of samples: finite, and within what the arithmetic is made for.
  bool is_sound(const std::byte* record) const;

 private:
  FilmContents contents_;
  std::vector<Part> parts_;
  std::vector<Part> added_;  // those that take samples, beside PixelSums
  size_t stride_ = 0;
};

// A block of a record.
template <class T>
T* sums_at(const RecordLayout::Part& part, std::byte* record) {
  return reinterpret_cast<T*>(record + part.offset);
}
template <class T>
const T* sums_at(const RecordLayout::Part& part, const std::byte* record) {
  return reinterpret_cast<const T*>(record + part.offset);
}
// Sums of light in two blocks, of which `part` is the first.
LightGroupSums lights_at(const RecordLayout::Part& part, const std::byte* record);
CryptomatteSums mattes_at(const RecordLayout& layout, const std::byte* record);

}  // namespace emberline
