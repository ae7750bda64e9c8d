// The table of drivers, and functions to create them.
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
struct SamplePlan;

struct DriverSettings {
  int bucket_size = 64;
  BucketOrder bucket_order = BucketOrder::kHilbert;
  FramePart part = {};
  BisectionAxis bisection_axis = BisectionAxis::kBoth;
  Reconstruction reconstruction = Reconstruction::kDuplicate;
  AdaptiveSettings adaptive = {};
  std::optional<Vec2i> explained = {};           // the pixel for FrameDriver::explain()
  bool is_extension = false;                     // extends a finished frame, so the pilot is done
  bool keep_tree = false;                        // keeps the tree for DriverFacts::tree
  int cryptomattes = 0, cryptomatte_levels = 0;  // as in FilmExtras
  std::shared_ptr<const SamplePlan> plan = {};   // for planned_driver_entry()
};

// How a driver distributes samples over the pixels. kUniformWithoutThreshold means: by error if
// there is a threshold, otherwise uniformly.
enum class SampleDistribution : uint8_t { kUniform, kUniformWithoutThreshold, kByError };

struct DriverEntry {
  std::string_view name;
  std::string_view summary;
  SampleDistribution distribution;
  bool tiles;  // as in DriverFactory
  std::unique_ptr<FrameDriver> (*create)(const Frame& frame, const Rect& pixels,
                                         const DriverSettings& settings);
  FilmExtras (*film_extras)(const DriverSettings& settings);
  uint64_t (*bytes_per_pixel)(const DriverSettings& settings);  // as in DriverFactory
};
std::span<const DriverEntry> driver_table();

// Throws a UsageError that lists the valid names if the name is unknown.
const DriverEntry& find_driver(std::string_view name);

// Returns the driver of adaptive frames whose sample counts come from a SamplePlan. It is not in
// driver_table(), because the setting `plan` selects it instead of a name.
const DriverEntry& planned_driver_entry();

// Returns the side of the delivered tiles, which are also the tiles of the EXR. Each tile of a
// tiled driver is one bucket. Drivers of the whole frame join small buckets, since each tile takes
// the outputs extra time.
int tile_size(const DriverEntry& driver, int bucket_size);

struct DriverFactory {
  // If true, each tile has its own driver, and is finished and released before the next. If false,
  // one driver renders the whole crop, which can be shown at any time.
  bool tiles = false;
  int tile_size = 64;  // in pixels; a driver of the whole crop also delivers in tiles
  BucketOrder tile_order = BucketOrder::kHilbert;
  FramePart part = {};  // which tiles are rendered
  FilmExtras film_extras = {};
  uint64_t bytes_per_pixel = 0;  // upper bound on a driver's memory, without its film
  std::function<std::unique_ptr<FrameDriver>(const Frame& frame, const Rect& pixels)> create;
};

// Returns the extras of the driver's film, without light groups.
FilmExtras film_extras(const DriverEntry& driver, const DriverSettings& settings);

DriverFactory driver_factory(const DriverEntry& driver, const DriverSettings& settings);
// Throws what find_driver() throws.
DriverFactory driver_factory(std::string_view driver, const DriverSettings& settings);

}  // namespace emberline
