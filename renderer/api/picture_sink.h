// Collects finished tiles in a picture with the channels of the command's EXR.
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "renderer/api/emberline.h"
#include "renderer/engine/render_sink.h"
#include "renderer/output/frame_channels.h"
#include "renderer/output/outputs.h"

namespace emberline::api {

class PictureSink : public RenderSink {
 public:
  PictureSink(const OutputSettings& settings, const SceneLayers& layers);

  void tile_finished(const FilmTile& tile) override;

  // Call this once, after the last tile. Combines the samples that neighbouring pixels share, and
  // denoises the picture if the settings ask for it. A stop request ends the denoising and leaves
  // the rest of the picture unfiltered. Uses the calling thread's TBB arena.
  Picture finish(const std::stop_token& stop);

  // Returns an upper bound on the sink's memory for a frame with these settings, excluding
  // denoise_bytes().
  static uint64_t bytes(const OutputSettings& settings, const SceneLayers& layers);

 private:
  const OutputSettings settings_;
  FrameChannels channels_;
  std::vector<std::string> names_;  // channel names of a tile
  Picture picture_;
};

}  // namespace emberline::api
