// Interface to OpenImageIO, for WebP and TIFF, and for writing GIF.
//
// OpenImageIO pulls in about 240 libraries, which take half a second of CPU time to load. Therefore
// it is linked into a separate library (image/openimageio.cpp). That library is loaded when one of
// these formats is used for the first time.
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
#include "io/image/byte_cursor.h"
#include "io/image/colour.h"
#include "io/image/output.h"
#include "renderer/core/rect.h"

namespace emberline {

enum class SampleType : uint8_t { kUint8, kUint16, kUint32, kHalf, kFloat, kOther };

// Values that an encoded image states about itself. They are not checked.
struct ImageLayout {
  int x = 0, y = 0, width = 0, height = 0, depth = 0;  // the data window
  int full_x = 0, full_y = 0, full_width = 0, full_height = 0;
  int tile_width = 0, tile_height = 0;  // 0: stored in rows
  int rows_per_block = 1;               // rows that are decoded together, if there are no tiles
  bool deep = false;
  std::vector<std::string> channel_names;
  std::vector<SampleType> channel_types = {};
  SampleType type = SampleType::kOther;  // the type of all channels, or one that can hold them all
  std::string type_name;
  int alpha_channel = -1;
  bool premultiplied = false;  // can be true even though we request unassociated alpha
  int orientation = 1;         // as in EXIF and TIFF
  uint64_t bytes = 0;          // size of the stored pixels
  std::vector<std::pair<std::string, std::string>> text_attributes =
      {};                                             // EXR: our own text attributes
  std::vector<ImagePart> parts = {};                  // EXR: all parts, including unread ones
  ExrView view = {};                                  // EXR: the decoder sets all but `space`
  std::optional<Chromaticities> chromaticities = {};  // EXR: as stated in the header

  int channels() const { return int(channel_names.size()); }
};

class ImageDecoder {
 public:
  virtual ~ImageDecoder() = default;
  const ImageLayout& layout() const { return layout_; }
  virtual std::string attribute(const char* /*name*/) const { return ""; }  // its text, or empty
  // Reads channels [first, last) of `pixels` (relative to the data window's corner). They are
  // converted to `type` and interleaved, with `row` bytes from one row of `out` to the next.
  // `pixels` must consist of whole tiles or, for an image stored in rows, of whole rows. Returns an
  // empty string or the error.
  virtual std::string read(const Rect& pixels, int first, int last, SampleType type, std::byte* out,
                           size_t row) = 0;

 protected:
  // Sets the layout of an image without layers. All channels have the same type: kUint8, kUint16 or
  // kFloat.
  void set_layout(int width, int height, std::vector<std::string> channels, SampleType type) {
    layout_.width = layout_.full_width = width;
    layout_.height = layout_.full_height = height;
    layout_.channel_names = std::move(channels);
    layout_.channel_types.assign(layout_.channel_names.size(), type);
    layout_.type = type;
    layout_.type_name = type == SampleType::kUint8    ? "uint8"
                        : type == SampleType::kUint16 ? "uint16"
                                                      : "float";
  }

  ImageLayout layout_;
};

// Creates a Decoder and calls its open(arguments...). On failure, sets `error` and returns null.
template <typename Decoder, typename... Arguments>
std::unique_ptr<ImageDecoder> open_decoder(std::string& error, Arguments&&... arguments) {
  auto decoder = std::make_unique<Decoder>();
  error = decoder->open(std::forward<Arguments>(arguments)...);
  if (!error.empty()) return nullptr;
  return decoder;
}

// Thread-safe.
class ImageLibrary {
 public:
  virtual ~ImageLibrary() = default;
  // `format` is "webp" or "tiff". Alpha is unassociated if the reader supports that. On failure,
  // returns null and sets `error`. `source` must outlive the decoder.
  virtual std::unique_ptr<ImageDecoder> open(const std::string& format, const ByteSource& source,
                                             std::string& error) const = 0;
  // Encodes three-channel pictures of the same size as an animation. Returns an empty string or the
  // error.
  virtual std::string encode_gif(std::span<const ByteImage> pictures, double frame_s,
                                 std::vector<unsigned char>& encoded) const = 0;
};

// Loads the library on first use. Throws RenderError if it is missing or does not have the
// program's version.
const ImageLibrary& image_library();

// Returns the memory that the library uses: a few hundred megabytes, or 0 before it is loaded.
uint64_t image_library_bytes();

// The library's entry point. Returns null if `version` differs from the library's own version.
extern "C" const ImageLibrary* emberline_image_library(const char* version);

}  // namespace emberline
