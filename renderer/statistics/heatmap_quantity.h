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
  std::string_view name;  // "samples"; also the channel name of a file of raw values
  std::string_view summary;
  std::string_view title;  // in the picture
  std::string_view unit = {};
  std::optional<Aov> aov = {};             // the AOV that must be rendered for it
  std::vector<std::string_view> channels;  // the channels that it is computed from
  // A pixel's value from `channels`, in that order; by default the only channel. NaN: no value.
  float (*value)(const float* channels) = [](const float* all) { return all[0]; };
  std::string_view note = {};       // the last text of the legend
  bool is_categorical = false;      // PixelStop values instead of amounts
  bool needs_denoised = false;      // uses the result of `denoise` for a finished frame
  double bright = kBrightQuantile;  // for automatic_range() (value_scale.h)
  bool rms = false;                 // the legend also shows the RMS
};
// The table behind --heatmap-of, its --help and its error message. The first row is the default.
//
// `error` is the expected RMS error of the pixel in the displayed picture (sRGB, [0, 1]), root mean
// square over R, G and B: sqrt(mean(w v)) with v the variance of the channel's mean and w the
// squared slope of the display curve at the pixel's value (display_error.h). With the estimators
// nested and two-stream, and with --streams 2, v comes from a single difference per pixel, between
// two halves or two streams (one degree of freedom), so pixels scatter. The RMS of all pixels,
// shown in the legend, is the adaptive driver's estimate for the whole frame
// (drivers/adaptive/frame_error.h; `error.estimate` of the report), except that only the report
// includes light that pixels have missed. Otherwise, as in uniform frames, samples are assumed to
// be independent, which is an upper estimate. The display curve is linearised, so a pixel's error
// may exceed 1. Pixels with fewer than two samples have no value.
std::span<const HeatmapQuantity> heatmap_quantity_table();
// Throws UsageError for an unknown name; the message calls the option `option`.
const HeatmapQuantity& find_heatmap_quantity(std::string_view name,
                                             std::string_view option = "`heatmap-of`");

// The reasons why pixels got no more samples. The colours are from Okabe & Ito 2008, "Color
// Universal Design"; no two have the same lightness.
std::span<const Category> stop_categories();

BytePicture draw_quantity(const HeatmapQuantity& quantity, const Plane& plane,
                          const HeatmapStyle& style);

// Computes one quantity of a frame from the film's channels, tile by tile.
class QuantityPlane {
 public:
  static constexpr size_t kMaxChannels = 8;  // per quantity

  // `channels` are the names of the channels that write_tile() receives; missing_channel() must
  // return an empty name for them. Pixels that are never written are treated as pixels without
  // samples, whose channels are all 0.
  QuantityPlane(const HeatmapQuantity& quantity, std::span<const std::string> channels,
                const Rect& crop);

  // The first channel that the quantity needs and `channels` lacks; empty if there is none.
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
