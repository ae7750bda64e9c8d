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
  std::optional<Aov> aov = {};             // the AOV that the quantity requires
  std::vector<std::string_view> channels;  // the channels from which it is computed
  // Computes a pixel's value from the values of its channels, in the order of `channels`. By
  // default, returns the value of the first channel. NaN means that the pixel has no value.
  float (*value)(const float* channels) = [](const float* all) { return all[0]; };
  std::string_view note = {};  // the last text of the legend
  // Returns the categories, if the values are categories instead of amounts.
  std::vector<Category> (*categories)(const HeatmapStyle& style) = nullptr;
  bool needs_denoised = false;      // uses the result of `denoise` for a finished frame
  double bright = kBrightQuantile;  // for automatic_range() (value_scale.h)
  bool rms = false;                 // the legend also shows the RMS
};
// The table from which --heatmap-of, its help and its error message are made. The first row is the
// default.
//
// `error` is the expected RMS error of the pixel in the displayed picture (sRGB, [0, 1]). It is
// sqrt(mean(w v)), where the mean is over R, G and B, v is the variance of the mean of the
// channel's samples, and w is the squared slope of the display curve at the pixel's value
// (display_error.h). With the estimators nested and two-stream, and with --streams 2, v is
// estimated from a single difference per pixel, between two halves or two streams. This has one
// degree of freedom, so the values of single pixels are noisy. The legend shows the RMS over all
// pixels. With these estimators or --streams 2, it equals the adaptive driver's estimate for the
// whole frame (drivers/adaptive/frame_error.h; `error.estimate` in the report), but only the report
// includes light that pixels have missed. For all other frames, such as uniform ones, v is computed
// as if samples were independent, which overestimates the error. The display curve is linearised,
// so a pixel's error may exceed 1. Pixels with fewer than two samples have no value.
std::span<const HeatmapQuantity> heatmap_quantity_table();
// Throws UsageError for an unknown name; the message calls the option `option`.
const HeatmapQuantity& find_heatmap_quantity(std::string_view name,
                                             std::string_view option = "`heatmap-of`");

// Returns the reasons why pixels got no more samples, as categories for draw_category_map(). The
// colours are from Okabe & Ito 2008, "Color Universal Design". All have different lightness.
std::span<const Category> stop_categories();

BytePicture draw_quantity(const HeatmapQuantity& quantity, const Plane& plane,
                          const HeatmapStyle& style);

// Returns the channels of `judge` as categories, with the names in `style`.
std::vector<Category> judged_categories(const HeatmapStyle& style);

// Computes one quantity of a frame from the film's channels, tile by tile.
class QuantityPlane {
 public:
  static constexpr size_t kMaxChannels = 8;  // per quantity

  // `channels` are the names of the channels that write_tile() receives. They must include all
  // channels that the quantity needs (see missing_channel()). Pixels that are never written count
  // as pixels without samples: all their channels are 0.
  QuantityPlane(const HeatmapQuantity& quantity, std::span<const std::string> channels,
                const Rect& crop);

  // Returns the first channel that the quantity needs but `channels` lacks; empty if there is none.
  static std::string missing_channel(const HeatmapQuantity& quantity,
                                     std::span<const std::string> channels);

  // Returns the indices in `channels` of the quantity's channels, in the quantity's order; empty if
  // one is missing.
  static std::optional<std::vector<size_t>> find_channels(const HeatmapQuantity& quantity,
                                                          std::span<const std::string> channels);

  // `pixels` has the interleaved channels of the pixels in `rect`, row by row from the top. Each
  // pixel may have more values after its channels. `rect` must be in the crop. Thread-safe for
  // disjoint rectangles.
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
