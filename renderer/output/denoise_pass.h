// A frame through denoise(), a band of rows after another: what is held in memory is a band with
// the rows around it, and not the frame. The bits are those of the whole.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "io/files/atomic_file.h"
#include "renderer/core/rect.h"

namespace emberline {

// The result of denoising a frame.
struct DenoiseReport {
  double error_before = 0.0, error_after = 0.0;  // expected RMS error of the displayed picture
  double kept_share = 0.0;                       // of the pixels, that are as they were
  double seconds = 0.0;
  bool stopped = false;  // before its end: the rest of the picture is as it was
};

// "denoised in 3 s: expected error 0.02 -> 0.004, 12 % of the pixels left as they were"
std::string describe(const DenoiseReport& report);

// The channels that denoise() needs and that are not among these; empty: there are all.
std::vector<std::string> missing_denoise_channels(std::span<const std::string> channels);
// The channels that it makes from these: denoised.{R,G,B}, denoised.error, and of each light group
// denoised.light.NAME.{R,G,B}.
std::vector<std::string> denoise_results(std::span<const std::string> channels);

// R G B A as a picture shows it of pixels with the results of these channels behind them.
std::vector<float> denoised_rgba(std::span<const float> pixels,
                                 std::span<const std::string> channels);

// The most memory that such a job takes; `channels` are a film's, whose rows are summed up first.
uint64_t denoise_bytes(const Rect& crop, int tile_size, std::span<const std::string> channels,
                       int rows_at_once = 1);

struct DenoiseJob {
  Rect crop;
  std::vector<std::string> channels;  // of the pixels, none missing
  int tile_size = 64;                 // of what it hands on
  // Fills these rows of the crop, interleaved: one after another, each once. A multiple of
  // `rows_at_once` of them, but for the last.
  int rows_at_once = 1;
  std::function<void(const Rect& rows, std::vector<float>& pixels)> read;
  // Takes a tile of the crop: its channels and, behind those of each pixel, the results. Any
  // thread.
  std::function<void(const Rect& tile, const std::vector<float>& pixels)> write;
  // A request leaves the rows that are not filtered yet as they are.
  std::stop_token stop = {};
};

// On the calling thread's TBB arena; the bits do not depend on it. Throws what read and write
// throw.
DenoiseReport denoise_frame(const DenoiseJob& job);
// Denoises a frame whose `channels` and `read` are those of its films: sums the shares of
// neighbouring pixels up on the way (renderer/film/shared_samples.h).
DenoiseReport denoise_films(DenoiseJob job);

// The same of a film's channels that are all in memory: what pixels count for each other is summed
// up on the way, so `write` gets channels as with_shared_sums() has them.
DenoiseReport denoise_film(const Rect& crop, int tile_size, std::span<const std::string> channels,
                           std::span<const float> values,
                           std::function<void(const Rect&, const std::vector<float>&)> write,
                           const std::stop_token& stop = {});
// A film's channels become those of a finished frame: summed up and, if it `denoises`, with the
// results behind them.
void finish_film(const Rect& crop, int tile_size, bool denoises, std::vector<std::string>& channels,
                 std::vector<float>& values, const std::stop_token& stop);

// Tiles in, rows out, by way of a scratch file.
class PixelSpool {
 public:
  // Beside a file that is to be written. Throws RenderError.
  PixelSpool(const std::string& beside, const Rect& crop, size_t channels)
      : file_(ScratchFile::beside(beside)), crop_(crop), channels_(channels) {}

  // Interleaved. Any thread, each pixel once. Throws RenderError.
  void write_tile(const Rect& tile, const std::vector<float>& pixels);
  // Black where no tile came.
  void read_rows(const Rect& rows, std::vector<float>& pixels) const;

 private:
  uint64_t offset_of(int x, int y) const {
    return crop_.index_of(x, y) * channels_ * sizeof(float);
  }

  ScratchFile file_;
  const Rect crop_;
  const size_t channels_;
};

}  // namespace emberline
