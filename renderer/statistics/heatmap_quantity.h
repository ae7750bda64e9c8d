// The quantities that heatmaps can show: how to compute them from the film's channels, and how to
// draw them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/core/rect.h"
#include "renderer/film/channels.h"
#include "renderer/statistics/heatmap.h"
#include "renderer/statistics/plane.h"

namespace emberline {

struct HeatmapQuantity {
  std::string_view name;  // such as "samples"; also the channel's name in a file of raw values
  std::string_view summary;
  std::string_view title;  // in the picture
  std::string_view unit = {};
  std::optional<Aov> aov = {};             // the AOV that must be rendered for it
  std::vector<std::string_view> channels;  // the channels that it is computed from
  // Computes a pixel's value from the values of `channels`, in that order. By default, returns that
  // of the first channel. NaN: no value.
  float (*value)(const float* channels) = [](const float* all) { return all[0]; };
  std::string_view note = {};       // the last text of the legend
  bool is_categorical = false;      // the values are PixelStop values instead of amounts
  bool needs_denoised = false;      // uses the result of `denoise` for a finished frame
  double bright = kBrightQuantile;  // for automatic_range() (value_scale.h)
  bool rms = false;                 // the legend also shows the RMS
};
// The table behind --heatmap-of, its --help and its error message. The first row is the default.
//
// `error` is the expected RMS error of the pixel in the displayed picture (sRGB, [0, 1]). It is the
// root mean square over R, G and B, sqrt(mean(w v)), where v is the variance of the channel's mean
// and w is the squared slope of the display curve at the pixel's value (display_error.h). With the
// estimators nested and two-stream, and with --streams 2, v is estimated from a single difference
// per pixel, between two halves or two streams (one degree of freedom), so the values of pixels
// scatter. The RMS over all pixels, which the legend shows, is then the adaptive driver's estimate
// for the whole frame (drivers/adaptive/frame_error.h; `error.estimate` in the report), except that
// only the report includes light that pixels have missed. In all other frames, such as uniform
// ones, v assumes independent samples, which overestimates the error. The display curve is
// linearised, so a pixel's error may exceed 1. Pixels with fewer than two samples have no value.
std::span<const HeatmapQuantity> heatmap_quantity_table();
// Throws UsageError for an unknown name; the message calls the option `option`.
const HeatmapQuantity& find_heatmap_quantity(std::string_view name,
                                             std::string_view option = "`heatmap-of`");

// The reasons why pixels got no more samples, for draw_category_map(). The colours are from Okabe &
// Ito 2008, "Color Universal Design"; no two have the same lightness.
std::span<const Category> stop_categories();

BytePicture draw_quantity(const HeatmapQuantity& quantity, const Plane& plane,
                          const HeatmapStyle& style);

// Computes one quantity of a frame from the film's channels, tile by tile.
class QuantityPlane {
 public:
  static constexpr size_t kMaxChannels = 8;  // per quantity

  // `channels` are the names of the channels that write_tile() receives. They must include all that
  // the quantity needs (see missing_channel()). Pixels that are never written are treated as pixels
  // without samples, whose channels are all 0.
  QuantityPlane(const HeatmapQuantity& quantity, std::span<const std::string> channels,
                const Rect& crop);

  // Returns the first channel that the quantity needs but `channels` lacks; empty if there is none.
  static std::string missing_channel(const HeatmapQuantity& quantity,
                                     std::span<const std::string> channels);

  // Returns the indices in `channels` of the quantity's channels, in the quantity's order; empty if
  // one is missing.
  static std::optional<std::vector<size_t>> find_channels(const HeatmapQuantity& quantity,
                                                          std::span<const std::string> channels);

  // `pixels` contains the channels interleaved, in rows from rect.y0; each pixel may have more
  // values after them. `rect` must be in the crop. Thread-safe for disjoint rectangles.
  void write_tile(const Rect& rect, std::span<const float> pixels);

  const HeatmapQuantity& quantity() const { return *quantity_; }
  const Plane& plane() const { return plane_; }
  uint64_t bytes() const { return plane_.values.capacity() * sizeof(float); }

 private:
  const HeatmapQuantity* quantity_;
  std::vector<size_t> sources_;  // indices of quantity_->channels
  Rect crop_;
  Plane plane_;
};

}  // namespace emberline
