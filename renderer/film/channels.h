// The channels of a picture: one table, and everything that is done with channels loops over it.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/core/names.h"
#include "renderer/core/picture_channel.h"

namespace emberline {

class FilmTile;
struct FilmSample;

// A row of channel_table() by its place there. Only rows that code asks for by name have an
// enumerator.
enum class Aov : uint8_t {
  kPicture,  // R G B A
  kSamples,
  kVariance,
  kAlbedo,
  kNormal,
  kDepth,
  kPosition,
  kUv,
  kVelocity,
  kClamped,
  kDirect,  // as in PathLayer
  kIndirect,
  kEmission,
  kTransmission,
  kReflection,
  kEnvironment,
  kShadow,
  kDenoising,
  kId,
  kTime,
  kStop,
  kNonFinite,
  kPart,
  kRays,
};

// How the samples of a pixel become its value.
enum class ChannelKind : uint8_t {
  kMean,        // over all samples
  kMeanOfHits,  // over the samples that hit a surface; `background` without one
  kVarianceOfHits,
  kFirstHit,  // of the first sample that hits a surface
  kCount,     // sum over all samples
  kAssigned,  // no sample's doing
  kRatio,     // of two sums
  kDerived,   // from other sums
  kIds,       // ids and how much of the pixel each covers
};

// Where the values of a channel come from.
enum class ChannelFeed : uint8_t {
  kRadiance,
  kFirstHit,  // SampleValue::first_hit
  kHitId,     // first_hit.id alone
  kRays,      // SampleValue::rays
  kClamping,
  kLights,
  kPaths,  // what the path loop records of a whole path
  kCatchers,
  kFeatures,  // DenoiserFeatures and SampleShares
  kClock,
  kDriver,
  kMerge,
};

// How exactly a file must keep the values.
enum class ChannelUse : uint8_t {
  kColour,  // half floats, and lossy compression
  kNumber,  // half floats
  kExact,   // neither
  kWhole,   // whole numbers of 32 bits
};

// Neighbouring rows that share a block of sums: a film that has one of them keeps the sums of all.
// A row of kNone has a block of its own.
enum class SumGroup : uint8_t { kNone, kSurface, kPlace, kClamped, kShadow };

std::string_view name_of(ChannelKind kind);  // "mean of hits"
// Whether a file may hold half floats of it.
inline bool may_be_half(ChannelUse use) {
  return use == ChannelUse::kColour || use == ChannelUse::kNumber;
}

struct ChannelRow {
  std::string_view name;  // the layer of an EXR, and what the setting calls it
  std::span<const std::string_view> components = {};  // none: one value, of the layer's name
  ChannelKind kind;
  ChannelFeed feed;
  ChannelUse use;
  std::string_view unit = {};        // empty: none, or that of radiance
  std::string_view setting = "aov";  // that asks for it; empty: it is always there
  std::string_view summary;
  bool denoised = false;  // `denoise` makes a clean one of it
  // Adds a finite sample to the row's sums. There is one sum for each component unless `sums` says
  // otherwise. kMeanOfHits and kVarianceOfHits get only the samples that hit a surface.
  SumGroup group = SumGroup::kNone;
  void (*add)(const FilmSample& sample, double* sums) = nullptr;
  uint32_t sums = 0;
  float background = 0.0f;  // without such a sample
  // For kCount: adds a sample to the row's numbers, one for each component. For kFirstHit: writes
  // the sample's number, and is called until that is not 0.
  void (*count)(const FilmSample& sample, uint32_t* numbers) = nullptr;
  // Writes the values of pixel i. Null: the film makes them from the sums by their kind.
  void (*put)(const FilmTile& film, size_t i, float* values) = nullptr;
  // The names of the channels, where a list of components does not do.
  std::vector<PictureChannel> (*channels)() = nullptr;

  size_t size() const { return components.empty() ? 1 : components.size(); }
  size_t sum_count() const { return sums > 0 ? sums : add ? size() : 0; }
  bool is_of_hits() const {
    return kind == ChannelKind::kMeanOfHits || kind == ChannelKind::kVarianceOfHits;
  }
};

// All channels, in the order in which pictures have them.
std::span<const ChannelRow> channel_table();
const ChannelRow& row_of(Aov aov);
// The rows that the setting `aov` can ask for.
std::span<const NamedValue<Aov>> aov_table();

// The rows that a film has beside those that are always there.
class AovSet {
 public:
  static constexpr size_t kMost = 64;
  void insert(Aov aov) { bits_ |= bit(aov); }
  bool contains(Aov aov) const { return (bits_ & bit(aov)) != 0; }
  bool empty() const { return bits_ == 0; }
  // Whether one of the rows comes from this feed, or keeps sums in this group.
  bool needs(ChannelFeed feed) const;
  bool needs(SumGroup group) const;
  // "variance,N" -> set. Throws UsageError that lists the valid names.
  static AovSet parse(std::string_view list);

 private:
  static constexpr uint64_t bit(Aov aov) { return uint64_t(1) << uint32_t(aov); }
  uint64_t bits_ = 0;
};

// The rows of a film, in the order of the table; the channels of one and of all of them.
std::vector<const ChannelRow*> rows_of(const AovSet& aovs);
std::vector<PictureChannel> channels_of(const ChannelRow& row);
std::vector<PictureChannel> film_channels(const AovSet& aovs);
std::vector<std::string> film_channel_names(const AovSet& aovs);

}  // namespace emberline
