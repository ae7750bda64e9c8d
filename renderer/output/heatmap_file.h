// Heatmaps as files: of a frame while it renders, and of the channels of a picture.
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
// The n-th --heatmap-of belongs to the n-th --heatmap; those left are of samples. Throws UsageError
// for an unknown quantity and for a style that does not fit.
std::vector<HeatmapRequest> heatmap_requests(const RenderOptions& options);

// Throws UsageError, which starts with the option's name, for an unknown suffix and for a picture
// too large for its format.
void check_heatmap_format(const std::string& option, const std::string& path, const Rect& crop);

// Throws UsageError for a range or a logarithmic scale that the quantities have no use for.
void check_heatmap_style(const HeatmapStyle& style,
                         std::span<const HeatmapQuantity* const> quantities);

// Whether the ends of a range are of use: squares stay finite in float, and steps between them are
// told apart.
bool is_heatmap_range(double least, double most);

// Throws InputError that names `place` where the quantity needs a channel that is not there.
void check_heatmap_channels(const std::string& place, const HeatmapQuantity& quantity,
                            std::span<const std::string> channels);

// .png and .jpg: the picture with its legend. .exr: the values as they are, in one channel named as
// the quantity, NaN where there is none; of the style nothing counts.
class HeatmapFile {
 public:
  struct Frame {
    int width = 0, height = 0;
    Rect crop;
    std::vector<std::pair<std::string, std::string>> attributes;
  };
  // Opens the file, as ExrWriter does: a path that cannot be written is known before rendering, and
  // without finish() nothing is left behind. `channels`: see QuantityPlane. Throws RenderError.
  HeatmapFile(const HeatmapRequest& request, const HeatmapStyle& style, const Frame& frame,
              std::span<const std::string> channels);

  // As QuantityPlane's.
  void write_tile(const Rect& rect, std::span<const float> pixels) {
    plane_.write_tile(rect, pixels);
  }
  const std::string& path() const { return path_; }
  // Held from construction on: four bytes a pixel.
  uint64_t bytes() const { return plane_.bytes(); }

  // Draws, writes and renames. Call once, when no thread writes any more. Throws RenderError.
  void finish();

 private:
  std::string path_;
  HeatmapStyle style_;
  QuantityPlane plane_;
  std::unique_ptr<ExrWriter> exr_;
  std::optional<AtomicFile> picture_;
};

}  // namespace emberline
