// Writes a tiled OpenEXR file tile by tile, in any order, from any thread.
//
// The file is written under a temporary name beside its target, flushed to disk and renamed in
// finish(). A writer that is destroyed without finish() leaves nothing behind.
//
// The file has one resolution level; its tiles are stored in order of arrival (line order "random
// Y"). The writer needs memory for the current tile of each calling thread, plus eight bytes for
// each tile of each part. It starts no threads; the calling thread compresses its tile outside the
// lock.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "io/exr/choices.h"
#include "io/exr/view.h"
#include "renderer/core/names.h"
#include "renderer/core/picture_channel.h"
#include "renderer/core/rect.h"

namespace emberline {

std::span<const NamedValue<ExrCompression>> exr_compression_table();
// True if the compression changes colours (the R, G and B channels of layers).
inline bool is_lossy(ExrCompression compression) { return compression >= ExrCompression::kDwaa; }

std::span<const NamedValue<ExrParts>> exr_parts_table();

// Returns the layer of a channel: "albedo" for "albedo.R", and "RGBA" for R, G, B and A. Any other
// name without a full stop is a layer itself.
std::string layer_of(const std::string& channel);
// True if the channel is a colour for viewing, which lossy compression may blur. False for a count,
// an id or data for computation.
bool is_colour(const std::string& channel);

// Returns the time code HH:MM:SS:FF of a frame. Frames are numbered from 0, and `fps` is rounded
// up. The time code is packed as in SMPTE ST 12-1 without drop frames. Returns nothing for what the
// format cannot express: negative frames, times from 24 hours on, and rates that are not above 0 or
// are above 40 frames per second.
std::optional<uint32_t> smpte_time_code(int64_t frame, double fps);
// Returns the frame rate as a fraction: 24 becomes 24 / 1, and 23.976 becomes 24000 / 1001.
std::pair<int32_t, uint32_t> frame_rate_fraction(double fps);

struct ExrHeader {
  int width = 0, height = 0;  // display window: the whole frame
  Rect data_window;           // the rendered region (crop)
  int tile_size = 64;         // tiles start at the data window's corner
  std::vector<PictureChannel> channels;
  ExrView view = {};
  // The compression of all parts, with one exception. Lossy compression would blur a data channel
  // whose name looks like a colour or luminance to OpenEXR. A part with such a channel (for which
  // is_colour() is false) uses kZip instead.
  ExrCompression compression = ExrCompression::kZip;
  ExrParts parts = ExrParts::kOne;
  // String attributes, such as the settings, the versions, the seed and the command line.
  std::vector<std::pair<std::string, std::string>> attributes;
};

class ExrWriter {
 public:
  // Creates the file and writes its header. Throws RenderError if this fails (no such folder, a
  // folder of that name, not writable, disk full).
  ExrWriter(const std::string& path, const ExrHeader& header);
  ~ExrWriter();
  ExrWriter(const ExrWriter&) = delete;
  ExrWriter& operator=(const ExrWriter&) = delete;

  // `pixels` holds rect.area() x channels floats, interleaved in header order, with rows from
  // rect.y0. `rect` must be one whole tile (clipped to the data window) in frame coordinates. Each
  // tile must be written only once.
  //
  // Values of kUint are rounded to nearest and clamped to [0, 2^32 - 1]; they are exact up to 2^24.
  // Values of kHalf are rounded to nearest and clamped to the finite range.
  //
  // Thread-safe. Throws RenderError (disk full); after that, every call throws the same error.
  void write_tile(const Rect& rect, const std::vector<float>& pixels);

  // Writes all tiles. `pixels` holds the data window's rows from the top, interleaved as in
  // write_tile().
  void write(std::span<const float> pixels);

  // Replaces the value of a header attribute. The new value is padded with blanks to the old length
  // and must not be longer. Call before finish(). Throws RenderError.
  void set_attribute(const std::string& name, const std::string& value);

  // Fills missing tiles with 0, so that the file of a cancelled render is readable, and renames the
  // file. Call once, after the last write. If this throws RenderError, nothing is left behind.
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Writes a whole image atomically. Throws RenderError.
void write_exr_file(const std::string& path, const ExrHeader& header,
                    std::span<const float> pixels);

}  // namespace emberline
