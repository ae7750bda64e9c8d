// The drivers by name.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "renderer/drivers/adaptive/round_planner.h"
#include "renderer/drivers/frame.h"
#include "renderer/drivers/frame_driver.h"

namespace emberline {

struct DriverSettings {
  int bucket_size = 64;
  std::string bucket_order = "hilbert";
  std::string bisection_axis = "both";
  std::string reconstruction = "duplicate";
  AdaptiveSettings adaptive = {};
  std::optional<Vec2i> explained = {};  // the pixel that AdaptiveDriver::explain is asked about
  bool keep_tree = false;               // AdaptiveDriver::tree will be asked for
};

// How many samples each pixel gets.
enum class Sharing : uint8_t { kEven, kEvenWithoutThreshold, kByError };

struct DriverEntry {
  std::string_view name;
  std::string_view summary;
  Sharing sharing;
  // One for each tile, which is finished and let go before the next; else one for the window, whose
  // picture is there all the time.
  bool tiles;
  // Of these pixels of the frame.
  std::unique_ptr<FrameDriver> (*create)(const Frame& frame, const Rect& pixels,
                                         const DriverSettings& settings);
  FilmExtras (*film_extras)(const DriverSettings& settings);
  // At most, of each pixel of the window: film and driver. With light groups 24 for each and 24
  // more.
  uint64_t (*bytes_per_pixel)(const AovSet& aovs, const DriverSettings& settings);
};
std::span<const DriverEntry> driver_table();

// Throws UsageError that lists the valid names.
const DriverEntry& find_driver(std::string_view name);

// Likewise, for what a driver may or may not read: a mistake is one even where the chosen driver
// would not look at it.
void check(const DriverSettings& settings);

}  // namespace emberline
