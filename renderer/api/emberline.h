// Emberline as a library: renders a scene with settings to pictures and error estimates.
//
//   using namespace emberline::api;
//   Settings settings;
//   settings.set("driver", "adaptive").set("noise-threshold", "0.01");
//   Scene scene("shot.glb", settings);
//   scene.edit(R"({"emberline_edits": 1, "environment": {"strength": 0.5}})");
//   const Picture picture = render(scene, settings);
//
// Equal scene, edits and settings give equal bits, whatever the number of threads, and the same
// bits as the command. An object may be used by one thread at a time; different objects, such as
// two scenes or two frames of one scene, may be used concurrently. Errors are thrown and leave
// nothing changed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#if defined(_WIN32)
#define EMBERLINE_API
#else
#define EMBERLINE_API __attribute__((visibility("default")))
#endif

// Semantic versioning: programs built against 1.x run with every later 1.y.
#define EMBERLINE_VERSION_MAJOR 1
#define EMBERLINE_VERSION_MINOR 1
#define EMBERLINE_VERSION_PATCH 0

namespace emberline::api {

// The version of the running library, such as "1.0.0". It may differ from this header's.
EMBERLINE_API std::string version();

// The message is one line: what is wrong, where, and what to do.
struct EMBERLINE_API Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};
struct EMBERLINE_API UsageError : Error {  // a setting is wrong
  using Error::Error;
};
struct EMBERLINE_API InputError : Error {  // a file or edits cannot be used
  using Error::Error;
};
struct EMBERLINE_API RenderError : Error {  // out of memory, or a file cannot be written
  using Error::Error;
};
struct EMBERLINE_API Stopped : Error {  // a load was stopped, or a frame was given up
  using Error::Error;
};

// Everything that decides a frame, by the names of the command's options ("spp", "look-from") and
// with their texts. `emberline render --help-all` lists them.
class EMBERLINE_API Settings {
 public:
  Settings();
  Settings(const Settings& other);
  Settings(Settings&& other) noexcept;
  Settings& operator=(Settings other) noexcept;
  ~Settings();

  // Flags take "yes" or "no". Throws UsageError.
  Settings& set(std::string_view name, std::string_view text);
  // Returns an empty text if the setting is not given. Throws UsageError for an unknown name.
  std::string get(std::string_view name) const;
  // Reads a file of --save-settings. Throws InputError.
  Settings& read(const std::string& path);

  struct Help {
    std::string name;
    std::string type;    // of the value; empty: a flag
    std::string help;    // the default is in brackets
    std::string values;  // one line per valid name
    bool of_scene;       // only affects how a scene is loaded
  };
  // Lists all settings, as `emberline render --help-all` does.
  static std::vector<Help> help();

 private:
  friend struct Access;
  struct State;
  std::unique_ptr<State> state_;
};

// Resources of the machine. They do not affect a frame's bits.
struct Resources {
  int threads = 0;                       // at most 4096; 0: one per core
  std::optional<uint64_t> memory_bytes;  // for a scene and its frame; absent: the command's default
  std::optional<double> load_timeout_s;  // .001 to 1e9; absent: none
};

// A loaded scene that can be edited without being rebuilt.
class EMBERLINE_API Scene {
 public:
  // Uses these settings: env and related ones, backfaces, lenient, resource-root, variant, edits,
  // animation and its time or frame, working-space, catcher, holdout, whether there is cryptomatte,
  // and whether the integrator shows texture coordinates. Throws UsageError, InputError,
  // RenderError, Stopped.
  explicit Scene(const std::string& path, const Settings& settings = {},
                 const Resources& resources = {}, const std::stop_token& stop = {});
  Scene(Scene&& other) noexcept;
  Scene& operator=(Scene&& other) noexcept;
  ~Scene();

