// The drivers by name.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "renderer/core/rect.h"
#include "renderer/core/vector.h"
#include "renderer/drivers/adaptive/adaptive_settings.h"
#include "renderer/drivers/driver_choices.h"
#include "renderer/film/film_extras.h"

namespace emberline {

struct Frame;
class FrameDriver;

struct DriverSettings {
  int bucket_size = 64;
  BucketOrder bucket_order = BucketOrder::kHilbert;
  FramePart part = {};
  BisectionAxis bisection_axis = BisectionAxis::kBoth;
  Reconstruction reconstruction = Reconstruction::kDuplicate;
  AdaptiveSettings adaptive = {};
  std::optional<Vec2i> explained = {};  // the pixel for FrameDriver::explain()
  bool extending = false;               // a finished frame with fewer samples; its pilot is done
  bool keep_tree = false;               // for DriverFacts::tree
  int cryptomattes = 0, cryptomatte_levels = 0;  // FilmExtras'
};

// How many samples each pixel gets.
enum class Sharing : uint8_t { kEven, kEvenWithoutThreshold, kByError };

struct DriverEntry {
  std::string_view name;
  std::string_view summary;
  Sharing sharing;
  bool tiles;  // as in DriverFactory
  // Makes a driver for these pixels of the frame.
  std::unique_ptr<FrameDriver> (*create)(const Frame& frame, const Rect& pixels,
                                         const DriverSettings& settings);
  FilmExtras (*film_extras)(const DriverSettings& settings);
  uint64_t (*bytes_per_pixel)(const DriverSettings& settings);  // as in DriverFactory
};
std::span<const DriverEntry> driver_table();

// Throws UsageError that lists the valid names.
const DriverEntry& find_driver(std::string_view name);

// The side of the tiles that are delivered, and of the EXR's tiles: buckets. A driver of the whole
// frame joins small buckets, since each tile costs its outputs some time.
int tile_size(const DriverEntry& driver, int bucket_size);

// Makes the drivers of a frame.
struct DriverFactory {
  // One driver for each tile, which is finished and released before the next; otherwise one for the
  // whole crop, which can be shown at any time.
  bool tiles = false;
  int tile_size = 64;  // pixels; also for delivering a whole crop
  BucketOrder tile_order = BucketOrder::kHilbert;
  FramePart part = {};  // of the tiles
  FilmExtras film_extras = {};
  uint64_t bytes_per_pixel = 0;  // the most that a driver takes, without the film
  std::function<std::unique_ptr<FrameDriver>(const Frame& frame, const Rect& pixels)> create;
};

// The extras of the driver's film, without light groups.
FilmExtras film_extras(const DriverEntry& driver, const DriverSettings& settings);

// Throws what find_driver() does.
DriverFactory driver_factory(std::string_view driver, const DriverSettings& settings);

}  // namespace emberline
