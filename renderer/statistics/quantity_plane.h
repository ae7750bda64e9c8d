// Gathers one quantity of a frame, tile by tile, from the film's channels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/core/rect.h"
#include "renderer/statistics/heatmap_quantity.h"
#include "renderer/statistics/plane.h"

namespace emberline {

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

  // `pixels` holds rect.area() x channels floats, interleaved, rows from rect.y0; `rect` lies in
  // the crop. Thread-safe for disjoint rectangles.
  void write_tile(const Rect& rect, std::span<const float> pixels);

  const HeatmapQuantity& quantity() const { return *quantity_; }
  const Plane& plane() const { return plane_; }
  uint64_t bytes() const { return plane_.values.capacity() * sizeof(float); }

 private:
  const HeatmapQuantity* quantity_;
  size_t channel_count_;
  std::vector<size_t> sources_;  // of quantity_->channels
  Rect crop_;
  Plane plane_;
};

}  // namespace emberline
