// The channels of a film, by name.
#include "renderer/core/names.h"
#include "renderer/core/option_values.h"
#include "renderer/core/setting_names.h"
#include "renderer/film/film.h"
#include "renderer/film/half_channels.h"

namespace emberline {
namespace {

constexpr NamedValue<Aov> kAovs[] = {
    {"variance",
     "variance of the pixel's mean: of adaptive frames what their last doubling has shown, from "
     "the two streams with two-stream or `streams` 2; else as if samples were independent, an "
     "upper estimate for stratified ones",
     Aov::kVariance},
    {"albedo", "directional albedo of the first surface", Aov::kAlbedo},
    {"N", "shading normal of the first surface, world axes", Aov::kNormal},
    {"Z", "depth of the first surface along the viewing axis", Aov::kDepth},
    {"P", "position of the first surface in the world, metres; 0 where nothing is hit",
     Aov::kPosition},
    {"UV", "texture coordinates of the first surface (TEXCOORD_0), U to the right, V upwards",
     Aov::kUv},
    {"velocity",
     "where the first surface goes, in pixels a frame of `fps`: X to the right, Y up; the mean "
     "over "
     "the shutter, or without one over the frame that follows",
     Aov::kVelocity},
    {"clamped", "what `clamp-indirect` took: added to R G B it is the picture without",
     Aov::kClamped},
    {"direct",
     "layers by light path, which add up to R G B: diffuse reflection by the first surface of "
     "light "
     "that comes straight to it",
     Aov::kDirect},
    {"indirect", "the same of light that other surfaces send to it", Aov::kIndirect},
    {"emission", "surfaces that shine, seen by the camera itself", Aov::kEmission},
    {"transmission", "what comes through the first surface", Aov::kTransmission},
    {"reflection", "mirror images and highlights on the first surface", Aov::kReflection},
    {"environment", "the environment, seen by the camera itself", Aov::kEnvironment},
    {"shadow",
     "what a plate is to be multiplied by: the light that `catcher` receives from the lights over "
     "that which it would without the other objects; 1 beside it. Comes with `catcher`",
     Aov::kShadow},
    {"denoising",
     "what `emberline denoise` reads: the two halves of the samples apart, and what they saw; "
     "there are two streams then",
     Aov::kDenoising},
    {"id", "instance seen by the pixel's first sample that hits one", Aov::kId},
    {"time", "seconds spent on the pixel", Aov::kTime},
    {"stop",
     "why the pixel got no more samples: 1 `spp`, 2 `noise-threshold`, 3 `max-spp`, 4 "
     "`time-limit`, 5 the user, 6 it was to get more when a window saved it; 0 if it got none",
     Aov::kStop},
    {"non_finite", "samples that were NaN or infinite, counted as black", Aov::kNonFinite},
    {"part", "of a merged frame: the number of the part that brought the pixel, 1 the first given",
     Aov::kPart},
};

}  // namespace

std::span<const NamedValue<Aov>> aov_table() { return kAovs; }

std::string pixel_stop_name(PixelStop stop) {
  constexpr std::string_view kNames[] = {
      "nothing", "`spp`", "`noise-threshold`", "`max-spp`", "`time-limit`", "the user", "going on"};
  return spelled(kNames[static_cast<size_t>(stop)]);
}

AovSet AovSet::parse(std::string_view list) {
  AovSet set;
  for (const std::string_view name : split_list(list)) {
    set.insert(find_named(kAovs, "`aov`", "channel", name).value);
  }
  return set;
}

std::vector<FilmChannel> film_channels(const AovSet& aovs) {
  std::vector<FilmChannel> channels = {{"R"}, {"G"}, {"B"}, {"A"}, {"samples", true}};
  const auto add = [&](std::initializer_list<const char*> names, bool integer = false) {
    for (const char* name : names) channels.push_back({name, integer});
  };
  if (aovs.contains(Aov::kVariance)) add({"variance.R", "variance.G", "variance.B"});
  if (aovs.contains(Aov::kAlbedo)) add({"albedo.R", "albedo.G", "albedo.B"});
  if (aovs.contains(Aov::kNormal)) add({"N.X", "N.Y", "N.Z"});
  if (aovs.contains(Aov::kDepth)) add({"Z"});
  if (aovs.contains(Aov::kPosition)) add({"P.X", "P.Y", "P.Z"});
  if (aovs.contains(Aov::kUv)) add({"UV.U", "UV.V"});
  if (aovs.contains(Aov::kVelocity)) add({"velocity.X", "velocity.Y"});
  if (aovs.contains(Aov::kClamped)) add({"clamped.R", "clamped.G", "clamped.B"});
  const PathLayers layers(aovs);
  for (const PathLayer layer : layers.list()) {
    for (const char* channel : {".R", ".G", ".B"}) {
      channels.push_back({std::string(name_of(aov_table(), aov_of(layer))) + channel});
    }
  }
  if (aovs.contains(Aov::kShadow)) add({"shadow.R", "shadow.G", "shadow.B"});
  if (aovs.contains(Aov::kDenoising)) {
    const std::vector<FilmChannel> halves = half_channels();
    channels.insert(channels.end(), halves.begin(), halves.end());
  }
  if (aovs.contains(Aov::kId)) add({"id"}, true);
  if (aovs.contains(Aov::kTime)) add({"time"});
  if (aovs.contains(Aov::kStop)) add({"stop"}, true);
  if (aovs.contains(Aov::kNonFinite)) add({"non_finite"}, true);
  if (aovs.contains(Aov::kPart)) add({"part"}, true);
  return channels;
}

std::vector<std::string> film_channel_names(const AovSet& aovs) {
  std::vector<std::string> names;
  for (const FilmChannel& channel : film_channels(aovs)) names.push_back(channel.name);
  return names;
}

}  // namespace emberline
