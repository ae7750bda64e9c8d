// The subcommands: what each can be told, and the function that does it. That of the window is in
// renderer/window/view_command.h.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/display/display.h"
#include "renderer/app/farm/slurm.h"
#include "renderer/core/rect.h"
#include "renderer/engine/frame_settings.h"
#include "renderer/engine/run_limits.h"
#include "renderer/output/render_options.h"
#include "renderer/statistics/heatmap_quantity.h"
#include "renderer/statistics/study/options.h"

namespace emberline {

// `emberline render`: a scene file becomes pictures and a report.
// Returns the exit code. Throws EmberlineError.
int run_render(const RenderOptions& options);

// `render --frames`: one frame after another, with one report of all.
// Goes on behind a frame that fails, unless --stop-on-error says otherwise. Returns the highest of
// the frames' exit codes. Throws EmberlineError for what is wrong with all of them: the command
// line, or the scene.
int run_range(const RenderOptions& options, const std::vector<int>& frames);

// `emberline info`: what is in a scene, which features it needs, what is approximated or ignored;
// or which channels pictures can have.
struct InfoOptions {
  std::string scene;      // unless `channels`
  bool channels = false;  // the table of channels instead
  bool json = false;
  FrameSettings settings;  // how it is loaded
  LimitOptions limits;
};

// Prints to stdout. Returns the exit code. Throws EmberlineError.
int run_info(const InfoOptions& options);

// emberline heatmap: a picture of one of a rendered frame's own numbers.
struct HeatmapOptions {
  std::string image;  // an .exr that `emberline render` wrote
  std::string output;
  std::string quantity;  // one of heatmap_quantity_table()
  HeatmapStyle style;
  LimitOptions limits;
};

// Writes what `render --heatmap` would have written for the frame: the same pixels.
// Returns kExitDone. Throws UsageError (names, style, suffix, output and input one file),
// InputError (unreadable, channels missing), RenderError (cannot write).
int run_heatmap(const HeatmapOptions& options);

// emberline compare: how far one picture is from another.
struct CompareOptions {
  std::string image;
  std::string reference;
  bool json = false;       // to stdout, instead of a table
  std::string difference;  // empty: none; .png/.jpg: FLIP in false colour; .exr: image - reference
  float exposure = 0.0f;   // stops, for PSNR, SSIM, FLIP and the FLIP picture
  LimitOptions limits;
};

// Reads both pictures (whatever OpenImageIO reads; 8-bit ones as sRGB, channels R, G and B), prints
// the metrics of renderer/statistics/error_metrics.h to stdout and writes the difference picture.
//
// JSON: one object with the keys width, height, mse, rmse, relmse, relmse_epsilon, relmse_trimmed,
// signed_bias, psnr, ssim, flip, max_abs, non_finite, different_pixels. A metric without a finite
// value is null: the PSNR of equal pictures, the signed bias against black, and all of them when no
// pixel is finite in both.
//
// FLIP picture: that of renderer/output/flip_picture.h. EXR: channels R, G, B, unclamped, and
// "flip".
//
// Returns kExitDone; how different the pictures are does not change the exit code. Throws
// InputError (unreadable, channels missing, sizes differ), UsageError (suffix of the difference
// picture, exposure), RenderError (cannot write it).
int run_compare(const CompareOptions& options);

// emberline denoise: a finished frame's clean picture.
struct DenoiseOptions {
  std::string image;                 // an .exr with the channels of `--aov denoising`
  std::vector<std::string> outputs;  // .exr: its channels and the results; .png, .jpg: the picture
  DisplaySettings display;           // of .png and .jpg
  int threads = 0;                   // 0: all
  LimitOptions limits;
};

// Gives what `render --denoise` of the same frame would have given, to the bit. Memory does not
// grow with the frame but by its width; of .png and .jpg with the picture. Returns the exit code.
// Throws InputError (unreadable, channels missing), UsageError (names), RenderError (cannot write
// it).
int run_denoise(const DenoiseOptions& options);

// emberline extend: a finished frame to more samples, or a lower threshold.
struct ExtendOptions {
  std::string frame;   // a picture that was rendered with --resumable, or its checkpoint
  std::string scene;   // where its scene is now; empty: where it was
  RenderOptions more;  // samples, threshold, outputs, threads and limits; the rest is the frame's
};

// Renders what is missing, and replaces picture and checkpoint. Returns and throws what
// run_render() does; InputError for a frame that cannot go on.
int run_extend(const ExtendOptions& options);

// emberline merge: the parts of a frame as one.
struct MergeOptions {
  std::vector<std::string> parts;  // checkpoints that `emberline render` has kept
  bool allow_holes = false, strict = false;
  RenderOptions frame;  // outputs, reports, threads and limits; the rest is the parts'
};

// Writes what `render` would have written of the whole frame: the same bits of tiles, of sample
// ranges up to the rounding of other sums. Returns kExitDone, or kExitRenderFailed where a file
// could not be written. Throws UsageError, InputError (parts that do not go together) and
// RenderError.
int run_merge(const MergeOptions& options);

// emberline farm: a frame in parts, as jobs of Slurm. Slurm schedules, watches and restarts them;
// nothing of ours does.
enum class FarmVerb : uint8_t { kSubmit, kStatus, kCancel, kRetry };

struct FarmOptions {
  FarmVerb verb = FarmVerb::kSubmit;
  RenderOptions frame;
  uint32_t parts = 0;  // 0: not given
  std::string frames = "0";
  SlurmRequest request;
  bool print = false, stage = false;
  std::string output;  // of status, cancel and retry
  bool json = false;
};

// Submits the frame, or looks after one that was submitted. Returns kExitDone. Throws UsageError,
// InputError (scene, job.json) and RenderError (no Slurm, what Slurm refuses, files).
int run_farm(const FarmOptions& options);

// emberline study: speed against error of several ways to render one frame.
// Renders, measures and writes study.csv, study.json, study.html and pictures into the folder. A
// study that was stopped goes on where it was when the same command is given again.
//
// Returns kExitDone, also where some runs have failed: they are shown as failed; kExitRenderFailed
// if all have; kExitStopped after a signal. Throws UsageError, InputError, RenderError before any
// long work for whatever is wrong with the options.
int run_study(const StudyOptions& options);

// emberline study --convergence: how fast the samples alone converge, without a scene.
// Prints a table, and writes convergence.csv and convergence.json if there is a folder. Throws
// UsageError, RenderError.
int run_convergence(const StudyOptions& options);

// `emberline session`: the window's session for another program, over standard input and output
// (renderer/session/PROTOCOL.md). These are what both the command line and the host may say.
struct SessionOptions {
  SessionOptions() { render.driver = kLiveDriver; }

  RenderOptions render;  // scene and results mean nothing
  std::string overlay = "none", format = "linear";
  std::optional<Rect> region;
  bool paused = false, denoise = false;
};

// Returns kExitDone when the host says "quit". Throws as run_session_host() does, and UsageError.
int run_session(const SessionOptions& options);

}  // namespace emberline
