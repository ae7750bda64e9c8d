// A tiled OpenEXR file that is written tile by tile, in any order, from any thread.
//
// The file is written beside its target under a temporary name, flushed to disk and renamed in
// finish(); destroyed without finish() it leaves nothing behind.
//
// One level, tiles in the order in which they come (line order "random Y"): what is held in memory
// is the tile at hand of each calling thread, and eight bytes for every tile of the frame and part.
// No threads are started; a tile is compressed by the thread that brings it, outside the lock.
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
// Whether it changes colours: channels of layers of R, G and B.
inline bool is_lossy(ExrCompression compression) { return compression >= ExrCompression::kDwaa; }

std::span<const NamedValue<ExrParts>> exr_parts_table();

// "albedo" of "albedo.R"; of R, G, B and A "RGBA", else of a name without a full stop itself.
std::string layer_of(const std::string& channel);
// Whether the channel's values say what a colour is to look like, so that they may be blurred a
// little: not what is counted, reckoned with, or an id.
bool is_colour(const std::string& channel);

// HH:MM:SS:FF of a frame from 0 on, as SMPTE ST 12-1 packs it, without dropped frames; frames a
// second are rounded up. Nothing beyond a day, or 39 frames a second, which it cannot say.
std::optional<uint32_t> smpte_time_code(int64_t frame, double fps);
// 24 as 24 / 1, 23.976 as 24000 / 1001.
std::pair<int32_t, uint32_t> frame_rate_fraction(double fps);

struct ExrHeader {
  int width = 0, height = 0;  // display window: the whole frame
  Rect data_window;           // what is rendered (the crop)
  int tile_size = 64;         // tiles are aligned to the data window's corner
  std::vector<PictureChannel> channels;
  ExrView view = {};
  // A lossy one is that of colours alone: of a part without others, or of one whose others end in
  // no R, G or B; a part with such others is kZip.
  ExrCompression compression = ExrCompression::kZip;
  ExrParts parts = ExrParts::kOne;
  // String attributes: settings, versions, seed, command line.
  std::vector<std::pair<std::string, std::string>> attributes;
};

class ExrWriter {
 public:
  // Creates the file and writes its header. Throws RenderError when the file cannot be created
  // (no such folder, a folder of that name, not writable, disk full).
  ExrWriter(const std::string& path, const ExrHeader& header);
  ~ExrWriter();
  ExrWriter(const ExrWriter&) = delete;
  ExrWriter& operator=(const ExrWriter&) = delete;

  // `pixels` holds rect.area() x channels floats, interleaved in header order, rows from rect.y0.
  // `rect` is one whole tile (clipped by the data window) in frame coordinates, given once.
  // kUint is rounded to nearest, clamped to [0, 2^32 - 1]; exact to 2^24. kHalf is rounded to
  // nearest, clamped to its largest finite value.
  // Thread-safe. Throws RenderError (disk full); after that every call throws the same.
  void write_tile(const Rect& rect, const std::vector<float>& pixels);

  // All tiles, of `pixels` that hold the data window's rows from the top, interleaved likewise.
  void write(std::span<const float> pixels);

  // Replaces the value of one of the header's attributes, which is known only now: it is padded
  // with blanks to the length that the attribute had, and no longer than that. Before finish().
  // Throws RenderError.
  void set_attribute(const std::string& name, const std::string& value);

  // Tiles never written are filled with 0 (a stopped render stays readable). Call once, when no
  // thread writes any more. Throws RenderError; nothing is left behind then.
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// A picture that is held as a whole (ExrWriter::write) as a file, which appears whole or not at
// all. Throws RenderError.
void write_exr_file(const std::string& path, const ExrHeader& header,
                    std::span<const float> pixels);

}  // namespace emberline
