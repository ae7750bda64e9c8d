// What the report's page shows of the frame: the picture and a map of each quantity that the film
// has channels for. Made only if a page was asked for; a frame that is streamed out bucket by
// bucket is kept nowhere else.
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
#include "renderer/statistics/heatmap_quantity.h"

namespace emberline {

class FilmTile;
struct RenderOptions;

class ReportPictures {
 public:
  // A page needs no more pixels a side; larger frames are averaged over squares of pixels as their
  // tiles come, so that what is kept does not grow with them.
  static constexpr int kMostPixels = 1280;

  // `aovs` are the film's. Throws UsageError for an unknown display or view.
  ReportPictures(const RenderOptions& options, const Rect& crop, const AovSet& aovs);

  // A finished tile within the crop, each pixel once. From any thread.
  void add(const FilmTile& tile);

  // One pixel here is factor x factor of the frame's (fewer at the right and lower edge).
  int factor() const { return factor_; }
  // As displayed; black where no tile came.
  ByteImage picture() const;

  struct Map {
    const HeatmapQuantity* quantity;
    // Means (of errors: root mean squares) of the pixels that have a value; of reasons one pixel's.
    Plane plane;
  };
  std::vector<Map> maps() const;

  // How many of the crop's pixels got so many samples: exact, whatever the factor.
  std::map<uint32_t, uint64_t> pixels_by_samples() const;

  uint64_t bytes() const;

 private:
  struct MapSums {
    const HeatmapQuantity* quantity;
    std::vector<size_t> channels;  // of the film
    std::vector<float> sums;
    std::vector<uint32_t> counts;
  };

  // The value of each map at each of the film's pixels, map by map.
  std::vector<float> mapped(std::span<const float> film) const;

  DisplayTransform transform_;
  Rect crop_;
  int factor_, width_, height_;
  std::vector<std::string> film_channels_;
  std::mutex mutex_;
  std::vector<float> rgb_;       // sums
  std::vector<uint32_t> count_;  // pixels that came
  std::vector<MapSums> maps_;
  std::map<uint32_t, uint64_t> pixels_by_samples_;
};

}  // namespace emberline
