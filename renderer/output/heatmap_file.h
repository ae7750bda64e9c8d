// Writes heatmaps of a frame that is being rendered, or of the channels of a picture.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "io/exr/writer.h"
#include "io/files/atomic_file.h"
#include "renderer/core/rect.h"
#include "renderer/output/render_options.h"
#include "renderer/statistics/heatmap_quantity.h"

namespace emberline {

// A heatmap that --heatmap requests.
struct HeatmapRequest {
  std::string path;
  const HeatmapQuantity* quantity = nullptr;
};
// Pairs each --heatmap-of with the --heatmap at the same position. Heatmaps without a --heatmap-of
// show the number of samples. Throws UsageError for an unknown quantity or an unsuitable style.
std::vector<HeatmapRequest> heatmap_requests(const RenderOptions& options);

// Throws a UsageError that starts with `option` if the suffix is unknown or the picture is too
// large for its format.
void check_heatmap_format(const std::string& option, const std::string& path, const Rect& crop);

// Throws UsageError for a range or logarithmic scale that does not apply to the quantities.
void check_heatmap_style(const HeatmapStyle& style,
                         std::span<const HeatmapQuantity* const> quantities);

// Returns the names of the channels that the setting `judge` lists, for HeatmapStyle. Returns none
// if the setting `plan` gives the sample counts.
std::vector<std::string> judged_names(const FrameSettings& settings);

// Whether the range is usable: the squares of its ends must be finite in float, and there must be
// float values between its ends.
bool is_valid_heatmap_range(double min, double max);

// Throws an InputError that names `place` if a channel that the quantity needs is missing.
void check_heatmap_channels(const std::string& place, const HeatmapQuantity& quantity,
                            std::span<const std::string> channels);

// A .png or .jpg file has the picture with its legend. An .exr file ignores the style; it has the
// raw values in one channel named after the quantity, with NaN where they are undefined.
class HeatmapFile {
 public:
  struct Frame {
    int width = 0, height = 0;
    Rect crop;
    std::vector<std::pair<std::string, std::string>> attributes;
  };
  // Opens the file at once, as ExrWriter does, so that an unwritable path fails before rendering.
  // If finish() is not called, no file remains. For `channels`, see QuantityPlane. Throws
  // RenderError.
  HeatmapFile(const HeatmapRequest& request, const HeatmapStyle& style, const Frame& frame,
              std::span<const std::string> channels);

  // See QuantityPlane::write_tile().
  void write_tile(const Rect& rect, std::span<const float> pixels) {
    plane_.write_tile(rect, pixels);
  }
  const std::string& path() const { return path_; }
  // Returns the size of the values: four bytes per pixel, allocated at construction.
  uint64_t bytes() const { return plane_.bytes(); }

  // Draws the picture, writes it and renames the file. Call once, after the last write_tile().
  // Throws RenderError.
  void finish();

 private:
  std::string path_;
  HeatmapStyle style_;
  QuantityPlane plane_;
  std::unique_ptr<ExrWriter> exr_;
  std::optional<AtomicFile> picture_;
};

}  // namespace emberline
