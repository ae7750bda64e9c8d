// The channels of a frame as its files and the library's pictures have them: the film's, then those
// of its light groups and of its mattes.
#pragma once

#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "io/exr/writer.h"
#include "renderer/film/film.h"
#include "renderer/output/cryptomatte_layers.h"
#include "renderer/output/scene_layers.h"

namespace emberline {

std::vector<ExrChannel> exr_channels(const AovSet& aovs);
// The same as with_shared_sums() has them, of a frame that is whole.
std::vector<ExrChannel> summed_channels(const std::vector<ExrChannel>& channels);
std::vector<std::string> names_of(const std::vector<ExrChannel>& channels);

class FrameChannels {
 public:
  FrameChannels(const AovSet& aovs, bool light_groups, std::vector<CryptomatteKind> mattes,
                int matte_levels);

  // Once the scene is known, before the first tile.
  void add_scene(const SceneLayers& layers);

  // Of a tile. Of a whole frame: summed_channels() of it.
  const std::vector<ExrChannel>& list() const { return list_; }
  // Puts the values of light groups and mattes behind those of FilmTile::resolve(). Any thread.
  void append(const FilmTile& tile, std::vector<float>& pixels);
  // By kind, of the tiles so far.
  std::vector<CryptomatteReport> mattes() const;

 private:
  const AovSet aovs_;
  const bool light_groups_;
  const std::vector<CryptomatteKind> matte_kinds_;
  const int matte_levels_;
  std::vector<ExrChannel> list_;
  mutable std::mutex mutex_;
  std::vector<CryptomatteReport> mattes_;
};

// Puts the values of a tile's pixels, interleaved, into those of a frame that holds it. Threads may
// do so side by side for tiles that have no pixel in common.
void put_tile(const Rect& tile, std::span<const float> pixels, const Rect& frame,
              std::span<float> values);

}  // namespace emberline
