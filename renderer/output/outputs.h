// Writes a frame's files while the frame renders.
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
#include "renderer/output/exposure_hint.h"
#include "renderer/output/frame_channels.h"
#include "renderer/output/heatmap_file.h"
#include "renderer/output/render_options.h"
#include "renderer/output/scene_layers.h"
#include "renderer/output/snapshots.h"

namespace emberline {

// How a frame's files are written. The channels and the camera of the ExrHeader are still empty.
struct OutputSettings : ExrHeader, FrameContents {
  Rect crop;
  DisplaySettings display;
  bool transparent = false;              // PNG gets an alpha channel
  std::vector<HeatmapRequest> heatmaps;  // their channels are in `aovs`
  HeatmapStyle heatmap_style;
  bool is_clamped = false;         // --clamp-indirect
  bool denoise = false;            // files also get the denoised picture
  std::optional<Vec2i> explained;  // --explain
  std::vector<std::string> half;   // layer names
};

// Returns the settings of the frame's files. Their channels include those that the heatmaps need.
OutputSettings output_settings(const RenderOptions& options, const Rect& crop);

// The state that the EXR header records: "emberline:complete" ("true " or "false"),
// "emberline:samples", with --clamp-indirect "emberline:clamped" (the fraction of light that was
// removed), and with --explain kExplanationAttribute. These values are not known when the header is
// written, so the header reserves room for them with blanks.
struct FrameState {
  bool complete = false;
  uint64_t samples = 0;
  double clamped_fraction = 0.0;
  std::string history = {};  // FrameDriver::history()
};

// Returns the header of a whole frame's EXR. Call set_state() before the file is finished. Channels
// named by `--half` become half floats.
ExrHeader frame_header(const OutputSettings& settings, std::vector<PictureChannel> channels,
                       const SceneLayers& layers);
void set_state(const OutputSettings& settings, const FrameState& state, ExrWriter& writer);

// Writes a whole film as an EXR. `values` must be those that FilmTile::resolve() returns.
void write_film_exr(const std::string& path, const AovSet& aovs, int width, int height,
                    const Rect& crop, std::vector<std::pair<std::string, std::string>> attributes,
                    std::vector<float> values);

// Passes finished tiles to all files, including heatmaps. If the frame has `denoising` channels, a
// tile can be resolved only together with the rows around it. The tiles are then stored in a
// scratch file until finish_spooled() is called.
class FrameOutputs final : public RenderSink {
 public:
  // Opens the files at once, so that an unwritable path fails before rendering. `stop` says why the
  // frame was stopped. Throws RenderError for an unwritable path, and UsageError for an unknown
  // display.
  FrameOutputs(const std::vector<std::string>& paths, const OutputSettings& settings,
               const StopRequest& stop);

  // If a file cannot be written (for example because the disk is full), finish() reports this.
  // Throws RenderError once every file has failed, because continuing would be useless.
  void tile_finished(const FilmTile& tile) override;
  PixelStop stop_cause() const override { return stop_.cause(); }

  // Adds the scene's layers and restarts the EXR files with them. Call before the first tile.
  // Throws RenderError.
  void add_scene(const SceneLayers& layers);

  // Call when rendering has ended. After this call, tile_finished() no longer throws when all files
  // have failed.
  void rendering_ended() { rendered_ = true; }
  // Call after the last tile. Writes the tiles from the scratch file, denoised if the settings
  // request it. Runs on the calling thread's TBB arena. finish() reports the files that cannot be
  // written. After a stop request, the remaining tiles are left unfiltered.
  std::optional<DenoiseReport> finish_spooled(const std::stop_token& stop = {});
  // Completes and renames each file, even if other files fail. Writes `state` into the EXR headers.
  void finish(const FrameState& state, WriteAttempts& attempts);

  // Returns the peak film memory for the report: each thread's pixel sums and channels, plus the
  // pictures (.png, .jpg) and heatmaps that are kept until the end.
  uint64_t film_bytes() const;
  std::string display_description() const;
  // Returns a report on each kind of --cryptomatte, for the tiles finished so far.
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
  void write_images(const Rect& tile, const std::vector<float>& rgba);
  void write_denoised(const Rect& tile, const std::vector<float>& pixels);
  bool all_outputs_failed() const;  // every EXR has failed and there is no other output

  const OutputSettings settings_;
  std::deque<ExrOutput> exrs_;  // a deque, so that elements never move
  FrameChannels channels_;
  SceneLayers layers_;
  std::unique_ptr<PixelSpool> spool_;
  std::string spool_failure_;  // empty: the spool is usable
  bool rendered_ = false;
  std::vector<std::unique_ptr<DisplayImageWriter>> images_;
  std::vector<std::unique_ptr<HeatmapFile>> heatmaps_;
  std::shared_ptr<const DisplayTransform> transform_;
  std::optional<ExposureHint> exposure_hint_;  // absent without images
  const StopRequest& stop_;
  mutable std::mutex mutex_;
  std::map<std::thread::id, uint64_t> thread_bytes_;  // peak memory of each thread
};

// Registers the input files that the options name.
void register_inputs(const RenderOptions& options, FileRegister& files);

// Register the files that a frame writes, and those that a whole range writes.
void register_frame_outputs(const RenderOptions& options, FileRegister& files);
void register_run_outputs(const RenderOptions& options, FileRegister& files);

// Throws UsageError if the path, given with -o, has an unknown suffix or if its format cannot store
// a picture of this size.
void check_picture_format(const std::string& path, const Rect& crop);

// Registers all inputs and outputs. Throws UsageError for an unknown suffix, a file named twice, an
// output that would overwrite an input, or a frame too large for its format.
void check_output_paths(const RenderOptions& options, const Rect& crop, FileRegister& files);

}  // namespace emberline
