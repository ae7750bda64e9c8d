// What heatmaps can show: from channels of the film to one number per pixel, and how it is drawn.
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
  std::string_view name;  // "samples"; of the only channel of a file of raw values, too
  std::string_view summary;
  std::string_view title;  // in the picture
  std::string_view unit = {};
  std::optional<Aov> aov = {};             // that must be rendered for it
  std::vector<std::string_view> channels;  // that it is computed from
  // Of a pixel, from the channels in that order: the only one, if nothing else is said. NaN: it has
  // none.
  float (*value)(const float* channels) = [](const float* all) { return all[0]; };
  bool reasons = false;             // PixelStop values, no amounts
  bool of_denoised = false;         // of what `denoise` has made, when the frame is done
  double bright = kBrightQuantile;  // of an automatic range, value_scale.h
  bool rms = false;                 // its root of the mean square says more than its mean
};
// The table behind --heatmap-of, its --help and its error message. The first is the default.
//
// `error` is the expected RMS error of the pixel in the displayed picture (sRGB, [0, 1]), root of
// the mean over R, G and B: sqrt(mean(w v)), v the channel's variance of the mean and w the squared
// slope of the display's curve where the pixel is (display_error.h). In frames by the estimators
// nested and two-stream, and in any with --streams 2, it comes from one difference per pixel, of
// two halves or two streams: single pixels scatter (one degree of freedom), and their RMS, which
// the legend tells, is what the adaptive driver estimates for the whole frame (drivers/adaptive/
// frame_error.h; `error.estimate` of the report), but for light that pixels have missed: that is
// known of the frame, not of a pixel, and is in the report's estimate alone. Else, as in uniform
// frames, samples count as independent: an upper estimate. The curve counts as straight over the
// error, so that a single pixel's may exceed 1. Pixels with fewer than two samples have no value.
std::span<const HeatmapQuantity> heatmap_quantity_table();
// Throws UsageError, which starts with the option's name.
const HeatmapQuantity& find_heatmap_quantity(std::string_view name,
                                             std::string_view option = "`heatmap-of`");

// Why pixels got no more samples; colours of Okabe & Ito 2008, "Color Universal Design", of which
// no two are equally light.
std::span<const Category> stop_categories();

BytePicture draw_quantity(const HeatmapQuantity& quantity, const Plane& plane,
                          const HeatmapStyle& style);

// Gathers one quantity of a frame, tile by tile, from the film's channels.
class QuantityPlane {
 public:
  // `channels` are the names of what write_tile() will bring; missing_channel() must be empty.
  // Pixels that never come are as those of a film without samples: all channels 0.
  QuantityPlane(const HeatmapQuantity& quantity, std::span<const std::string> channels,
                const Rect& crop);

  // The first channel that the quantity needs and that is not among `channels`; empty if none.
  static std::string missing_channel(const HeatmapQuantity& quantity,
                                     std::span<const std::string> channels);

  // Where the channels that the quantity needs are among `channels`, in its own order; nothing if
  // one is missing.
  static std::optional<std::vector<size_t>> find_channels(const HeatmapQuantity& quantity,
                                                          std::span<const std::string> channels);

  // `pixels` holds the channels, interleaved, rows from rect.y0; others may be behind those of each
  // pixel. `rect` lies in the crop. Thread-safe for disjoint rectangles.
  void write_tile(const Rect& rect, std::span<const float> pixels);

  const HeatmapQuantity& quantity() const { return *quantity_; }
  const Plane& plane() const { return plane_; }
  uint64_t bytes() const { return plane_.values.capacity() * sizeof(float); }

 private:
  const HeatmapQuantity* quantity_;
  std::vector<size_t> sources_;  // of quantity_->channels
  Rect crop_;
  Plane plane_;
};

}  // namespace emberline