  // As the constructor, for a scene that pose() can animate: its file stays open, and moving parts
  // are stored separately. Since 1.1.0.
  static Scene animated(const std::string& path, const Settings& settings = {},
                        const Resources& resources = {}, const std::stop_token& stop = {});
  // Moves a scene of animated() to another pose: uses animation, time or frame, fps and shutter,
  // and whether aov requests velocities. The edits are kept. The scene must not be rendered
  // meanwhile. Throws as the constructor does and then leaves the scene unchanged. Since 1.1.0.
  void pose(const Settings& settings, const std::stop_token& stop = {});

  // Replaces all edits by these, in the JSON format of --edits. The time is not edited: the pose is
  // kept, and another "animation" is rejected. Throws InputError and then leaves the scene
  // unchanged.
  void edit(std::string_view json);
  // Adds an environment of these texels, which are copied: latitude-longitude, linear R G B,
  // interleaved, top row first. Throws UsageError for a texel that is negative or not finite, or if
  // the edits name a file as well.
  struct Environment {
    const float* rgb = nullptr;
    int width = 0, height = 0;
  };
  void edit(std::string_view json, const Environment& environment);
  // Names in the file; lights() has those of KHR_lights_punctual.
  std::vector<std::string> lights() const;
  std::vector<std::string> materials() const;
  std::vector<std::string> cameras() const;
  // The names of everything that shines: lights(), then the emissive materials, then "environment"
  // if there is one. Since 1.1.0.
  std::vector<std::string> light_sources() const;
  // The file's nodes, by their index there, and its animations. Since 1.1.0.
  struct Node {
    std::string name;
    int parent = -1;  // -1: none
    bool mesh = false, camera = false, light = false;
    bool in_scene = false;  // of the scene that is rendered
  };
  std::vector<Node> nodes() const;
  struct Animation {
    std::string name;
    double duration = 0;  // seconds
  };
  std::vector<Animation> animations() const;
  // All that can be edited: edits that name every light, every material and the environment with
  // the file's values. edit() with them changes nothing. Since 1.1.0.
  std::string editable() const;
  // Features of the file that are approximated or ignored, one line each.
  std::vector<std::string> approximated() const;
  std::vector<std::string> ignored() const;

