// A tiled OpenEXR file that is written tile by tile, in any order, from any thread.
//
// The file is written beside its target under a temporary name, flushed to disk and renamed in
// finish(); destroyed without finish() it leaves nothing behind.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "renderer/core/rect.h"

namespace emberline {

enum class ChannelType : uint8_t { kHalf, kFloat, kUint };

struct ExrChannel {
  std::string name;  // "R", "albedo.G", "samples"
  ChannelType type = ChannelType::kFloat;
};

struct ExrHeader {
  int width = 0, height = 0;  // display window: the whole frame
  Rect data_window;           // what is rendered (the crop)
  int tile_size = 64;         // tiles are aligned to the data window's corner
  std::vector<ExrChannel> channels;
  // String attributes: settings, versions, seed, command line.
  std::vector<std::pair<std::string, std::string>> attributes;
};

class ExrWriter {
 public:
  // Throws RenderError when the file cannot be created.
  ExrWriter(const std::string& path, const ExrHeader& header);
  ~ExrWriter();
  ExrWriter(const ExrWriter&) = delete;
  ExrWriter& operator=(const ExrWriter&) = delete;

  // `pixels` holds rect.area() x channels floats, interleaved in header order, rows from rect.y0;
  // kUint channels are given as floats and rounded (exact to 2^24) . `rect` is one whole tile (clipped
  // by the data window) in frame coordinates. Thread-safe; takes a lock per tile. Throws
  // RenderError (disk full).
  void write_tile(const Rect& rect, const std::vector<float>& pixels);

  // Tiles never written are filled with 0 (a stopped render stays readable). Throws RenderError.
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace emberline
