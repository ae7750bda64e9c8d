// Finished tiles into a picture with the channels that the command's EXR has.
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

  // After the last tile, once, on the calling thread's TBB arena: what the pixels around a pixel
  // counted for it is summed up, and the picture is denoised if the settings ask for it. What is
  // not denoised when a stop is requested stays as it is.
  Picture finish(const std::stop_token& stop);

  // An upper bound of what the sink holds for such a frame, excluding denoise_bytes().
  static uint64_t bytes(const OutputSettings& settings, const SceneLayers& layers);

 private:
  const OutputSettings settings_;
  FrameChannels channels_;
  std::vector<std::string> names_;  // of a tile's channels
  Picture picture_;
};

}  // namespace emberline::api
