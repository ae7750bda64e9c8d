// The channels that a frame has in files and in the library's pictures. The channels of the film
// come first. The channels whose names come from the scene (light groups and mattes) follow.
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

// Returns the channels of a tile with these light-group layers.
std::vector<PictureChannel> tile_channels(const FrameContents& contents,
                                          const std::vector<std::string>& light_layers);
// Returns the channels of a finished frame: those of resolved_channel_names() and, if `denoised` is
// set, those of denoise_results(). In a finished frame, the samples that neighbouring pixels share
// are already summed (renderer/film/shared_samples.h).
std::vector<PictureChannel> finished_channels(const std::vector<PictureChannel>& of_tile,
                                              bool denoised);

class FrameChannels {
 public:
  explicit FrameChannels(const FrameContents& contents);

  // Adds the scene's layers. Call once the scene is loaded, before the first tile.
  void add_scene(const SceneLayers& layers);

  // The channels of a tile; see tile_channels().
  const std::vector<PictureChannel>& list() const { return list_; }
  // Writes the values of the tile's channels to `pixels`, interleaved, row by row. Thread-safe.
  void resolve(const FilmTile& tile, std::vector<float>& pixels);
  // Returns a report on each kind of matte, for the tiles resolved so far.
  std::vector<CryptomatteReport> mattes() const;

 private:
  const FrameContents contents_;
  const size_t film_channel_count_;  // number of channels from the film
  std::vector<PictureChannel> list_;
  mutable std::mutex mutex_;
  std::vector<CryptomatteReport> mattes_;
};

}  // namespace emberline
