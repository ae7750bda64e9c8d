#include "renderer/app/study_reference.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "io/atomic_file.h"
#include "io/image_input.h"
#include "renderer/app/exr_file.h"
#include "renderer/app/fingerprint.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"

namespace emberline {
namespace {

using Json = nlohmann::ordered_json;

// R G B A samples variance.R variance.G variance.B time
constexpr size_t kChannels = 9, kVariance = 5, kTime = 8;

std::string base_name(const ReferenceRequest& request) {
  return (std::filesystem::path(request.folder) /
          ("reference_" + hexadecimal(fingerprint(request.key))))
      .string();
}

// What the note beside the pixels says, if it is there and of this frame.
std::optional<std::string> noted_checksum(const ReferenceRequest& request) {
  std::ifstream file(base_name(request) + ".json");
  if (!file) return std::nullopt;
  const Json note = Json::parse(file, nullptr, false);
  if (!note.is_object() || note.value("key", "") != request.key) return std::nullopt;
  return note.value("checksum", "");
}

std::optional<ReferenceHalf> read_channels(const std::string& path, const Rect& window) {
  const FloatImage image = read_float_image(path);
  if (image.width != window.width() || image.height != window.height()) return std::nullopt;
  const std::vector<FilmChannel> channels = film_channels(study_reference_aovs());
  ReferenceHalf half(size_t(window.area()) * kChannels);
  for (size_t c = 0; c < kChannels; ++c) {
    const int source = image.find_channel(channels[c].name);
    if (source < 0) return std::nullopt;
    for (size_t i = 0; i < size_t(window.area()); ++i) {
      half[i * kChannels + c] = image.values[i * size_t(image.channels()) + size_t(source)];
    }
  }
  return half;
}

}  // namespace

AovSet study_reference_aovs() { return AovSet::parse("variance,time"); }

std::optional<ReferenceHalf> read_reference_half(const ReferenceRequest& request,
                                                 const Rect& window) {
  const std::string path = base_name(request) + ".exr";
  if (!std::filesystem::exists(path)) return std::nullopt;
  try {
    const std::optional<std::string> checksum = noted_checksum(request);
    std::optional<ReferenceHalf> half = read_channels(path, window);
    if (half && checksum && hexadecimal(fingerprint(*half)) == *checksum) return half;
  } catch (const InputError&) {
    // As any other damage.
  }
  log_info(path + ": damaged, or of another frame; it is rendered anew");
  return std::nullopt;
}

std::optional<ReferenceHalf> render_reference_half(const StudyRenderer& renderer,
                                                   const ReferenceRequest& request,
                                                   const std::stop_token& stop) {
  std::optional<StudyPicture> picture =
      renderer.render(request.options, study_reference_aovs(), stop);
  if (!picture) return std::nullopt;
  ExrHeader header;
  header.width = request.options.width;
  header.height = request.options.height;
  header.data_window = renderer.window();
  for (const FilmChannel& channel : film_channels(study_reference_aovs())) {
    header.channels.push_back({channel.name});
  }
  header.attributes = {{"emberline:study_reference", request.key}};
  // The note last: pixels without one are not believed.
  const std::string base = base_name(request);
  write_exr_file(base + ".exr", header, picture->values);
  const Json note = {{"key", request.key}, {"checksum", hexadecimal(fingerprint(picture->values))}};
  write_file_atomically(base + ".json", note.dump(1) + "\n");
  return std::move(picture->values);
}

RgbImage reference_picture(const ReferenceHalf& half, const Rect& window) {
  return to_rgb_image(half, kChannels, window);
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
