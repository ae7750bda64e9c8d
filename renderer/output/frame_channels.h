// The channels of a frame as its files and the library's pictures have them: the film's, then those
// whose names the scene gives, of its light groups and its mattes.
#pragma once

#include <mutex>
#include <string>
#include <vector>

#include "renderer/film/film.h"
#include "renderer/output/cryptomatte_layers.h"
#include "renderer/output/scene_layers.h"

namespace emberline {

struct FrameContents {
  AovSet aovs;
  bool light_groups = false;
  std::vector<CryptomatteKind> cryptomattes;
  int cryptomatte_levels = 0;
};

// The channels of a tile, with these layers of light groups.
std::vector<PictureChannel> tile_channels(const FrameContents& contents,
                                          const std::vector<std::string>& light_layers);
// What they become in a frame that is whole: summed up as with_shared_sums() has them and, if it is
// `denoised`, with denoise_results() behind them.
std::vector<PictureChannel> finished_channels(const std::vector<PictureChannel>& of_tile,
                                              bool denoised);

class FrameChannels {
 public:
  explicit FrameChannels(const FrameContents& contents);

  // Once the scene is known, before the first tile.
  void add_scene(const SceneLayers& layers);

  // As tile_channels() has them.
  const std::vector<PictureChannel>& list() const { return list_; }
  // Their values, interleaved, rows from the tile's first. Any thread.
  void resolve(const FilmTile& tile, std::vector<float>& pixels);
  // By kind, of the tiles so far.
  std::vector<CryptomatteReport> mattes() const;

 private:
  const FrameContents contents_;
  const size_t of_film_;  // channels
  std::vector<PictureChannel> list_;
  mutable std::mutex mutex_;
  std::vector<CryptomatteReport> mattes_;
};

}  // namespace emberline
