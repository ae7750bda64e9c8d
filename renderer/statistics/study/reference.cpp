#include "renderer/statistics/study/reference.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "io/files/atomic_file.h"
#include "io/files/fingerprint.h"
#include "io/files/input_file.h"
#include "io/image/input.h"
#include "io/json/input.h"
#include "io/json/reader.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/engine/run_limits.h"
#include "renderer/output/outputs.h"
#include "renderer/output/rgb_file.h"

namespace emberline {
namespace {

using Json = nlohmann::ordered_json;

// The channels are R, G, B, A, samples, variance.R, variance.G, variance.B and time.
constexpr size_t kChannels = 9, kVariance = 5, kTime = 8;

constexpr const char* kAttribute = "emberline:study_reference";

std::string base_name(const ReferenceRequest& request) {
  return "reference_" + hexadecimal(fingerprint(request.key));
}
std::string base_path(const ReferenceRequest& request) {
  return (std::filesystem::path(request.folder) / base_name(request)).string();
}

// Reads the checksum from the note, a JSON file next to the pixels. Throws InputError if the note
// is damaged or belongs to another frame.
std::string read_checksum(const ReferenceRequest& request) {
  const std::string file = base_path(request) + ".json";
  const nlohmann::json json = read_json(file);
  const JsonReader note(json, file);
  if (note["key"].text() != request.key) note["key"].throw_expected("the key of this frame");
  return note["checksum"].text();
}

// Whether the header of the picture file identifies it as one half of a reference.
bool has_attribute(const std::string& path) {
  constexpr size_t kHeader = 65536;
  const InputFile file(path);
  std::string text(std::min<uint64_t>(kHeader, file.size()), '\0');
  file.read(0, text.size(), text.data());
  return text.find(kAttribute) != std::string::npos;
}

std::optional<ReferenceHalf> read_channels(const std::string& path, const Rect& crop) {
  const FloatImage image =
      read_float_image(path, LoadProgress({}, {}, read_back_limits(crop.area())));
  if (image.width != crop.width() || image.height != crop.height()) return std::nullopt;
  const std::vector<PictureChannel> channels = film_channels(study_reference_aovs());
  ReferenceHalf half(size_t(crop.area()) * kChannels);
  for (size_t c = 0; c < kChannels; ++c) {
    const int source = image.find_channel(channels[c].name);
    if (source < 0) return std::nullopt;
    for (size_t i = 0; i < size_t(crop.area()); ++i) {
      half[i * kChannels + c] = image.values[i * size_t(image.channels()) + size_t(source)];
    }
  }
  return half;
}

}  // namespace

std::vector<std::string> reference_files(const ReferenceRequest& request) {
  return {base_name(request) + ".exr", base_name(request) + ".json"};
}

void check_cached_files(const ReferenceRequest& request) {
  const std::string picture = base_path(request) + ".exr", note = base_path(request) + ".json";
  const bool ours = [&] {
    try {
      return has_attribute(picture);
    } catch (const InputError&) {
      // The picture may be missing, so the next step looks for the note.
    }
    try {
      return !read_checksum(request).empty();
    } catch (const InputError&) {
      return false;
    }
  }();
  for (const std::string& file : {picture, note}) {
    std::error_code unknown;
    const std::filesystem::file_status status = std::filesystem::symlink_status(file, unknown);
    if (!std::filesystem::exists(status)) continue;
    if (ours && std::filesystem::is_regular_file(status)) continue;
    throw UsageError("`cache` " + file +
                     ": it is not a study's reference and would be overwritten; " +
                     "move it away or name another folder");
  }
}

AovSet study_reference_aovs() { return AovSet::parse("variance,time"); }

std::optional<ReferenceHalf> read_reference_half(const ReferenceRequest& request,
                                                 const Rect& crop) {
  const std::string path = base_path(request) + ".exr";
  if (!file_identity(path)) return std::nullopt;
  try {
    const std::string checksum = read_checksum(request);
    std::optional<ReferenceHalf> half = read_channels(path, crop);
    if (half && hexadecimal(fingerprint(*half)) == checksum) return half;
    log_info(path + ": it is damaged or belongs to another frame; it is rendered again");
  } catch (const InputError& error) {
    log_info(std::string(error.what()) + "; " + path + " is rendered again");
  }
  return std::nullopt;
}

std::optional<ReferenceHalf> render_reference_half(const StudyRenderer& renderer,
                                                   const ReferenceRequest& request,
                                                   const std::stop_token& stop) {
  std::optional<StudyPicture> picture =
      renderer.render(request.options, study_reference_aovs(), stop);
  if (!picture) return std::nullopt;
  // Writes the note last, because pixels without a note are not used.
  const std::string base = base_path(request);
  write_film_exr(base + ".exr", study_reference_aovs(), request.options.width,
                 request.options.height, renderer.crop(), {{kAttribute, request.key}},
                 picture->values);
  const Json note = {{"key", request.key}, {"checksum", hexadecimal(fingerprint(picture->values))}};
  write_file_atomically(base + ".json", note.dump(1) + "\n");
  return std::move(picture->values);
}

RgbImage reference_picture(const ReferenceHalf& half, const Rect& crop) {
  return to_rgb_image(half, kChannels, crop);
}

NeymanLimits reference_limits(const std::array<ReferenceHalf, 2>& halves, uint32_t samples,
                              const ReferencePicture& reference) {
  const size_t pixels = halves[0].size() / kChannels;
  std::vector<float> variance(3 * pixels), seconds(pixels);
  const auto n = float(samples);
  for (size_t i = 0; i < pixels; ++i) {
    const float *a = &halves[0][i * kChannels], *b = &halves[1][i * kChannels];
    for (size_t c = 0; c < 3; ++c) {
      variance[3 * i + c] = 0.5f * n * (a[kVariance + c] + b[kVariance + c]);
    }
    seconds[i] = std::min(a[kTime], b[kTime]) / n;
  }
  return neyman_limits(variance, seconds, reference.mean(), reference.epsilon());
}

}  // namespace emberline
