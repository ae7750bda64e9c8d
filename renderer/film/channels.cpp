// The table of channels, and their names.
#include "renderer/film/channels.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <type_traits>

#include "renderer/core/names.h"
#include "renderer/core/option_values.h"
#include "renderer/core/setting_names.h"
#include "renderer/film/film.h"
#include "renderer/film/finite_float.h"
#include "renderer/film/half_channels.h"
#include "renderer/film/shadow_sums.h"

namespace emberline {
namespace {

constexpr std::string_view kRgba[] = {"R", "G", "B", "A"};
constexpr std::span<const std::string_view> kRgb(kRgba, 3);
constexpr std::string_view kXyz[] = {"X", "Y", "Z"};
constexpr std::span<const std::string_view> kXy(kXyz, 2);
constexpr std::string_view kUv[] = {"U", "V"};
constexpr std::string_view kRayKinds[] = {"camera", "scatter", "shadow"};

using Kind = ChannelKind;
using Feed = ChannelFeed;
using Use = ChannelUse;
using Components = std::span<const std::string_view>;

// Adds a member of FirstHit, which is a number or a vector, to the sums.
template <auto kMember>
void add_first_hit(const FilmSample& sample, double* sums) {
  const auto& value = sample.value.first_hit.*kMember;
  if constexpr (std::is_same_v<decltype(value), const float&>) {
    *sums += double(value);
  } else {
    for (int c = 0; c < int(sizeof(value) / sizeof(float)); ++c) sums[c] += double(value[c]);
  }
}

template <auto kMember>
constexpr ChannelRow of_first_hit(std::string_view name, Components components, Kind kind, Use use,
                                  SumGroup group, std::string_view unit, std::string_view summary,
                                  float background = 0.0f,
                                  ErrorScale error = ErrorScale::kAbsolute) {
  return {.name = name,
          .components = components,
          .kind = kind,
          .feed = Feed::kFirstHit,
          .use = use,
          .unit = unit,
          .summary = summary,
          .error = error,
          .group = group,
          .add = add_first_hit<kMember>,
          .background = background};
}

// A row with one value per pixel, computed from the film.
template <float (*kValue)(const FilmTile&, size_t i)>
constexpr ChannelRow one_value(std::string_view name, Kind kind, Feed feed, Use use,
                               std::string_view summary, std::string_view unit = {},
                               std::string_view setting = "aov") {
  return {.name = name,
          .kind = kind,
          .feed = feed,
          .use = use,
          .unit = unit,
          .setting = setting,
          .summary = summary,
          .put = [](const FilmTile& film, size_t i, float* v) { *v = kValue(film, i); }};
}

template <PathLayer kLayer>
constexpr ChannelRow path_layer(std::string_view name, std::string_view summary) {
  return {.name = name,
          .components = kRgb,
          .kind = Kind::kMean,
          .feed = Feed::kPaths,
          .use = Use::kColour,
          .summary = summary,
          .error = ErrorScale::kDisplay,
          .put = [](const FilmTile& film, size_t i, float* v) { film.put_layer(i, kLayer, v); }};
}

void put_velocity(const FilmTile& film, size_t i, float* v) {
  const VelocitySums& sums = *film.block<VelocitySums>(Sums::kVelocity, i);
  const double scale = sums.count > 0 ? 1.0 / sums.count : 0.0;
  v[0] = to_finite_float(sums.x * scale);
  v[1] = to_finite_float(sums.y * scale);
}
void put_variance(const FilmTile& film, size_t i, float* v) {
  for (size_t c = 0; c < 3; ++c) v[c] = to_finite_float(film.variance_of_mean(i, c));
}
void add_clamped(const FilmSample& sample, double* sums) {
  const Rgb clamped = sample.value.clamped * sample.filter_weight;
  for (int c = 0; c < 3; ++c) sums[c] += double(clamped[c]);
}
void count_rays(const FilmSample& sample, uint32_t* numbers) {
  numbers[0] += 1;
  numbers[1] += sample.value.rays.scatter;
  numbers[2] += sample.value.rays.shadow;
}
// Sums in double are accurate enough for the variance: their rounding errors are below the
// precision of the depth, which is a float.
void add_depth_and_square(const FilmSample& sample, double* sums) {
  const auto depth = double(sample.value.first_hit.depth);
  sums[0] += depth;
  sums[1] += depth * depth;
}

constexpr ChannelRow kRows[] = {
    {.name = "RGBA",
     .components = kRgba,
     .kind = Kind::kMean,
     .feed = Feed::kRadiance,
     .use = Use::kColour,
     .setting = "",
     .summary = "the picture",
     .denoised = true,
     .error = ErrorScale::kDisplay,
     .put = [](const FilmTile& film, size_t i, float* v) { film.put_rgba(i, v); }},
    one_value<[](const FilmTile& film, size_t i) { return float(film.sums(i).samples()); }>(
        "samples", Kind::kCount, Feed::kRadiance, Use::kWhole,
        "number of samples taken in the pixel", "", ""),
    {.name = "variance",
     .components = kRgb,
     .kind = Kind::kDerived,
     .feed = Feed::kRadiance,
     .use = Use::kNumber,
     .unit = "radiance^2",
     .summary =
         "variance of the pixel's mean. The adaptive driver estimates it from the last doubling of "
         "the samples; two-stream and `streams` 2 estimate it from the two streams; otherwise it "
         "is estimated as if the samples were independent, which gives too high a value for "
         "stratified samples",
     .put = put_variance},
    // The albedo is a mean over all samples, as denoisers expect: a half-covered pixel has half the
    // albedo.
    of_first_hit<&FirstHit::albedo>("albedo", kRgb, Kind::kMean, Use::kColour, SumGroup::kSurface,
                                    "", "directional albedo of the first surface"),
    of_first_hit<&FirstHit::normal>("N", kXyz, Kind::kMean, Use::kNumber, SumGroup::kSurface, "",
                                    "shading normal of the first surface, world axes"),
    of_first_hit<&FirstHit::depth>(
        "Z", {}, Kind::kMeanOfHits, Use::kNumber, SumGroup::kSurface, "m",
        "depth of the first surface along the viewing axis; 1e10 where nothing is hit",
        kBackgroundDepth, ErrorScale::kRelative),
    of_first_hit<&FirstHit::position>(
        "P", kXyz, Kind::kMeanOfHits, Use::kNumber, SumGroup::kPositionUv, "m",
        "position of the first surface in the world; 0 where nothing is hit"),
    of_first_hit<&FirstHit::uv>(
        "UV", kUv, Kind::kMeanOfHits, Use::kNumber, SumGroup::kPositionUv, "",
        "texture coordinates of the first surface (TEXCOORD_0), U to the right, V upwards"),
    {.name = "velocity",
     .components = kXy,
     .kind = Kind::kDerived,
     .feed = Feed::kFirstHit,
     .use = Use::kNumber,
     .unit = "pixels per frame",
     .summary = "motion of the first surface, in pixels per frame of `fps`: X to the right, Y up; "
                "the mean over the shutter, or over the next frame if there is no shutter",
     .put = put_velocity},
    {.name = "clamped",
     .components = kRgb,
     .kind = Kind::kMean,
     .feed = Feed::kClamping,
     .use = Use::kColour,
     .summary = "light that `clamp-indirect` removed; adding it to R G B undoes the clamping",
     .group = SumGroup::kClamped,
     .add = add_clamped},
    path_layer<PathLayer::kDirect>(
        "direct",
        "light that the first surface reflects diffusely and that comes directly from a light; "
        "the six layers by light path add up to R G B"),
    path_layer<PathLayer::kIndirect>(
        "indirect",
        "light that the first surface reflects diffusely and that comes from other surfaces"),
    path_layer<PathLayer::kEmission>("emission",
                                     "light-emitting surfaces that the camera sees directly"),
    path_layer<PathLayer::kTransmission>("transmission",
                                         "light that comes through the first surface"),
    path_layer<PathLayer::kReflection>("reflection",
                                       "reflections and highlights on the first surface"),
    path_layer<PathLayer::kEnvironment>("environment",
                                        "the environment that the camera sees directly"),
    {.name = "shadow",
     .components = kRgb,
     .kind = Kind::kRatio,
     .feed = Feed::kCatchers,
     .use = Use::kColour,
     .summary =
         "factor by which a plate is multiplied: the light that the catcher receives, divided by "
         "the light that it would receive without the other objects; 1 outside the catcher. "
         "`catcher` and `catcher-plane` add this channel automatically",
     .error = ErrorScale::kAbsolute,
     .group = SumGroup::kShadow,
     .add = add_shadow,
     .sums = kShadowSums,
     .put = [](const FilmTile& film, size_t i,
               float* v) { put_shadow(film.block<double>(Sums::kShadow, i), v); }},
    {.name = "denoising",
     .kind = Kind::kDerived,
     .feed = Feed::kFeatures,
     .use = Use::kExact,
     .summary = "channels that `emberline denoise` reads: both halves of the samples, with their "
                "features; uses two sample streams",
     .put = put_halves,
     .channels = half_channels},
    one_value<[](const FilmTile& film, size_t i) { return float(film.sums(i).id); }>(
        "id", Kind::kFirstHit, Feed::kHitId, Use::kWhole, "instance at the pixel's first hit"),
    one_value<[](const FilmTile& film, size_t i) {
      return to_finite_float(*film.block<float>(Sums::kSeconds, i));
    }>("time", Kind::kCount, Feed::kClock, Use::kExact, "seconds spent on the pixel", "s"),
    one_value<[](const FilmTile& film, size_t i) {
      return float(*film.block<uint8_t>(Sums::kStop, i));
    }>("stop", Kind::kAssigned, Feed::kDriver, Use::kWhole,
       "why the pixel got no more samples: 0 it has no samples, 1 `spp`, 2 "
       "`noise-threshold`, 3 "
       "`max-spp`, 4 `time-limit`, 5 the user, 6 unfinished when a window saved it, 7 "
       "`time-budget`. With `judge`, "
       "plus 8 times the "
       "index in that list, from 0, of the channel that needed the pixel's last samples"),
    one_value<[](const FilmTile& film, size_t i) { return float(film.sums(i).non_finite); }>(
        "non_finite", Kind::kCount, Feed::kRadiance, Use::kWhole,
        "samples that were NaN or infinite, counted as black"),
    one_value<[](const FilmTile& film, size_t) { return float(film.part()); }>(
        "part", Kind::kAssigned, Feed::kMerge, Use::kWhole,
        "which part of a merged frame the pixel comes from; 1 is the part that was named first"),
    {.name = "rays",
     .components = kRayKinds,
     .kind = Kind::kCount,
     .feed = Feed::kRays,
     .use = Use::kWhole,
     .summary = "rays traced for the pixel: camera rays, rays that continue paths, and shadow rays",
     .count = count_rays},
    of_first_hit<&FirstHit::specular_velocity>("specular_velocity", kXy, Kind::kMeanOfHits,
                                               Use::kNumber, SumGroup::kNone, "pixels per frame",
                                               "motion of what flat mirrors and thin glass show, "
                                               "minus velocity, which it adds; 0 elsewhere"),
    of_first_hit<&FirstHit::geometric_normal>(
        "Ng", kXyz, Kind::kMean, Use::kNumber, SumGroup::kNone, "",
        "geometric normal of the first surface, world axes, on the camera's side"),
    of_first_hit<&FirstHit::roughness>(
        "roughness", {}, Kind::kMeanOfHits, Use::kNumber, SumGroup::kNone, "",
        "roughness of the first surface as in glTF: 0 is a mirror, 1 is rough"),
    of_first_hit<&FirstHit::metallic>("metallic", {}, Kind::kMeanOfHits, Use::kNumber,
                                      SumGroup::kNone, "",
                                      "metalness of the first surface, 0 to 1"),
    {.name = "material",
     .kind = Kind::kFirstHit,
     .feed = Feed::kFirstHit,
     .use = Use::kWhole,
     .summary = "index + 1 of the material at the pixel's first hit",
     .count = [](const FilmSample& s, uint32_t* number) { *number = s.value.first_hit.material; }},
    {.name = "depth_variance",
     .kind = Kind::kVarianceOfHits,
     .feed = Feed::kFirstHit,
     .use = Use::kNumber,
     .unit = "m^2",
     .summary = "variance of Z among the pixel's samples; it is high at edges",
     .add = add_depth_and_square,
     .sums = 2},
    {.name = "ao",
     .kind = Kind::kMeanOfHits,
     .feed = Feed::kPaths,
     .use = Use::kNumber,
     .summary =
         "ambient occlusion: the unoccluded part of the hemisphere above the first surface, within "
         "a fifth of the scene's radius; 1 where nothing is hit",
     .error = ErrorScale::kAbsolute,
     .add = add_first_hit<&FirstHit::ambient_visibility>,
     .background = 1.0f},
    // These rows are not in film_channels(); in a picture, their channels follow those of the film.
    // The channels of the first two rows depend on the scene's light groups and on `cryptomatte`.
    {.name = "light",
     .components = kRgb,
     .kind = Kind::kMean,
     .feed = Feed::kLights,
     .use = Use::kColour,
     .setting = "light-groups",
     .summary = "contribution of each light, as light.NAME",
     .denoised = true,
     .error = ErrorScale::kDisplay},
    {.name = "Crypto",
     .components = kRgba,
     .kind = Kind::kIds,
     .feed = Feed::kHitId,
     .use = Use::kExact,
     .setting = "cryptomatte",
     .summary = "pairs of ids and coverage in layers such as CryptoObject00"},
    {.name = "denoised",
     .components = kRgb,
     .kind = Kind::kDerived,
     .feed = Feed::kFeatures,
     .use = Use::kColour,
     .setting = "denoise",
     .summary = "the denoised picture of `denoise`, and its estimated error"},
};

constexpr bool is_named(Aov aov, std::string_view name) { return kRows[size_t(aov)].name == name; }
static_assert(is_named(Aov::kVariance, "variance") && is_named(Aov::kVelocity, "velocity") &&
              is_named(Aov::kDirect, "direct") && is_named(Aov::kEnvironment, "environment") &&
              is_named(Aov::kShadow, "shadow") && is_named(Aov::kPart, "part") &&
              is_named(Aov::kRays, "rays") &&
              is_named(Aov::kSpecularVelocity, "specular_velocity"));
static_assert(std::size(kRows) <= AovSet::kMaxAovs);

// Returns a name such as "albedo.R", but plain "R" for the picture.
std::string name_of_component(const ChannelRow& row, std::string_view component) {
  if (&row == &kRows[size_t(Aov::kPicture)]) return std::string(component);
  return fmt::format("{}.{}", row.name, component);
}

}  // namespace

std::string_view name_of(ChannelKind kind) {
  constexpr std::string_view kNames[] = {"mean",      "mean of hits", "variance of hits",
                                         "first hit", "count",        "assigned",
                                         "ratio",     "derived",      "ids"};
  return kNames[size_t(kind)];
}

std::span<const ChannelRow> channel_table() { return kRows; }

const ChannelRow& row_of(Aov aov) { return kRows[size_t(aov)]; }

std::span<const NamedValue<Aov>> aov_table() {
  static const std::vector<NamedValue<Aov>> table = [] {
    std::vector<NamedValue<Aov>> aovs;
    for (size_t i = 0; i < std::size(kRows); ++i) {
      if (kRows[i].setting == "aov") aovs.push_back({kRows[i].name, kRows[i].summary, Aov(i)});
    }
    return aovs;
  }();
  return table;
}

std::string pixel_stop_name(PixelStop stop) {
  constexpr std::string_view kNames[] = {"nothing",    "`spp`",        "`noise-threshold`",
                                         "`max-spp`",  "`time-limit`", "the user",
                                         "unfinished", "`time-budget`"};
  return spell_setting_names(kNames[static_cast<size_t>(stop)]);
}

bool AovSet::needs(ChannelFeed feed) const {
  return std::ranges::any_of(rows_of(*this), [&](const auto* row) { return row->feed == feed; });
}

bool AovSet::needs(SumGroup group) const {
  return std::ranges::any_of(rows_of(*this), [&](const auto* row) { return row->group == group; });
}

std::span<const AovAlias> aov_aliases() {
  // Blender, Arnold and Nuke use these names for their passes.
  static constexpr AovAlias kAliases[] = {
      {"lightpath", "direct,indirect,emission,transmission,reflection,environment"},
      {"normal", "N"},
      {"depth", "Z"},
      {"position", "P"},
      {"uv", "UV"},
      {"motion", "velocity"},
      {"diffuse", "direct,indirect"},
      {"specular", "reflection"}};
  return kAliases;
}

std::string canonical_aovs(std::string_view list) {
  std::vector<std::string_view> valid;
  for (const auto& entry : aov_table()) valid.push_back(entry.name);
  for (const AovAlias& alias : aov_aliases()) valid.push_back(alias.name);
  std::vector<std::string_view> names;
  for (const std::string_view name : split_list(list)) {
    if (std::ranges::find(valid, name) == valid.end()) {
      throw_unknown_name("`aov`", "channel", name, valid);
    }
    const auto alias = std::ranges::find(aov_aliases(), name, &AovAlias::name);
    if (alias == aov_aliases().end()) {
      names.push_back(name);
    } else {
      std::ranges::copy(split_list(alias->list), std::back_inserter(names));
    }
  }
  return fmt::format("{}", fmt::join(names, ","));
}

AovSet AovSet::parse(std::string_view list) {
  AovSet set;
  const std::string names = canonical_aovs(list);
  for (const std::string_view name : split_list(names)) {
    set.insert(find_named(aov_table(), "`aov`", "channel", name).value);
  }
  if (set.contains(Aov::kSpecularVelocity)) set.insert(Aov::kVelocity);
  return set;
}

std::vector<PictureChannel> channels_of(const ChannelRow& row) {
  if (row.channels) return row.channels();
  const ChannelType type = row.use == Use::kWhole ? ChannelType::kUint : ChannelType::kFloat;
  if (row.components.empty()) return {{std::string(row.name), type}};
  std::vector<PictureChannel> channels;
  for (const std::string_view component : row.components) {
    channels.push_back({name_of_component(row, component), type});
  }
  return channels;
}

std::vector<const ChannelRow*> rows_of(const AovSet& aovs) {
  std::vector<const ChannelRow*> rows;
  for (size_t i = 0; i < std::size(kRows); ++i) {
    if (kRows[i].setting.empty() || aovs.contains(Aov(i))) rows.push_back(&kRows[i]);
  }
  return rows;
}

std::vector<PictureChannel> film_channels(const AovSet& aovs) {
  std::vector<PictureChannel> channels;
  for (const ChannelRow* row : rows_of(aovs)) {
    for (PictureChannel& channel : channels_of(*row)) channels.push_back(std::move(channel));
  }
  return channels;
}

std::vector<std::string> film_channel_names(const AovSet& aovs) {
  return names_of(film_channels(aovs));
}

}  // namespace emberline
