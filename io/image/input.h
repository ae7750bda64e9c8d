// Reads images. Reading throws Cancelled if `progress` is cancelled.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "io/display/working_space.h"
#include "io/exr/view.h"
#include "io/image/colour.h"
#include "renderer/core/load_progress.h"
#include "renderer/core/picture_channel.h"
#include "renderer/core/rect.h"
#include "renderer/description/scene_description.h"

namespace emberline {

// Limit on the channels of an image.
inline constexpr int kMaxChannels = 4096;

struct DecodedImage {
  std::shared_ptr<const Image> image;
  uint64_t non_finite = 0;  // NaN and infinite components, which were set to 0
  bool truncated = false;   // whether a JPEG is truncated; its missing part is grey
  std::string transfer;     // the transfer function that a KTX 2 states: "sRGB" or "linear"
};

// Decodes an encoded image in memory: PNG, JPEG, WebP, EXR, HDR or KTX 2, detected by its content.
// Keeps the bit depth. The result's alpha is not premultiplied. Chooses an EXR's channels as
// read_environment() does, but keeps its alpha. Ignores colour profiles and other metadata. Throws
// InputError at `place`, also for a truncated JPEG unless `lenient`.
DecodedImage decode_image(std::span<const uint8_t> encoded, const std::string& place,
                          bool lenient = false,
                          const LoadProgress& progress = LoadProgress::none());

// Reads a latitude-longitude environment map (.hdr or .exr) as linear Rec. 709. Reads the channels
// that find_colour() chooses, as half if they are stored as half, otherwise as float. The pixels
// must cover the frame. An EXR with other primaries is converted: finite values beyond the type's
// range are clamped, and colours outside Rec. 709 become negative. Then NaN, infinite and negative
// components become 0, and their number is added to `*repaired`. Throws InputError.
std::shared_ptr<const Image> read_environment(const std::string& path, uint64_t* repaired,
                                              const LoadProgress& progress = LoadProgress::none());

// A float image with named channels, for `compare`, `heatmap` and tests. It comes from an EXR, HDR,
// PNG, JPEG, WebP or TIFF. Integer formats are converted from sRGB to linear. Contains only the
// data window.
struct FloatImage {
  int width = 0, height = 0;
  Rect data_window;                       // relative to the frame's corner
  int frame_width = 0, frame_height = 0;  // the display window
  std::vector<std::string> channel_names;
  std::vector<ImagePart> parts;  // EXR only
  std::vector<float> values;     // interleaved
  // If the header says that the frame is incomplete: the sample count at which the frame was
  // stopped (renderer/output/outputs.h).
  std::optional<uint64_t> stopped_after;
  WorkingSpace space = WorkingSpace::kRec709;  // EXR only
  // EXR only: the primaries that its header states. If `space` is not kRec709, these are the
  // primaries of `space`.
  std::optional<Chromaticities> chromaticities;
  int channels() const { return int(channel_names.size()); }
  // Returns the index of a channel ("R", "albedo.G"), or -1 if it is absent.
  int find_channel(const std::string& name) const;
};
// Reads an EXR of any size row by row. Reading may throw Cancelled.
class FloatImageRows {
 public:
  // Throws InputError if the file is not an EXR.
  explicit FloatImageRows(const std::string& path,
                          const LoadProgress& progress = LoadProgress::none());
  ~FloatImageRows();
  FloatImageRows(const FloatImageRows&) = delete;
  FloatImageRows& operator=(const FloatImageRows&) = delete;

  // The image's description, with empty `values`.
  const FloatImage& image() const;
  ChannelType channel_type(size_t channel) const;
  // The header's text attributes that begin with "emberline" or "cryptomatte/".
  const std::vector<std::pair<std::string, std::string>>& text_attributes() const;
  const ExrView& view() const;
  int tile_size() const;  // the tiles' height; 64 for an image that is stored in rows
  // Each call of read() must ask for a multiple of this many rows, or for all remaining rows.
  int rows_at_once() const;
  // Reads the next `rows` rows, with interleaved channels. Throws InputError.
  void read(int rows, std::vector<float>& values);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

FloatImage read_float_image(const std::string& path,
                            const LoadProgress& progress = LoadProgress::none());

}  // namespace emberline
