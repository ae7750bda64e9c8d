// The table of channels, and their names.
#include "renderer/film/channels.h"

#include <fmt/format.h>

#include <algorithm>

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

template <class Vector>
void add3(const Vector& value, double* sums) {
  for (int c = 0; c < 3; ++c) sums[c] += double(value[c]);
}

void put_layer(const FilmTile& film, size_t i, const ChannelRow& row, float* values) {
  film.put_layer(i, PathLayer(&row - &row_of(Aov::kDirect)), values);
}

constexpr ChannelRow path_layer(std::string_view name, std::string_view summary) {
  return {.name = name,
          .components = kRgb,
          .kind = Kind::kMean,
          .feed = Feed::kPaths,
          .use = Use::kColour,
          .summary = summary,
          .put = put_layer};
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
     .put = [](const FilmTile& film, size_t i, const ChannelRow&,
               float* v) { film.put_rgba(i, v); }},
    {.name = "samples",
     .kind = Kind::kCount,
     .feed = Feed::kRadiance,
     .use = Use::kWhole,
     .setting = "",
     .summary = "samples taken of the pixel",
     .put = [](const FilmTile& film, size_t i, const ChannelRow&,
               float* v) { *v = float(film.sums(i).samples()); }},
    {.name = "variance",
     .components = kRgb,
     .kind = Kind::kDerived,
     .feed = Feed::kRadiance,
     .use = Use::kNumber,
     .unit = "radiance^2",
     .summary =
         "variance of the pixel's mean: of adaptive frames what their last doubling has shown, "
         "from the two streams with two-stream or `streams` 2; else as if samples were "
         "independent, an upper estimate for stratified ones",
     .put =
         [](const FilmTile& film, size_t i, const ChannelRow&, float* v) {
           for (size_t c = 0; c < 3; ++c) v[c] = to_finite_float(film.variance_of_mean(i, c));
         }},
    // Over all samples: a pixel half covered shows half the albedo, as a denoiser wants.
    {.name = "albedo",
     .components = kRgb,
     .kind = Kind::kMean,
     .feed = Feed::kFirstHit,
     .use = Use::kColour,
     .summary = "directional albedo of the first surface",
     .group = SumGroup::kSurface,
     .add = [](const FilmSample& s, double* sums) { add3(s.value.first_hit.albedo, sums); }},
    {.name = "N",
     .components = kXyz,
     .kind = Kind::kMean,
     .feed = Feed::kFirstHit,
     .use = Use::kNumber,
     .summary = "shading normal of the first surface, world axes",
     .group = SumGroup::kSurface,
     .add = [](const FilmSample& s, double* sums) { add3(s.value.first_hit.normal, sums); }},
    {.name = "Z",
     .kind = Kind::kMeanOfHits,
     .feed = Feed::kFirstHit,
     .use = Use::kNumber,
     .unit = "m",
     .summary = "depth of the first surface along the viewing axis; 1e10 where nothing is hit",
     .group = SumGroup::kSurface,
     .add = [](const FilmSample& s, double* sums) { *sums += double(s.value.first_hit.depth); },
     .background = kBackgroundDepth},
    {.name = "P",
     .components = kXyz,
     .kind = Kind::kMeanOfHits,
     .feed = Feed::kFirstHit,
     .use = Use::kNumber,
     .unit = "m",
     .summary = "position of the first surface in the world; 0 where nothing is hit",
     .group = SumGroup::kPlace,
     .add = [](const FilmSample& s, double* sums) { add3(s.value.first_hit.position, sums); }},
    {.name = "UV",
     .components = kUv,
     .kind = Kind::kMeanOfHits,
     .feed = Feed::kFirstHit,
     .use = Use::kNumber,
     .summary = "texture coordinates of the first surface (TEXCOORD_0), U to the right, V upwards",
     .group = SumGroup::kPlace,
     .add =
         [](const FilmSample& s, double* sums) {
           sums[0] += double(s.value.first_hit.uv.x);
           sums[1] += double(s.value.first_hit.uv.y);
         }},
    {.name = "velocity",
     .components = kXy,
     .kind = Kind::kDerived,
     .feed = Feed::kFirstHit,
     .use = Use::kNumber,
     .unit = "pixels a frame",
     .summary = "where the first surface goes, in pixels a frame of `fps`: X to the right, Y up; "
                "the mean over the shutter, or without one over the frame that follows",
     .put =
         [](const FilmTile& film, size_t i, const ChannelRow&, float* v) {
           const VelocitySums& sums = *film.block<VelocitySums>(Sums::kVelocity, i);
           const double scale = sums.count > 0 ? 1.0 / sums.count : 0.0;
           v[0] = to_finite_float(sums.x * scale);
           v[1] = to_finite_float(sums.y * scale);
         }},
    {.name = "clamped",
     .components = kRgb,
     .kind = Kind::kMean,
     .feed = Feed::kClamping,
     .use = Use::kColour,
     .summary = "what `clamp-indirect` took: added to R G B it is the picture without",
     .group = SumGroup::kClamped,
     .add = [](const FilmSample& s,
               double* sums) { add3(s.value.clamped * s.filter_weight, sums); }},
    path_layer("direct",
               "layers by light path, which add up to R G B: diffuse reflection by the first "
               "surface of light that comes straight to it"),
    path_layer("indirect", "the same of light that other surfaces send to it"),
    path_layer("emission", "surfaces that shine, seen by the camera itself"),
    path_layer("transmission", "what comes through the first surface"),
    path_layer("reflection", "mirror images and highlights on the first surface"),
    path_layer("environment", "the environment, seen by the camera itself"),
    {.name = "shadow",
     .components = kRgb,
     .kind = Kind::kRatio,
     .feed = Feed::kCatchers,
     .use = Use::kColour,
     .summary =
         "what a plate is to be multiplied by: the light that `catcher` receives from the lights "
         "over that which it would without the other objects; 1 beside it. Comes with `catcher`",
     .group = SumGroup::kShadow,
     .add = add_shadow,
     .sums = kShadowSums,
     .put = [](const FilmTile& film, size_t i, const ChannelRow&,
               float* v) { put_shadow(film.block<double>(Sums::kShadow, i), v); }},
    {.name = "denoising",
     .kind = Kind::kDerived,
     .feed = Feed::kFeatures,
     .use = Use::kExact,
     .summary = "what `emberline denoise` reads: the two halves of the samples apart, and what "
                "they saw; there are two streams then",
     .put = [](const FilmTile& film, size_t i, const ChannelRow&,
               float* v) { put_halves(film, i, v); },
     .channels = half_channels},
    {.name = "id",
     .kind = Kind::kFirstHit,
     .feed = Feed::kHitId,
     .use = Use::kWhole,
     .summary = "instance seen by the pixel's first sample that hits one",
     .put = [](const FilmTile& film, size_t i, const ChannelRow&,
               float* v) { *v = float(film.sums(i).id); }},
    {.name = "time",
     .kind = Kind::kCount,
     .feed = Feed::kClock,
     .use = Use::kExact,
     .unit = "s",
     .summary = "seconds spent on the pixel",
     .put = [](const FilmTile& film, size_t i, const ChannelRow&,
               float* v) { *v = to_finite_float(*film.block<float>(Sums::kSeconds, i)); }},
    {.name = "stop",
     .kind = Kind::kAssigned,
     .feed = Feed::kDriver,
     .use = Use::kWhole,
     .summary =
         "why the pixel got no more samples: 1 `spp`, 2 `noise-threshold`, 3 `max-spp`, 4 "
         "`time-limit`, 5 the user, 6 it was to get more when a window saved it; 0 if it got none",
     .put = [](const FilmTile& film, size_t i, const ChannelRow&,
               float* v) { *v = float(*film.block<PixelStop>(Sums::kStop, i)); }},
    {.name = "non_finite",
     .kind = Kind::kCount,
     .feed = Feed::kRadiance,
     .use = Use::kWhole,
     .summary = "samples that were NaN or infinite, counted as black",
     .put = [](const FilmTile& film, size_t i, const ChannelRow&,
               float* v) { *v = float(film.sums(i).non_finite); }},
    {.name = "part",
     .kind = Kind::kAssigned,
     .feed = Feed::kMerge,
     .use = Use::kWhole,
     .summary =
         "of a merged frame: the number of the part that brought the pixel, 1 the first given",
     .put = [](const FilmTile& film, size_t, const ChannelRow&,
               float* v) { *v = float(film.part()); }},
    {.name = "rays",
     .components = kRayKinds,
     .kind = Kind::kCount,
     .feed = Feed::kRays,
     .use = Use::kWhole,
     .summary = "rays traced for the pixel: of the camera, of paths that go on, and to lights",
     .count =
         [](const FilmSample& s, uint32_t* numbers) {
           numbers[0] += 1;
           numbers[1] += s.value.rays.scatter;
           numbers[2] += s.value.rays.shadow;
         }},
    {.name = "Ng",
     .components = kXyz,
     .kind = Kind::kMean,
     .feed = Feed::kFirstHit,
     .use = Use::kNumber,
     .summary = "geometric normal of the first surface, world axes, on the camera's side",
     .add =
         [](const FilmSample& s, double* sums) {
           if (s.value.first_hit.hit) add3(s.value.first_hit.geometric_normal, sums);
         }},
    {.name = "roughness",
     .kind = Kind::kMeanOfHits,
     .feed = Feed::kFirstHit,
     .use = Use::kNumber,
     .summary = "roughness of the first surface, glTF's: 0 a mirror, 1 rough",
     .add = [](const FilmSample& s,
               double* sums) { *sums += double(s.value.first_hit.roughness); }},
    {.name = "metallic",
     .kind = Kind::kMeanOfHits,
     .feed = Feed::kFirstHit,
     .use = Use::kNumber,
     .summary = "how much of a metal the first surface is, 0 to 1",
     .add = [](const FilmSample& s, double* sums) { *sums += double(s.value.first_hit.metallic); }},
    {.name = "material",
     .kind = Kind::kFirstHit,
     .feed = Feed::kFirstHit,
     .use = Use::kWhole,
     .summary = "material seen by the pixel's first sample that hits a surface: its index + 1",
     .count = [](const FilmSample& s, uint32_t* number) { *number = s.value.first_hit.material; }},
    {.name = "depth_variance",
     .kind = Kind::kVarianceOfHits,
     .feed = Feed::kFirstHit,
     .use = Use::kNumber,
     .unit = "m^2",
     .summary = "variance of Z among the pixel's samples: high where surfaces meet",
     // What the sums round away is less than what a depth, a float, has already lost.
     .add =
         [](const FilmSample& s, double* sums) {
           const auto depth = double(s.value.first_hit.depth);
           sums[0] += depth;
           sums[1] += depth * depth;
         },
     .sums = 2},
    {.name = "ao",
     .kind = Kind::kMeanOfHits,
     .feed = Feed::kPaths,
     .use = Use::kNumber,
     .summary = "ambient occlusion: how open the hemisphere above the first surface is, within a "
                "fifth of the scene's radius; 1 where nothing is hit",
     .add = [](const FilmSample& s, double* sums) { *sums += double(s.value.first_hit.openness); },
     .background = 1.0f},
    // Named by the scene; their channels lie behind those of the film.
    {.name = "light",
     .components = kRgb,
     .kind = Kind::kMean,
     .feed = Feed::kLights,
     .use = Use::kColour,
     .setting = "light-groups",
     .summary = "what each light group gave, as light.NAME",
     .denoised = true},
    {.name = "Crypto",
     .components = kRgba,
     .kind = Kind::kIds,
     .feed = Feed::kHitId,
     .use = Use::kExact,
     .setting = "cryptomatte",
     .summary = "ranks of ids and coverage, as CryptoObject00"},
    {.name = "denoised",
     .components = kRgb,
     .kind = Kind::kDerived,
     .feed = Feed::kFeatures,
     .use = Use::kColour,
     .setting = "denoise",
     .summary = "the clean picture of `denoise`, and its error"},
};

