#include "renderer/output/frame_memory.h"

#include "renderer/core/file_suffix.h"
#include "renderer/core/limit_error.h"
#include "renderer/output/snapshots.h"

namespace emberline {

uint64_t frame_bytes(const RenderOptions& options, const OutputSettings& settings,
                     const FrameRender& render) {
  uint64_t per_pixel = render.bytes_per_pixel(settings.aovs);
  if (!checkpoint_path(options).empty()) per_pixel *= 2;  // a copy of it is written behind
  for (const std::string& path : options.outputs) {
    // The picture, and its file as long as that may be.
    if (!is_exr(path)) per_pixel += 2 * (settings.transparent ? 4 : 3);
  }
  for (const std::string& path : options.heatmaps) {
    per_pixel += sizeof(float) + (is_exr(path) ? 0 : 2 * 3);
  }
  if (!options.snapshots.empty()) {
    const std::string_view moments =
        options.snapshot_at ? std::string_view(*options.snapshot_at) : kDefaultSnapshotMoments;
    per_pixel += 4 * sizeof(float) * parse_snapshot_moments(moments).size();
  }
  return bytes_of(uint64_t(settings.crop.area()), per_pixel);
}

void reserve_frame(uint64_t bytes, const Rect& crop, MemoryReservation& memory) {
  try {
    memory.add(bytes, "");
  } catch (const LimitError&) {
    throw UsageError("--size, --crop: a frame of {}x{} pixels {}", crop.width(), crop.height(),
                     memory.budget()->refusal(MemoryPart::kFilm, bytes));
  }
}

}  // namespace emberline
