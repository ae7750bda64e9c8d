// Images in. Reading one ends with Cancelled where `progress` says so.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "io/exr/view.h"
#include "io/image/colour.h"
#include "renderer/core/load_progress.h"
#include "renderer/core/rect.h"
#include "renderer/description/scene_description.h"

namespace emberline {

// Of any image that is read, and of pictures that the library writes.
inline constexpr int kMostChannels = 4096;

struct DecodedImage {
  std::shared_ptr<const Image> image;
  uint64_t non_finite = 0;  // texels that were, and became 0
  bool cut_short = false;   // a JPEG that ends early: grey from there on
  std::string transfer;     // what a KTX 2 says of its values: "sRGB" or "linear"
};

// Decodes an encoded image held in memory (PNG, JPEG, WebP, EXR, HDR, KTX 2: whatever its name
// says), keeping its bit depth and not premultiplying alpha. An EXR is read as for
// read_environment(), with its alpha. Colour profiles and other metadata are not read. Throws
// InputError naming `place`; for a JPEG that ends early, too, unless `lenient`.
DecodedImage decode_image(std::span<const uint8_t> encoded, const std::string& place,
                          bool lenient = false,
                          const LoadProgress& progress = LoadProgress::unwatched());

// Reads a latitude-longitude environment map (.hdr, .exr; the channels that find_colour() finds;
// half if the file is half, else float), whose pixels fill its frame, as linear Rec. 709: an EXR
// that says it has other primaries is converted, and what lies outside those of Rec. 709 is
// negative. NaN, infinite and negative texels become 0, finite ones beyond the type's range are
// clamped to it; all are counted. Throws InputError.
std::shared_ptr<const Image> read_environment(
    const std::string& path, uint64_t* repaired,
    const LoadProgress& progress = LoadProgress::unwatched());

// A float image with named channels, for `compare`, `heatmap` and the tests: EXR, HDR, PNG, JPEG,
// WebP, TIFF. Integer formats are decoded from sRGB to linear. Data window only.
struct FloatImage {
  int width = 0, height = 0;
  Rect data_window;                       // these pixels, counted from the frame's corner
  int frame_width = 0, frame_height = 0;  // the display window
  std::vector<std::string> channel_names;
  std::vector<ImagePart> parts;  // of an EXR
  std::vector<float> values;     // interleaved
  // The frame was stopped before it was complete, as its header says (renderer/output/outputs.h):
  // the samples there.
  std::optional<uint64_t> stopped_after;
  WorkingSpace space = WorkingSpace::kRec709;  // of an EXR
  int channels() const { return int(channel_names.size()); }
  // Channel index by name ("R", "albedo.G"), -1 if absent.
  int find_channel(const std::string& name) const;
};
// An EXR of any size, its rows one after another. Reading may throw Cancelled, as above.
class FloatImageRows {
 public:
  // Throws InputError for what is no EXR.
  explicit FloatImageRows(const std::string& path,
                          const LoadProgress& progress = LoadProgress::unwatched());
  ~FloatImageRows();
  FloatImageRows(const FloatImageRows&) = delete;
  FloatImageRows& operator=(const FloatImageRows&) = delete;

  // As above, without values.
  const FloatImage& image() const;
  bool is_counter(size_t channel) const;  // stored as whole numbers
  // The header's texts whose names begin with "emberline" or "cryptomatte/".
  const std::vector<std::pair<std::string, std::string>>& texts() const;
  const ExrView& view() const;
  int tile_size() const;     // of its tiles' height; of an image in rows, 64
  int rows_at_once() const;  // read() takes a multiple of these, or all that are left
  // The rows that follow, interleaved. Throws InputError.
  void read(int rows, std::vector<float>& values);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

FloatImage read_float_image(const std::string& path,
                            const LoadProgress& progress = LoadProgress::unwatched());

}  // namespace emberline
