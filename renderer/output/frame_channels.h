// The channels of a frame in files and in the library's pictures: the film's, then those named by
// the scene (light groups and mattes).
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

// Channels of a tile with these light-group layers.
std::vector<PictureChannel> tile_channels(const FrameContents& contents,
                                          const std::vector<std::string>& light_layers);
// Channels of a finished frame: shared samples summed as in resolved_channel_names() and, if
// `denoised`, followed by denoise_results().
std::vector<PictureChannel> finished_channels(const std::vector<PictureChannel>& of_tile,
                                              bool denoised);

class FrameChannels {
 public:
  explicit FrameChannels(const FrameContents& contents);

  // Call once the scene is loaded, before the first tile.
  void add_scene(const SceneLayers& layers);

  // As tile_channels().
  const std::vector<PictureChannel>& list() const { return list_; }
  // Resolves the tile's channels, interleaved, row by row. Any thread.
  void resolve(const FilmTile& tile, std::vector<float>& pixels);
  // Per kind, over the tiles so far.
  std::vector<CryptomatteReport> mattes() const;

 private:
  const FrameContents contents_;
  const size_t film_channel_count_;  // number of film channels
  std::vector<PictureChannel> list_;
  mutable std::mutex mutex_;
  std::vector<CryptomatteReport> mattes_;
};

}  // namespace emberline
