// The table of a picture's channels. All code that handles channels loops over this table.
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

// Index of a row in channel_table(). Only rows that code refers to by name have an enumerator.
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
  kDirect,  // the light-path layers, in the order of PathLayer
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
  kSpecularVelocity,
};

// How a pixel's value follows from the pixel's samples.
enum class ChannelKind : uint8_t {
  kMean,        // mean over all samples
  kMeanOfHits,  // mean over the samples that hit a surface; `background` if none did
  kVarianceOfHits,
  kFirstHit,  // value of the first sample that hits a surface
  kCount,     // sum over all samples
  kAssigned,  // set from outside, not by samples
  kRatio,     // ratio of two sums
  kDerived,   // computed from other sums
  kIds,       // ids and their coverage of the pixel
};

// Source of a channel's values.
enum class ChannelFeed : uint8_t {
  kRadiance,
  kFirstHit,  // SampleValue::first_hit
  kHitId,     // first_hit.id only
  kRays,      // SampleValue::rays
  kClamping,
  kLights,
  kPaths,  // recorded by the path loop
  kCatchers,
  kFeatures,  // DenoiserFeatures and SampleShares
  kClock,
  kDriver,
  kMerge,
};

// The precision that a file must keep.
enum class ChannelUse : uint8_t {
  kColour,  // half floats and lossy compression allowed
  kNumber,  // half floats allowed
  kExact,   // neither allowed
  kWhole,   // 32-bit integers
};

// How adaptive sampling measures the error of a channel (`judge`).
enum class ErrorScale : uint8_t {
  kNone,      // not measured
  kDisplay,   // as displayed: sRGB, 0 to 1
  kAbsolute,  // in the channel's unit
  kRelative,  // as a fraction of the value
};

// Groups of adjacent rows that share a block of sums (film_layout.h). A film with one of the rows
// keeps the sums of all rows in the group. A row with kNone has its own block.
enum class SumGroup : uint8_t { kNone, kSurface, kPositionUv, kClamped, kShadow };

std::string_view name_of(ChannelKind kind);  // "mean of hits"
// Whether a file may store the channel as half floats.
inline bool may_be_half(ChannelUse use) {
  return use == ChannelUse::kColour || use == ChannelUse::kNumber;
}

struct ChannelRow {
  std::string_view name;  // name of the EXR layer and of the setting's value
  std::span<const std::string_view> components = {};  // empty: one value, named like the layer
  ChannelKind kind;
  ChannelFeed feed;
  ChannelUse use;
  std::string_view unit = {};        // empty: no unit, or the unit of radiance
  std::string_view setting = "aov";  // the setting that requests the row; empty: always present
  std::string_view summary;
  bool denoised = false;  // `denoise` also writes a denoised version
  ErrorScale error = ErrorScale::kNone;
  SumGroup group = SumGroup::kNone;
  // Adds a finite sample to the row's sums: one sum per component unless `sums` says otherwise.
  // Rows of kMeanOfHits and kVarianceOfHits get only the samples that hit a surface.
  void (*add)(const FilmSample& sample, double* sums) = nullptr;
  uint32_t sums = 0;
  float background = 0.0f;  // value if no sample hit a surface
  // For kCount, adds a sample to the row's counters, one per component. For kFirstHit, writes a
  // number such as an id; once it is not 0, the film does not call `count` for the pixel again.
  void (*count)(const FilmSample& sample, uint32_t* numbers) = nullptr;
  // Writes the values of pixel i. If null, the film computes the values from the sums according to
  // `kind`.
  void (*put)(const FilmTile& film, size_t i, float* values) = nullptr;
  // Returns the row's channels. Set only if `components` cannot express them.
  std::vector<PictureChannel> (*channels)() = nullptr;

  size_t size() const { return components.empty() ? 1 : components.size(); }
  size_t sum_count() const { return sums > 0 ? sums : add ? size() : 0; }
  bool is_of_hits() const {
    return kind == ChannelKind::kMeanOfHits || kind == ChannelKind::kVarianceOfHits;
  }
};

// Returns the rows of all channels, in the order in which a picture has them.
std::span<const ChannelRow> channel_table();
const ChannelRow& row_of(Aov aov);
// The rows that the setting `aov` accepts.
std::span<const NamedValue<Aov>> aov_table();

// Other names that the setting `aov` accepts: names for groups of rows, and names that other
// programs use.
struct AovAlias {
  std::string_view name;
  std::string_view list;  // the names in aov_table() that the alias stands for
};
std::span<const AovAlias> aov_aliases();
// Replaces the aliases in `list` by names in aov_table(). Throws a UsageError that suggests valid
// names.
std::string canonical_aovs(std::string_view list);

// The rows that a film has in addition to the rows that are always present.
class AovSet {
 public:
  static constexpr size_t kMaxAovs = 64;
  void insert(Aov aov) { bits_ |= bit(aov); }
  bool contains(Aov aov) const { return (bits_ & bit(aov)) != 0; }
  bool operator==(const AovSet&) const = default;
  // Whether any row of the film, including those always present, has this feed or keeps sums in
  // this group.
  bool needs(ChannelFeed feed) const;
  bool needs(SumGroup group) const;
  // Parses a list such as "variance,N", which may contain aliases. Throws UsageError with the valid
  // names.
  static AovSet parse(std::string_view list);

 private:
  static constexpr uint64_t bit(Aov aov) { return uint64_t(1) << uint32_t(aov); }
  uint64_t bits_ = 0;
};

// rows_of() returns the rows of a film in table order; channels_of() returns the channels of one
// row; film_channels() returns the channels of all rows of a film.
std::vector<const ChannelRow*> rows_of(const AovSet& aovs);
std::vector<PictureChannel> channels_of(const ChannelRow& row);
std::vector<PictureChannel> film_channels(const AovSet& aovs);
std::vector<std::string> film_channel_names(const AovSet& aovs);

}  // namespace emberline
