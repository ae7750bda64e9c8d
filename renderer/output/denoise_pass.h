// Denoises a frame band by band. Only one band and its margins are in memory at a time. The result
// is bit-identical to that of denoising the whole frame at once.
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

struct DenoiseReport {
  double error_before = 0.0, error_after = 0.0;  // expected RMS error of the displayed picture
  double unchanged_fraction = 0.0;               // fraction of pixels left unfiltered
  double seconds = 0.0;
  bool stopped = false;  // stopped early; the remaining pixels are unfiltered
  // Average number of frames whose samples a denoised pixel combines; 0 without neighbours.
  double frames = 0.0;
};

// Returns text such as "denoised in 3 s: expected error 0.02 -> 0.004, 12 % of the pixels are
// unchanged".
std::string describe(const DenoiseReport& report);

// Returns the channels that denoise() needs but `channels` lacks.
std::vector<std::string> missing_denoise_channels(std::span<const std::string> channels);
// Returns the channels that denoising a frame reads from earlier and later frames. The denoised
// frame has the channels `channels`, which must include all returned channels.
std::vector<std::string> neighbour_channels(std::span<const std::string> channels);
// Returns the channels that denoising adds: denoised.{R,G,B}, denoised.error and, for each light
// group, denoised.light.NAME.{R,G,B}.
std::vector<std::string> denoise_results(std::span<const std::string> channels);

// Returns the denoised R, G, B and A of `pixels`. In `pixels`, each pixel has the values of
// `channels`, followed by those of denoise_results().
std::vector<float> denoised_rgba(std::span<const float> pixels,
                                 std::span<const std::string> channels);

// Returns an upper bound on the memory that a DenoiseJob needs. `channels` are the channels of a
// film, before the samples that neighbouring pixels share are summed
// (renderer/film/shared_samples.h).
uint64_t denoise_bytes(const Rect& crop, int tile_size, std::span<const std::string> channels,
                       int rows_at_once = 1, size_t neighbours = 0);

// Rows of a frame, from top to bottom.
struct RowSource {
  std::vector<std::string> channels;
  // `read` reads these rows of the crop and stores them in `pixels` as interleaved values. It is
  // called for consecutive ranges of rows, from top to bottom. Every range except the last has a
  // multiple of `rows_at_once` rows.
  int rows_at_once = 1;
  std::function<void(const Rect& rows, std::vector<float>& pixels)> read;
};
// An earlier or later frame of the animation, with the same crop. `rows.channels` are
// neighbour_channels().
struct DenoiseNeighbour {
  int offset = 0;  // 1 is the next frame, -1 the frame before
  RowSource rows;
};

struct DenoiseJob {
  Rect crop;
  RowSource rows;      // its channels must include all that denoise() needs
  int tile_size = 64;  // of the output tiles
  // Earlier and later frames whose samples are combined with those of the denoised frame, sorted by
  // |offset|. A neighbour is used only if all frames between it and the denoised frame are in the
  // list, because motion is followed from one frame to the next.
  std::vector<DenoiseNeighbour> neighbours = {};
  // `write` receives a tile of the crop. Each pixel has the values of `rows.channels`, followed by
  // the denoising results. Any thread may call `write`.
  std::function<void(const Rect& tile, const std::vector<float>& pixels)> write;
  // After a stop request, the remaining rows are left unfiltered.
  std::stop_token stop = {};
};

// Runs on the calling thread's TBB arena, whose size does not affect the bits. Throws what `read`
// and `write` throw.
DenoiseReport denoise_frame(const DenoiseJob& job);
// Like denoise_frame(), but reads the channels of a film. First sums the samples that neighbouring
// pixels share (renderer/film/shared_samples.h).
DenoiseReport denoise_film_rows(DenoiseJob job);

// Like denoise_film_rows(), but for a film whose values are in memory. `write` receives the
// channels of resolved_channel_names(), followed by the results.
DenoiseReport denoise_film(const Rect& crop, int tile_size, std::span<const std::string> channels,
                           std::span<const float> values,
                           std::function<void(const Rect&, const std::vector<float>&)> write,
                           const std::stop_token& stop = {});
// Converts a film's channels to those of a finished frame: sums shared samples and, if `denoises`
// is set, appends the denoising results.
void finish_film(const Rect& crop, int tile_size, bool denoises, std::vector<std::string>& channels,
                 std::vector<float>& values, const std::stop_token& stop);

// A scratch file to which tiles are written and from which rows are read.
class PixelSpool {
 public:
  // Creates the scratch file in the same folder as the output file `beside`. Throws RenderError.
  PixelSpool(const std::string& beside, const Rect& crop, size_t channels)
      : file_(ScratchFile::beside(beside)), crop_(crop), channels_(channels) {}

  // Takes interleaved values. Each pixel must be written only once. Thread-safe. Throws
  // RenderError.
  void write_tile(const Rect& tile, const std::vector<float>& pixels);
  // Pixels that were never written are black.
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