constexpr bool is_named(Aov aov, std::string_view name) { return kRows[size_t(aov)].name == name; }
static_assert(is_named(Aov::kVariance, "variance") && is_named(Aov::kVelocity, "velocity") &&
              is_named(Aov::kDirect, "direct") && is_named(Aov::kEnvironment, "environment") &&
              is_named(Aov::kShadow, "shadow") && is_named(Aov::kPart, "part") &&
              is_named(Aov::kRays, "rays"));
static_assert(std::size(kRows) <= AovSet::kMost);

// "albedo.R", but "R" of the picture's own.
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
  constexpr std::string_view kNames[] = {
      "nothing", "`spp`", "`noise-threshold`", "`max-spp`", "`time-limit`", "the user", "going on"};
  return spelled(kNames[static_cast<size_t>(stop)]);
}

bool AovSet::needs(ChannelFeed feed) const {
  return std::ranges::any_of(rows_of(*this), [&](const auto* row) { return row->feed == feed; });
}

bool AovSet::needs(SumGroup group) const {
  return std::ranges::any_of(rows_of(*this), [&](const auto* row) { return row->group == group; });
}

AovSet AovSet::parse(std::string_view list) {
  AovSet set;
  for (const std::string_view name : split_list(list)) {
    set.insert(find_named(aov_table(), "`aov`", "channel", name).value);
  }
  return set;
}

std::vector<FilmChannel> channels_of(const ChannelRow& row) {
  if (row.channels) return row.channels();
  const bool integer = row.use == ChannelUse::kWhole;
  if (row.components.empty()) return {{std::string(row.name), integer}};
  std::vector<FilmChannel> channels;
  for (const std::string_view component : row.components) {
    channels.push_back({name_of_component(row, component), integer});
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

std::vector<FilmChannel> film_channels(const AovSet& aovs) {
  std::vector<FilmChannel> channels;
  for (const ChannelRow* row : rows_of(aovs)) {
    for (FilmChannel& channel : channels_of(*row)) channels.push_back(std::move(channel));
  }
  return channels;
}

std::vector<std::string> film_channel_names(const AovSet& aovs) {
  std::vector<std::string> names;
  for (const FilmChannel& channel : film_channels(aovs)) names.push_back(channel.name);
  return names;
}

}  // namespace emberline
