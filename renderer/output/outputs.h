// The files a frame is written to while it renders.
#pragma once

#include <atomic>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "io/display/display.h"
#include "io/exr/writer.h"
#include "io/files/register.h"
#include "io/files/write_attempts.h"
#include "renderer/core/rect.h"
#include "renderer/engine/render_sink.h"
#include "renderer/engine/stop_request.h"
#include "renderer/output/denoise_pass.h"
#include "renderer/output/frame_channels.h"
#include "renderer/output/heatmap_file.h"
#include "renderer/output/render_options.h"
#include "renderer/output/scene_layers.h"
#include "renderer/output/snapshots.h"

namespace emberline {

// How the files of a frame are written. The header is for EXR files, without channels and camera.
struct OutputSettings : ExrHeader, FrameContents {
  Rect crop;
  DisplaySettings display;
  bool transparent = false;              // PNG gets an alpha channel
  std::vector<HeatmapRequest> heatmaps;  // whose channels are among `aovs`
  HeatmapStyle heatmap_style;
  bool clamps = false;            // --clamp-indirect
  bool denoise = false;           // the files get the denoised picture, too
  std::vector<std::string> half;  // layers
};

// With the channels that the heatmaps need.
OutputSettings output_settings(const RenderOptions& options, const Rect& crop);

// What an EXR's header says of its frame: "emberline:complete" is "true " or "false", and
// "emberline:samples" their number, with blanks behind it; with --clamp-indirect
// "emberline:clamped" is the share of the light that it took. It is known when the header has long
// been written, so there is room for it.
struct FrameState {
  bool complete = false;
  uint64_t samples = 0;
  double clamped_share = 0.0;
};

// The header of a whole frame's EXR, whose state is set before it is finished. Channels that
// `--half` names become half floats.
ExrHeader frame_header(const OutputSettings& settings, std::vector<PictureChannel> channels,
                       const SceneLayers& layers);
void set_state(const OutputSettings& settings, const FrameState& state, ExrWriter& writer);

// Writes a whole film as an EXR. `values`: its channels as FilmTile::resolve() gives them.
void write_film_exr(const std::string& path, const AovSet& aovs, int width, int height,
                    const Rect& crop, std::vector<std::pair<std::string, std::string>> attributes,
                    std::vector<float> values);

// Passes finished tiles on to every file, heatmaps included. Those of a frame with the channels of
// `denoising` wait in a scratch file until finish_spooled() has the rows around them.
class FrameOutputs final : public RenderSink {
 public:
  // Opens the files at once, so that a path that cannot be written is known before the render and
  // not after it. Throws RenderError for an unwritable path, UsageError for an unknown display.
  // `stop` is asked why the frame was cut short.
  FrameOutputs(const std::vector<std::string>& paths, const OutputSettings& settings,
               const StopRequest& stop);

  // A file that cannot be written (a full disk) is named by finish(); throws RenderError when it is
  // the last one, so that nobody renders for nothing.
  void tile_finished(const FilmTile& tile) override;
  PixelStop stop_cause() const override { return stop_.cause(); }

  // Adds what is known since the scene is: the EXR files are begun anew with it. To be called
  // before the first tile. Throws RenderError for a file that cannot be.
  void add_scene(const SceneLayers& layers);

  // From now on tiles are those of a frame that is rendered, and that is not given up any more when
  // no file can be written: see tile_finished.
  void rendering_ended() { rendered_ = true; }
  // Once all tiles have come: writes those that wait, denoised if the settings ask for it, on the
  // calling thread's TBB arena. A file that cannot be written is named by finish(). A stop leaves
  // what is not denoised yet as it is.
  std::optional<DenoiseReport> finish_spooled(const std::stop_token& stop = {});
  // Completes and renames the files, each for itself. What became of the frame goes into the EXR's
  // header.
  void finish(const FrameState& state, WriteAttempts& attempts);

  // The most that the film held, for the report: each thread's pixel sums and channels, and the
  // pictures (.png, .jpg) and heatmaps that are kept until the end.
  uint64_t film_bytes() const;
  std::string display_description() const;
  // By kind of --cryptomatte, of the tiles so far.
  std::vector<CryptomatteReport> cryptomattes() const { return channels_.mattes(); }

 private:
  struct ExrOutput {
    std::string path;
    std::unique_ptr<ExrWriter> writer;
    std::atomic<bool> failed{false};
  };
  void begin(ExrOutput& exr);
  void begin_spool();
  void spool(const Rect& tile, const std::vector<float>& pixels);
  void write(ExrOutput& exr, const Rect& tile, const std::vector<float>& pixels);
  DenoiseReport denoise(const std::stop_token& stop);
  void write_tiles();
  void write_denoised(const Rect& tile, const std::vector<float>& pixels);
  bool nothing_left() const;  // to write a tile to

  const OutputSettings settings_;
  std::deque<ExrOutput> exrs_;  // of which none moves
  FrameChannels channels_;
  SceneLayers layers_;
  std::unique_ptr<PixelSpool> spool_;
  std::string spool_failure_;  // why it is of no use any more
  bool rendered_ = false;
  std::vector<std::unique_ptr<DisplayImageWriter>> images_;
  std::vector<std::unique_ptr<HeatmapFile>> heatmaps_;
  std::shared_ptr<const DisplayTransform> transform_;
  const StopRequest& stop_;
  mutable std::mutex mutex_;
  std::map<std::thread::id, uint64_t> thread_bytes_;  // at most, of each thread that brought a tile
};

// Enters the files that the options name for reading.
void register_inputs(const RenderOptions& options, FileRegister& files);

// Enters the files that they name for writing: of one frame, and of all frames of a range together.
void register_frame_outputs(const RenderOptions& options, FileRegister& files);
void register_run_outputs(const RenderOptions& options, FileRegister& files);

// Throws UsageError for an -o with an unknown suffix, or a format that holds no such picture.
void check_picture_format(const std::string& path, const Rect& crop);

// Enters what the options read and write. Throws UsageError for what is wrong with the names alone:
// an unknown suffix, one file named twice, an input that would be overwritten, a frame larger than
// the format holds.
void check_output_paths(const RenderOptions& options, const Rect& crop, FileRegister& files);

}  // namespace emberline
