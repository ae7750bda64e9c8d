// Collects the pictures of the report page: the frame, and a map of each quantity for which the
// film has channels. Does so during the render, because a frame that is written bucket by bucket is
// never in memory as a whole. Used only if a page was requested.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "io/display/display.h"
#include "io/image/output.h"
#include "renderer/core/rect.h"
#include "renderer/film/channels.h"
#include "renderer/output/render_options.h"
#include "renderer/output/scaled_picture.h"
#include "renderer/statistics/heatmap_quantity.h"

namespace emberline {

class FilmTile;
struct RenderOptions;

class ReportPictures {
 public:
  // Upper limit on the width and height of a picture. Larger frames are averaged over squares of
  // pixels as tiles arrive, so memory does not grow with the frame.
  static constexpr int kMaxPixels = 1280;

  // `aovs` are the channels of the film. Throws UsageError for an unknown display or view.
  ReportPictures(const RenderOptions& options, const Rect& crop, const AovSet& aovs);

  // Adds a finished tile, which must be within the crop. Each pixel must be added only once.
  // Thread-safe.
  void add(const FilmTile& tile);

  // One pixel of these pictures covers factor x factor pixels of the frame (fewer at the right and
  // lower edges).
  int factor() const { return picture_.factor(); }
  // Returns the frame as display values. Pixels for which no tile was added are black.
  ByteImage picture() const { return picture_.display(transform_); }

  struct Map {
    const HeatmapQuantity* quantity;
    // A value is the mean over the pixels of the frame that have a value. For errors, it is the
    // root mean square; for stop reasons, it is the value of a single pixel.
    Plane plane;
  };
  std::vector<Map> maps() const;
  // As in HeatmapStyle.
  const std::vector<std::string>& judged() const { return judged_; }

  // Returns how many pixels of the crop have each sample count. This is exact for every factor().
  std::map<uint32_t, uint64_t> pixels_by_samples() const;

  uint64_t bytes() const;

 private:
  struct MapSums {
    const HeatmapQuantity* quantity;
    std::vector<size_t> channels;  // film channels
    std::vector<float> sums;
    std::vector<uint32_t> counts;
  };

  // Returns the value of each map at each pixel of the film, map by map.
  std::vector<float> evaluate_maps(std::span<const float> film) const;

  DisplayTransform transform_;
  Rect crop_;
  std::vector<std::string> film_channels_, judged_;
  std::mutex mutex_;
  ScaledPicture picture_;
  std::vector<MapSums> maps_;
  std::map<uint32_t, uint64_t> pixels_by_samples_;
};

}  // namespace emberline
