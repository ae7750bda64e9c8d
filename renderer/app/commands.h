// The subcommands: their options and the functions that run them. `view` is in
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

namespace CLI {
class App;
}

namespace emberline {

// `emberline render`: renders a scene file into pictures and a report. Returns the exit code.
// Throws EmberlineError.
int run_render(const RenderOptions& options);

// `render --frames`: renders several frames, one after another, with one report for all of them.
// Continues after a frame that fails, unless --stop-on-error is given. Returns the highest exit
// code of the frames. Throws EmberlineError for errors that affect every frame: the command line or
// the scene.
int run_range(const RenderOptions& options, const std::vector<int>& frames);

// `emberline info`: lists what a scene contains, which features it needs and which of them are
// approximated or ignored. Can also print an edits file that the user can start from, describe a
// rendered frame, or list the channels that pictures can have.
struct InfoOptions {
  std::string scene;      // a scene, or a frame if the file is an EXR; unused with `channels`
  bool channels = false;  // list the channels instead of describing a scene
  bool edits = false;     // print edits that change nothing (edits_template.h)
  bool json = false;
  FrameSettings settings;  // how to load the scene, and the scene's environment
  LimitOptions limits;
};

// Prints to stdout. Returns the exit code. Throws EmberlineError.
int run_info(const InfoOptions& options);

// `emberline heatmap`: draws a statistic of a rendered frame in false colour.
struct HeatmapOptions {
  std::string image;  // an .exr that `emberline render` wrote
  std::string output;
  std::string quantity;  // one of heatmap_quantity_table()
  std::string against;   // another frame of this view; shows the saving in time instead
  HeatmapStyle style;
  LimitOptions limits;
};

// Writes the same pixels as `render --heatmap` would. Returns kExitDone. Throws UsageError for
// wrong options, InputError if the frame is unreadable or lacks channels, and RenderError if the
// output cannot be written.
int run_heatmap(const HeatmapOptions& options);

// `emberline show`: writes an EXR, or one of its layers, as pictures of other formats.
struct ShowOptions {
  std::string image;  // any .exr with a flat picture, or a sequence: "shot.####.exr"
  std::string layer;  // see find_layer(); empty: see find_colour()
  // A .png or .jpg is the picture as displayed. An .exr has the layer in its channels R, G, B and
  // A. A .gif is an animation of the sequence.
  std::vector<std::string> outputs;
  std::vector<int> frames;    // of a sequence; empty: all that exist
  std::optional<double> fps;  // of the animation; absent: kAnimationFps
  DisplaySettings display;    // for all but .exr
  LimitOptions limits;
};

// Writes the same .png and .jpg files as `render -o` would, with two exceptions: a denoised picture
// is shown only if the layer "denoised" is chosen, and values have the precision of the file (half
// floats, lossy compression). A layer with a single channel is shown in grey. If its values are not
// all between 0 and 1, its least value is black and its greatest value is white. Keeps only the
// .png and .jpg pictures and a band of rows in memory. Returns the exit code. Throws InputError if
// the file is unreadable or has no picture, UsageError for an unknown layer or wrong options, and
// RenderError if an output cannot be written.
//
// The frames of a sequence are converted one after another. If one of them fails, this is logged,
// and the others are still converted. All frames have the same value for black and the same value
// for white. An animation is in memory as a whole, scaled down to 640 pixels. If the memory limit
// ends it early, the other outputs are still written.
int run_show(const ShowOptions& options);

// A sequence as a GIF.
struct AnimatedFrames {
  std::vector<unsigned char> gif;  // empty: no frame was readable
  int width = 0, height = 0;
  std::vector<int> frames;  // those that could be read
};
// Returns the frames of an .exr sequence as run_show() does for a .gif, with sides of at most
// `max_side` pixels. A frame is shown denoised if it has been denoised. Ignores the outputs and the
// layer. Warns about frames that cannot be read or do not have the size of `window`, and leaves
// them out. Throws RenderError.
AnimatedFrames animate_frames(const ShowOptions& options, int max_side, const Rect& window);

// `emberline explain`: says in words why a pixel of a finished frame got its number of samples.
struct ExplainOptions {
  std::string image;            // an .exr that `emberline render` wrote
  std::string pixel = "worst";  // "X,Y" in the frame, or "worst"
  LimitOptions limits;
};

// Prints to stdout. Returns kExitDone. Throws what explain_frame() throws, and UsageError for a
// malformed pixel.
int run_explain(const ExplainOptions& options);

// `emberline compare`: measures the difference between two pictures.
struct CompareOptions {
  std::string image;
  std::string reference;
  bool json = false;       // to stdout, instead of a table
  std::string difference;  // empty: none; .png, .jpg: FLIP in false colour; .exr: image - reference
  float exposure = 0.0f;   // stops, for PSNR, SSIM, FLIP and the FLIP picture
  std::string layer;       // empty: R, G and B
  std::string chart;       // .svg of a sequence; empty: none
  LimitOptions limits;
};

// Reads both pictures: EXR, HDR, PNG, JPEG, WebP or TIFF. 8-bit pictures count as sRGB.
// Compares R, G and B or, if `layer` is set, the channels of this layer (see read_rgb()). Prints
// the metrics of renderer/statistics/error_metrics.h to stdout, and writes the difference picture.
//
// The JSON is one object with the keys width, height, mse, rmse, relmse, relmse_epsilon,
// relmse_trimmed, signed_bias, psnr, ssim, flip, max_abs, non_finite, different_pixels. A metric
// without a finite value is null: the PSNR of identical pictures, the signed bias against a black
// reference, and every metric if no pixel is finite in both pictures.
//
// If the names have a frame number ("shot.####.exr"), compares all frames that both sequences have.
// The reference may be a single picture. The JSON then has the keys `frames` and `summary`.
// `frames` lists the metrics of each frame, and also its `frame`, `flicker` and `flicker_share`
// (renderer/statistics/flicker.h). `summary` has the median, mean and largest value of relmse,
// relmse_trimmed, flip and flicker. Flicker is measured along the motion in the layer `velocity` of
// the reference or, if it has none, of the picture.
//
// For the FLIP picture, see renderer/output/flip_picture.h. A difference picture in EXR has the
// channels R, G and B, which are not clamped, and "flip".
//
// Returns kExitDone even if the pictures differ. Throws InputError if a picture is unreadable or
// lacks channels, or if the sizes differ. Throws UsageError for an unknown layer or wrong options,
// and RenderError if the difference picture cannot be written.
int run_compare(const CompareOptions& options);

// `emberline denoise`: denoises finished frames.
struct DenoiseOptions {
  // An .exr with the channels of `--aov denoising`. A sequence if it has a frame number.
  std::string image;
  std::vector<std::string> outputs;  // .exr: all channels plus results; .png, .jpg: the picture
  std::vector<int> frames;           // of a sequence; empty: all existing frames
  int across = 0;                    // number of neighbouring frames on either side
  bool in_place = false;             // whether outputs may replace frames of the sequence
  DisplaySettings display;           // for .png and .jpg
  int threads = 0;                   // 0: all
  LimitOptions limits;
};

// Without `across`, the result is bit-identical to that of `render --denoise`. With `across`, the
// result depends only on the files of the frame and its neighbours, not on which `frames` are
// denoised. A scratch file beside the first output holds each neighbour without compression. Memory
// use grows with the frame's width or, if a .png or .jpg is written, with its number of pixels.
// Returns the exit code. Throws InputError if the frame is unreadable or lacks channels, UsageError
// for wrong options, and RenderError if an output cannot be written. In a sequence, an error of one
// frame is logged, and the others are still denoised.
int run_denoise(const DenoiseOptions& options);

// `emberline plan`: decides how many samples each pixel of a frame gets, for the setting `plan`.
struct PlanOptions {
  RenderOptions frame;  // the planned frame; its outputs are unused
  std::string output;   // the plan's file
};

// Renders a pilot, which is the frame with an eighth of its samples. Writes the sample counts that
// follow from the pilot's noise. Returns the exit code. A stopped pilot writes no plan; with
// `resume`, it saves a checkpoint beside the plan. Throws EmberlineError.
int run_plan(const PlanOptions& options);

// `emberline extend`: renders further samples of a finished frame, up to more samples per pixel or
// a lower noise threshold.
struct ExtendOptions {
  std::string frame;        // a picture that was rendered with --resumable, or its checkpoint
  std::string scene;        // current path of the scene; empty: unchanged
  RenderOptions overrides;  // samples, threshold, outputs, threads, limits; rest as in `frame`
};

// Renders the missing samples, then replaces the picture and its checkpoint. Returns and throws
// what run_render() does; also throws InputError for a frame that cannot be extended.
int run_extend(const ExtendOptions& options);

// `emberline merge`: joins the parts of a frame.
struct MergeOptions {
  std::vector<std::string> parts;  // checkpoints that `emberline render` kept
  bool allow_holes = false, strict = false;
  RenderOptions frame;  // outputs, reports, threads and limits; the rest comes from the parts
};

// Writes what `render` would write for the whole frame. If the parts are tiles, the result is
// bit-identical to that of `render`; if they are sample ranges, sums are rounded differently.
// Returns kExitDone, or kExitRenderFailed if a file could not be written. Throws UsageError,
// RenderError, and InputError if the parts do not belong together.
int run_merge(const MergeOptions& options);

// `emberline farm`: renders a frame in parts, as Slurm jobs. Slurm schedules, watches and restarts
// the jobs.
enum class FarmVerb : uint8_t { kSubmit, kStatus, kCancel, kRetry };

struct FarmOptions {
  FarmVerb verb = FarmVerb::kSubmit;
  RenderOptions frame;
  uint32_t parts = 0;  // 0: not given
  std::string frames = "0";
  SlurmRequest request;
  bool print = false, stage = false;
  std::string output;  // for status, cancel and retry
  bool json = false;
};

// Submits the frame, or runs the verb for a frame that was submitted. Returns kExitDone. Throws
// UsageError for wrong options, InputError for an invalid scene or job.json, and RenderError if
// there is no Slurm, if Slurm rejects a job, or if a file cannot be written.
int run_farm(const FarmOptions& options);

// `emberline study`: measures speed against error for several ways to render one frame. Writes
// study.csv, study.json, study.html and pictures into a folder. If the study is stopped, running
// the same command again resumes it. With several frames, each is studied in a subfolder, and
// range.csv, range.json and range.html are about all of them (renderer/statistics/study/range.h).
//
// Returns kExitDone even if some runs failed (the results show which), kExitRenderFailed if all
// runs failed, and kExitStopped after a signal. If the options are wrong, throws UsageError,
// InputError or RenderError before the long work begins.
int run_study(const StudyOptions& options);

// `emberline study --convergence`: measures the convergence order of the samplers, without a scene.
// Prints a table. If a folder is given, also writes convergence.csv and convergence.json. Throws
// UsageError and RenderError.
int run_convergence(const StudyOptions& options);

// `emberline session`: lets a host program control a session like that of the window, over standard
// input and output (renderer/session/PROTOCOL.md). Both the command line and the host can set these
// options.
struct SessionOptions {
  SessionOptions() { render.driver = kLiveDriver; }

  RenderOptions render;  // scene and outputs are unused
  std::string overlay = "none", format = "linear";
  std::optional<Rect> region;
  bool paused = false, denoise = false;
};

// Returns kExitDone when the host says "quit". Throws what run_session_host() throws, and
// UsageError.
int run_session(const SessionOptions& options);

// `emberline help [COMMAND [OPTION]]`: explains all commands, one command, or one option of a
// command.
struct HelpOptions {
  const CLI::App* root = nullptr;
  std::vector<std::string> words;
};

// Prints to stdout. Returns kExitDone. Throws UsageError for an unknown command or option.
int run_help(const HelpOptions& options);

}  // namespace emberline
