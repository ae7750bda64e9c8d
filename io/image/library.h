// OpenImageIO behind an interface, for what io/image/codecs.h does not do.
//
// It brings some 240 libraries along, whose loading takes half a second of processor time. So it is
// reached through a library of its own (image/openimageio.cpp), which is loaded for the first such
// image.
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

// What an encoded image says it holds; nothing of it is checked.
struct ImageLayout {
  int x = 0, y = 0, width = 0, height = 0, depth = 0;  // the data window
  int full_x = 0, full_y = 0, full_width = 0, full_height = 0;
  int tile_width = 0, tile_height = 0;  // 0: in rows
  bool deep = false;
  std::vector<std::string> channel_names;
  std::vector<SampleType> channel_types = {};
  SampleType type = SampleType::kOther;  // of all channels, or that which holds them all
  std::string type_name;
  int alpha_channel = -1;
  bool premultiplied = false;  // whatever was asked for
  int orientation = 1;         // as in EXIF and TIFF
  uint64_t bytes = 0;          // of its pixels, as they are stored
  std::vector<std::pair<std::string, std::string>> texts =
      {};                                             // of an EXR, whose names begin as ours
  std::vector<ImagePart> parts = {};                  // of an EXR, those not read too
  ExrView view = {};                                  // of an EXR, but for its space
  std::optional<Chromaticities> chromaticities = {};  // that an EXR says it has

  int channels() const { return int(channel_names.size()); }
};

// A channel of a tile, its rows one behind another: kFloat, kHalf or kUint32.
struct EncodedPlane {
  std::string channel;
  SampleType type = SampleType::kFloat;
  const uint8_t* values = nullptr;
};

class ImageDecoder {
 public:
  virtual ~ImageDecoder() = default;
  const ImageLayout& layout() const { return layout_; }
  virtual std::string attribute(const char* /*name*/) const { return ""; }  // a text, else empty
  // Channels [first, last) of some pixels, counted from the data window's corner, interleaved,
  // converted; rows of `out` are `row` bytes apart. Pixels are whole tiles or, of an image in rows,
  // whole rows. Nothing, or why it failed.
  virtual std::string read(const Rect& pixels, int first, int last, SampleType type, std::byte* out,
                           size_t row) = 0;

 protected:
  // Of a picture without layers: kUint8, kUint16 or kFloat in all channels.
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

// A Decoder, unless its open(arguments...) has something to say: then null, and that.
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
  // Of an EXR whose parts have the same pixels the channels of all are one image's.
  // `format` is "webp", "openexr" or "tiff"; alpha is not multiplied where the reader obeys.
  // Null: `error` says why. `source` outlives the decoder.
  virtual std::unique_ptr<ImageDecoder> open(const std::string& format, const ByteSource& source,
                                             std::string& error) const = 0;
  // A tile's code as EXR's DWAA has it, or `wide` as DWAB. Nothing, or why it failed.
  virtual std::string encode_dwa(int width, int height, std::span<const EncodedPlane> planes,
                                 bool wide, std::vector<uint8_t>& code) const = 0;
  // An animation of pictures of one size and three channels. Nothing, or why it failed.
  virtual std::string encode_gif(std::span<const ByteImage> pictures, double picture_s,
                                 std::vector<unsigned char>& encoded) const = 0;
};

// Throws RenderError where the library is not beside the program, or not of this version.
const ImageLibrary& image_library();

// What loading it has taken so far: some hundred megabytes or, before it is loaded, nothing.
uint64_t image_library_bytes();

// What the library exports: null for another version than its own.
extern "C" const ImageLibrary* emberline_image_library(const char* version);

}  // namespace emberline
