#include "renderer/output/frame_memory.h"

#include <fmt/format.h>

#include <algorithm>

#include "renderer/core/errors.h"
#include "renderer/core/file_suffix.h"
#include "renderer/drivers/adaptive/judged_channels.h"
#include "renderer/drivers/bucket_schedule.h"
#include "renderer/engine/film_memory.h"
#include "renderer/output/light_layers.h"
#include "renderer/output/snapshots.h"

namespace emberline {
namespace {

uint64_t saturating_sum(uint64_t a, uint64_t b) { return a > UINT64_MAX - b ? UINT64_MAX : a + b; }

// Throws a UsageError that begins with `subject()` if the budget is too small.
template <class Subject>
void reserve_memory(uint64_t bytes, MemoryReservation& memory, const Subject& subject) {
  const MemoryBudget& budget = *memory.budget();
  const uint64_t left = budget.limit() - budget.reserved();
  try {
    memory.add(bytes, "");
  } catch (const LimitError&) {
    throw UsageError("{} {}", subject(), budget.limit_message(MemoryPart::kFilm, bytes, left));
  }
}

// OpenEXR's encoder for DWAA and DWAB needs 1 to 7 MB for its tables (measured). Its buffers are
// covered by write_bytes_per_pixel().
uint64_t lossy_encoder_bytes(const RenderOptions& options) {
  const bool used =
      is_lossy(options.exr_compression) && std::ranges::any_of(options.outputs, is_exr);
  return used ? uint64_t(8) << 20 : 0;
}

// Returns an upper bound on the memory of the job and the outputs, including that for encoding a
// picture. Does not include light groups.
uint64_t frame_bytes(const RenderOptions& options, const OutputSettings& settings,
                     const RenderPlan& plan) {
  uint64_t per_pixel = job_bytes_per_pixel(plan.drivers(), plan.aovs);
  if (!checkpoint_path(options).empty()) per_pixel *= 2;  // a copy is written in the background
  if (!plan.driver->tiles) {
    per_pixel +=
        4 * sizeof(float) + delivery_bytes_per_pixel(PathLayers(settings.aovs).list().size());
  }
  if (!options.snapshots.empty()) {
    const std::string_view moments =
        options.snapshot_at ? std::string_view(*options.snapshot_at) : kDefaultSnapshotMoments;
    per_pixel += 4 * sizeof(float) * parse_snapshot_moments(moments).size();
  }
  return saturating_sum(bytes_of(uint64_t(settings.crop.area()), per_pixel),
                        output_bytes(options, settings, {}));
}

uint64_t light_group_bytes(const RenderOptions& options, const OutputSettings& settings,
                           const RenderPlan& plan, const std::vector<std::string>& layers) {
  uint64_t bytes = 0;
  if (!plan.driver->tiles) {
    const uint64_t saved = checkpoint_path(options).empty() ? 1 : 2;
    const uint64_t copies = saved * (settings.aovs.contains(Aov::kDenoising) ? 2 : 1);
    bytes = bytes_of(uint64_t(settings.crop.area()),
                     copies * LightGroupSums::bytes_per_pixel(int(layers.size())) +
                         saved * judged_light_bytes(plan, layers.size()) +
                         delivery_bytes_per_pixel(layers.size()));
  }
  return bytes + output_bytes(options, settings, layers) - output_bytes(options, settings, {});
}

// Returns the bytes that light groups add per pixel of a tile: for the film of all samples and,
// with denoising, for the film of one half.
uint64_t light_tile_bytes_per_pixel(const RenderPlan& plan, size_t lights) {
  const uint64_t films = plan.aovs.contains(Aov::kDenoising) ? 2 : 1;
  const uint64_t judged = plan.driver->tiles ? judged_light_bytes(plan, lights) : 0;
  return films * LightGroupSums::bytes_per_pixel(int(lights)) + judged;
}

// Reserves memory for the frame's bucket list and for the tile offsets of each output.
void reserve_bucket_lists(const RenderOptions& options, const OutputSettings& settings,
                          MemoryReservation& memory) {
  const uint64_t count = bucket_count(settings.crop, settings.tile_size);
  const uint64_t bytes = bucket_list_bytes(settings.crop, settings.tile_size) +
                         count * sizeof(uint64_t) * options.outputs.size();
  reserve_memory(bytes, memory, [&] {
    return fmt::format("`bucket-size`: the list of {} buckets of {}x{} pixels", count,
                       settings.tile_size, settings.tile_size);
  });
}

void reserve_tiles(uint64_t film_bytes_per_pixel, size_t channels, const OutputSettings& settings,
                   int threads, MemoryReservation& memory) {
  const ActiveBuckets at_work = active_buckets(settings.crop, settings.tile_size, threads);
  const uint64_t bytes =
      bytes_of(at_work.pixels(), film_bytes_per_pixel + write_bytes_per_pixel(channels));
  reserve_memory(bytes, memory, [&] {
    return fmt::format("`bucket-size`, `threads`: working on {} bucket{} of {}x{} pixels at once",
                       at_work.count, at_work.count == 1 ? "" : "s", at_work.width, at_work.height);
  });
}

}  // namespace

uint64_t judged_light_bytes(const RenderPlan& plan, size_t lights) {
  const std::vector<JudgedChannel>& judged = plan.driver_settings.adaptive.judged;
  return judged_bytes_per_pixel(judged, int(lights)) - judged_bytes_per_pixel(judged, 0);
}

uint64_t output_bytes(const RenderOptions& options, const OutputSettings& settings,
                      const std::vector<std::string>& layers) {
  uint64_t per_pixel = 0;
  for (const std::string& path : options.outputs) {
    // Counts the picture and its encoded file, which is at most as large as the picture.
    if (!is_exr(path)) per_pixel += 2 * (settings.transparent ? 4 : 3);
  }
  for (const std::string& path : options.heatmaps) {
    per_pixel += sizeof(float) + (is_exr(path) ? 0 : 2 * 3);
  }
  const uint64_t bytes = bytes_of(uint64_t(settings.crop.area()), per_pixel);
  if (options.outputs.empty()) return bytes;
  const std::vector<std::string> names = names_of(tile_channels(settings, layers));
  uint64_t more = lossy_encoder_bytes(options);
  if (settings.denoise) {
    more += denoise_bytes(settings.crop, settings.tile_size, names);
  } else if (settings.aovs.contains(Aov::kDenoising)) {
    const auto rows = uint64_t(settings.tile_size) + 2;
    more += bytes_of(uint64_t(settings.crop.width()) * rows, 2 * names.size() * sizeof(float));
  }
  return saturating_sum(bytes, more);
}

// The factor 5 covers the pixels, the EXR rows and the EXR library's copies. We measured it with 5
// and 15 channels.
uint64_t write_bytes_per_pixel(size_t channels) { return 5 * sizeof(float) * channels; }

void reserve_pixels(uint64_t bytes, const Rect& crop, MemoryReservation& memory) {
  reserve_memory(bytes, memory, [&] {
    return fmt::format("`size`, `crop`: a frame of {}x{} pixels", crop.width(), crop.height());
  });
}

void reserve_frame(const RenderOptions& options, const OutputSettings& settings,
                   const RenderPlan& plan, int threads, MemoryReservation& memory) {
  reserve_pixels(frame_bytes(options, settings, plan), settings.crop, memory);
  reserve_bucket_lists(options, settings, memory);
  reserve_tiles(tile_bytes_per_pixel(plan.drivers(), plan.aovs), tile_channels(settings, {}).size(),
                settings, threads, memory);
}

void reserve_lights(const RenderOptions& options, const OutputSettings& settings,
                    const RenderPlan& plan, const std::vector<std::string>& layers, int threads,
                    MemoryReservation& memory) {
  reserve_pixels(light_group_bytes(options, settings, plan, layers), settings.crop, memory);
  reserve_tiles(light_tile_bytes_per_pixel(plan, layers.size()),
                light_channel_names(layers, plan.aovs).size(), settings, threads, memory);
}

}  // namespace emberline
