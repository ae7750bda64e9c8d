#include "renderer/drivers/driver_table.h"

#include "renderer/core/names.h"
#include "renderer/drivers/adaptive_driver.h"
#include "renderer/drivers/bisection_driver.h"
#include "renderer/drivers/bucket_schedule.h"
#include "renderer/drivers/uniform_driver.h"

namespace emberline {
namespace {

// This size is our choice. A frame of 4096 x 4096 pixels then has at most 65536 tiles, and buckets
// with a side of 16 pixels or more are not joined.
constexpr int kMinTileSize = 16;

bool has_threshold(const DriverSettings& settings) { return settings.adaptive.threshold > 0.0f; }

constexpr DriverEntry kDrivers[] = {
    {"bucket", "one bucket after another; each is finished and written before the next",
     SampleDistribution::kUniformWithoutThreshold, true,
     [](const Frame& frame, const Rect& pixels, const DriverSettings& settings) {
       return has_threshold(settings) ? adaptive_tile_driver(frame, pixels, settings)
                                      : uniform_driver(frame, pixels);
     },
     [](const DriverSettings& settings) {
       return has_threshold(settings) ? adaptive_film_extras(settings) : FilmExtras{};
     },
     [](const DriverSettings& settings) {
       return has_threshold(settings) ? adaptive_bytes_per_pixel(settings) : 0;
     }},
    {"bisection", "the whole frame at once, refined pass by pass", SampleDistribution::kUniform,
     false, bisection_driver, [](const DriverSettings&) { return FilmExtras{}; },
     [](const DriverSettings&) { return uint64_t(0); }},
    {"adaptive", "the whole frame, with most samples where the error is largest",
     SampleDistribution::kByError, false, adaptive_driver, adaptive_film_extras,
     adaptive_bytes_per_pixel},
};

constexpr DriverEntry kPlannedDriver = {
    "adaptive",
    "one bucket after another, with the sample counts of a plan",
    SampleDistribution::kByError,
    true,
    planned_driver,
    [](const DriverSettings&) { return FilmExtras{}; },
    [](const DriverSettings&) { return uint64_t(0); }};

}  // namespace

std::span<const DriverEntry> driver_table() { return kDrivers; }

const DriverEntry& find_driver(std::string_view name) {
  return find_named(kDrivers, "`driver`", "driver", name);
}

const DriverEntry& planned_driver_entry() { return kPlannedDriver; }

int tile_size(const DriverEntry& driver, int bucket_size) {
  return driver.tiles ? bucket_size : round_up_to_buckets(bucket_size, kMinTileSize);
}

FilmExtras film_extras(const DriverEntry& driver, const DriverSettings& settings) {
  FilmExtras extras = driver.film_extras(settings);
  extras.cryptomattes = settings.cryptomattes;
  extras.cryptomatte_levels = settings.cryptomatte_levels;
  return extras;
}

DriverFactory driver_factory(std::string_view driver, const DriverSettings& settings) {
  return driver_factory(find_driver(driver), settings);
}

DriverFactory driver_factory(const DriverEntry& entry, const DriverSettings& settings) {
  return {.tiles = entry.tiles,
          .tile_size = tile_size(entry, settings.bucket_size),
          .tile_order = settings.bucket_order,
          .part = settings.part,
          .film_extras = film_extras(entry, settings),
          .bytes_per_pixel = entry.bytes_per_pixel(settings),
          .create = [&entry, settings](const Frame& frame, const Rect& pixels) {
            return entry.create(frame, pixels, settings);
          }};
}

}  // namespace emberline