 private:
  friend struct Access;
  struct State;
  explicit Scene(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

// Progress of a frame.
struct Progress {
  uint64_t samples = 0;
  std::optional<double> error_estimate;  // of the current picture, if the driver makes one
  // Linear R G B A of every pixel, top row first; null if the driver shows no picture before the
  // end.
  const float* rgba = nullptr;
  int width = 0, height = 0;  // of the rendered crop
};

struct Picture {
  int width = 0, height = 0;  // of the rendered crop, or the frame
  int x = 0, y = 0;           // top-left corner in the frame
  // "R", "G", "B", "A", "samples" and the channels of "aov", followed by those of other settings,
  // named as in the command's EXR: "light.NAME.R" (light-groups), "CryptoObject00.R" (cryptomatte;
  // ids are stored as the bits of floats, see matte_names()), "denoised.R" and "denoised.error"
  // (denoise).
  std::vector<std::string> channels;
  std::vector<float> values;  // interleaved, top row first; linear, in the working space
  uint64_t samples = 0, rays = 0;
  uint64_t non_finite_samples = 0;       // counted as black
  std::optional<double> error_estimate;  // expected RMS error of display values, 0 to 1
  bool complete = false;                 // false: stopped early
  int frame_width = 0, frame_height = 0;

  const float* pixel(int column, int row) const {
    return &values[(size_t(row) * size_t(width) + size_t(column)) * channels.size()];
  }
};

// A picture together with the other contents of the command's file: settings, working space, camera
// and matte names at the time of rendering. Since 1.1.0.
class EMBERLINE_API RenderedPicture : public Picture {
 public:
  // For a picture that was not rendered here: Rec. 709, as from read_picture().
  explicit RenderedPicture(Picture picture = {});

  // Returns R G B for compare() and flip(): linear Rec. 709, whatever the working space. Throws
  // UsageError for a picture without R G B.
  std::vector<float> rec709() const;

 private:
  friend struct Access;
  struct Record;
  std::shared_ptr<const Record> record_;
};

// Renders a frame. All channels have the same bits as the command's EXR. `watch` is called from any
// thread, one call at a time: after each tile with the bucket driver, otherwise at every pause,
// while nothing renders. `stop` returns the unfinished picture; `give_up` is faster, but throws
// Stopped. "time-limit" starts with the call. Throws UsageError, InputError, RenderError, and what
// `watch` throws.
EMBERLINE_API Picture render(const Scene& scene, const Settings& settings,
                             const Resources& resources = {}, const std::stop_token& stop = {},
                             const std::function<void(const Progress&)>& watch = {},
                             const std::stop_token& give_up = {});

// The checkpoint of a frame, from which another run can resume to the same bits. The format is that
// of the command (`--checkpoint`). Since 1.1.0.
struct RenderFiles {
  static RenderFiles none() { return {}; }
  // Throws UsageError for an empty name.
  static RenderFiles at(std::string checkpoint) {
    if (checkpoint.empty()) throw UsageError("checkpoint: no file is named");
    RenderFiles files;
    files.checkpoint = std::move(checkpoint);
    return files;
  }

  std::string checkpoint;   // empty: none
  bool resume = false;      // resume from an existing file; otherwise it is overwritten
  double interval_s = 300;  // between two saves
  // Keep the file when the frame is done, for extend(). The file of a part ("part", "sample-range")
  // is always kept, for merge().
  bool keep = false;

 private:
  RenderFiles() = default;  // private, so that render(scene, settings, {}) selects Resources
};
// As above, with a checkpoint, which is saved at intervals, when the frame is stopped or given up,
// and when `watch` throws. `complete` is false for a frame ended by a time limit, since it can be
// resumed. The scene's files are read again for their fingerprints. Throws InputError if they have
// changed since loading, or if `resume` does not match the file (with the differences); UsageError
// for a file that is no checkpoint or, without `resume`, another frame's; RenderError if the file
// cannot be created. A failed save is logged as an error; for a part it throws RenderError. Only
// one call at a time may use the file. Since 1.1.0.
EMBERLINE_API RenderedPicture render(const RenderFiles& files, const Scene& scene,
                                     const Settings& settings, const Resources& resources = {},
                                     const std::stop_token& stop = {},
                                     const std::function<void(const Progress&)>& watch = {},
                                     const std::stop_token& give_up = {});

// The names in the scene and their ids, for one kind of "cryptomatte". Channels store the ids as
// the bits of floats. Since 1.1.0.
struct MatteNames {
  std::string layer;  // for example "CryptoObject" for "CryptoObject00.R"
  std::vector<std::pair<std::string, uint32_t>> ids;  // each id once
};
// Returns the names for the requested kinds, in their order, in the scene's current pose and with
// its edits. Throws UsageError. Since 1.1.0.
EMBERLINE_API std::vector<MatteNames> matte_names(const Scene& scene, const Settings& settings);

// The contents of a checkpoint. Loading the scene with these settings reproduces the frame's scene,
// except for edits made by the program. Since 1.1.0.
struct StoredFrame {
  std::string scene;  // path when it was saved
  Settings settings;  // of the frame and of its scene
  std::vector<MatteNames> mattes;
};
// Throws InputError. Since 1.1.0.
EMBERLINE_API StoredFrame stored_frame(const std::string& checkpoint);

// Adds samples to a finished frame whose checkpoint was kept. `more` sets "spp", "noise-threshold"
// or "max-spp", and optionally "time-limit". With equal samples per pixel the result has the bits
// of a frame rendered at once; an adaptive frame continues from its state. The checkpoint then
// contains the larger frame. A stopped extension is resumed from CHECKPOINT.next by the next call.
// Throws UsageError for less than the frame has and for other settings, InputError for a checkpoint
// that cannot be extended, is damaged or is of another scene; otherwise as render(). Since 1.1.0.
EMBERLINE_API RenderedPicture extend(const std::string& checkpoint, const Scene& scene,
                                     const Settings& more, const Resources& resources = {},
                                     const std::stop_token& stop = {},
                                     const std::function<void(const Progress&)>& watch = {},
                                     const std::stop_token& give_up = {});

struct MergeRules {
  bool allow_holes = false;  // parts may be missing; their pixels are black
  bool strict = false;       // all parts must come from one kind of machine
  bool parts = false;        // adds a channel "part": the pixel's checkpoint, counted from 1
};
// Merges the parts of a frame ("part", "sample-range", or different "seed" values), as if it had
// been rendered at once. Throws InputError that names the part, and Stopped. Since 1.1.0.
EMBERLINE_API RenderedPicture merge(const std::vector<std::string>& checkpoints,
                                    const MergeRules& rules = {}, const Resources& resources = {},
                                    const std::stop_token& stop = {});

// Reads an EXR with all its channels, or a PNG, JPEG, HDR, WebP or TIFF, whose 8-bit values become
// linear. Other working spaces are converted to Rec. 709. Throws InputError, Stopped.
EMBERLINE_API Picture read_picture(const std::string& path, const Resources& resources = {},
                                   const std::stop_token& stop = {});
// Writes the file atomically. EXR stores every channel unchanged; PNG and JPEG show R G B with
// `exposure` in stops and the command's display transform ($OCIO). Colours are assumed to be Rec.
// 709. Throws UsageError, RenderError.
EMBERLINE_API void write_picture(const std::string& path, const Picture& picture,
                                 double exposure = 0);
// Writes the same file as the command: an EXR with working space, half, exr-compression and
// exr-parts, and with matte names, camera and settings in its header; or a PNG or JPEG of the
// denoised picture, if any. A PNG has alpha if the frame is transparent. Since 1.1.0.
EMBERLINE_API void write_picture(const std::string& path, const RenderedPicture& picture,
                                 double exposure = 0);
// Writes a PNG or JPEG of 1, 3 or 4 interleaved channels of display values.
EMBERLINE_API void write_picture(const std::string& path, const uint8_t* values, int width,
                                 int height, int channels);

// The difference between a picture and a reference, as reported by `emberline compare`.
struct Comparison {
  double mse = 0, rmse = 0;
  double relmse = 0, relmse_epsilon = 0;
  double relmse_trimmed = 0;  // excluding the worst 0.1 % of pixels
  double signed_bias = 0;     // sum(x - r) / sum(r)
  double psnr = 0, ssim = 0;  // these and `flip` are of display values
  double flip = 0;
  double max_abs = 0;
  uint64_t different_pixels = 0;
  uint64_t non_finite = 0;  // pixels with a NaN or infinity, excluded above
};
// Both pictures are linear Rec. 709, interleaved R G B, top row first (see
// RenderedPicture::rec709()). `exposure` is in stops. Throws UsageError for no pixels or an
// exposure that is not finite; RenderError.
EMBERLINE_API Comparison compare(const float* image, const float* reference, int width, int height,
                                 double exposure = 0);
// The FLIP error of each pixel, 0 to 1; 0 where either picture is not finite.
EMBERLINE_API std::vector<float> flip(const float* image, const float* reference, int width,
                                      int height, double exposure = 0);

// The options of `emberline study`, by their names and texts. Since 1.1.0.
class EMBERLINE_API StudyRequest {
 public:
  // Results go into the folder, from which a stopped study is resumed.
  explicit StudyRequest(std::string folder);
  StudyRequest(const StudyRequest& other);
  StudyRequest(StudyRequest&& other) noexcept;
  StudyRequest& operator=(StudyRequest other) noexcept;
  ~StudyRequest();

  // Accepts "drivers", "estimators", "samplers", "spp" or "seconds", "seeds", "baseline",
  // "denoise", "separate", "reference", "reference-spp", "cache" and "restart". Lists are separated
  // by commas; flags take "yes" or "no". Throws UsageError.
  StudyRequest& set(std::string_view name, std::string_view text);

 private:
  friend struct Access;
  struct State;
  std::unique_ptr<State> state_;
};
// A run of one method with one seed and one budget: a row of study.csv.
struct StudyRow {
  std::string method, driver, sampler, estimator, allocation;
  bool unbiased = false, denoised = false;
  uint32_t seed = 0;
  std::string failure;  // empty: none; a failed run has only this row, without numbers
  double budget = 0;    // samples per pixel, or seconds
  uint64_t samples = 0;
  double mean_samples = 0;                             // per pixel
  double wall_s = 0, cpu_s = 0;                        // of rendering
  std::optional<double> estimate;                      // the method's own estimate of its error
  std::vector<std::pair<std::string, double>> errors;  // "mse", "relmse", ... "signed_bias"
};
struct StudyTable {
  std::vector<StudyRow> rows;  // by seed, then method, then budget
  std::string text;            // readable summary: each method's error, slope and speedup
  bool complete = false;       // false: stopped; the same call resumes it
};
// Renders the scene with every method, seed and budget, and writes study.csv, study.json and
// study.html into the folder. `settings` apply to all frames: samples, view, light, scene loading,
// buckets, and the first seed. `on_samples` gets the number of new samples; any thread may call it,
// several at once. Throws UsageError (also for other settings), InputError, RenderError, and
// Stopped if there is no reference yet. Since 1.1.0.
EMBERLINE_API StudyTable study(const std::string& scene, const Settings& settings,
                               const StudyRequest& request, const Resources& resources = {},
                               const std::stop_token& stop = {},
                               const std::function<void(uint64_t)>& on_samples = {});

// A per-pixel quantity that a heatmap can show. Since 1.1.0.
struct HeatmapKind {
  std::string name;  // "samples", "error", "stop", ...
  std::string summary;
  std::vector<std::string> channels;  // that a picture must have
};
// The first is the default.
EMBERLINE_API std::vector<HeatmapKind> heatmap_kinds();
// One value per pixel, top row first; NaN where undefined. Throws UsageError for an unknown name,
// InputError for a picture without the channels. Since 1.1.0.
EMBERLINE_API std::vector<float> heatmap_values(const Picture& picture,
                                                const std::string& of = "samples");

// Display values (sRGB): interleaved R G B, top row first. Since 1.1.0.
struct DisplayedPicture {
  int width = 0, height = 0;
  std::vector<uint8_t> values;
};
// The appearance of a heatmap, by the options of `emberline heatmap`. Since 1.1.0.
struct HeatmapLook {
  std::string colors = "grey";  // or viridis, inferno, magma, turbo
  std::optional<std::pair<double, double>>
      range;           // of the colours; absent: derived from the values
  bool log = false;    // logarithmic scale
  bool plain = false;  // without the legend, which is below the pixels
};
// Draws a heatmap. Passing the result to write_picture() gives the command's file. Throws as
// heatmap_values() does. Since 1.1.0.
EMBERLINE_API DisplayedPicture heatmap(const Picture& picture, const std::string& of = "samples",
                                       const HeatmapLook& look = {});

// The spelling of settings in messages, exceptions and help texts: noise-threshold, or
// noise_threshold as a Python argument.
enum class SettingSpelling { kPlain, kUnderscores };
// Applies to the whole process. Since 1.1.0.
EMBERLINE_API void spell_settings(SettingSpelling spelling);

enum class Message { kError, kWarning, kInfo };
// Redirects messages, which come from any thread, one at a time. Null: to stderr, the default.
EMBERLINE_API void set_log(std::function<void(Message, std::string_view)> log);

}  // namespace emberline::api
