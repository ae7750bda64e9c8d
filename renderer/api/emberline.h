// Emberline as a library: renders a scene with given settings, and returns pictures and error
// estimates.
//
//   using namespace emberline::api;
//   Settings settings;
//   settings.set("driver", "adaptive").set("noise-threshold", "0.01");
//   Scene scene("shot.glb", settings);
//   scene.edit(R"({"emberline_edits": 1, "environment": {"strength": 0.5}})");
//   const Picture picture = render(scene, settings);
//
// The same scene, edits and settings always give bit-identical pictures, whatever the number of
// threads. They are also bit-identical to the pictures of the program `emberline`, called "the
// command" below. An object may be used by one thread at a time; different objects, such as two
// scenes or two frames of one scene, may be used concurrently. A call that fails throws and changes
// nothing.
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

// The message is one line that says what is wrong, where, and what to do.
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

// All settings that determine a frame. They are named like the command's options ("spp",
// "look-from"), and their values are written the same way. `emberline render --help-all` lists
// them.
class EMBERLINE_API Settings {
 public:
  Settings();
  Settings(const Settings& other);
  Settings(Settings&& other) noexcept;
  Settings& operator=(Settings other) noexcept;
  ~Settings();

  // Sets one setting. Flags take "yes" or "no". Throws UsageError.
  Settings& set(std::string_view name, std::string_view text);
  // Returns an empty text if the setting is not set. Throws UsageError for an unknown name.
  std::string get(std::string_view name) const;
  // Reads a file that --save-settings has written. Throws InputError.
  Settings& read(const std::string& path);

  struct Help {
    std::string name;
    std::string type;    // type of the value; empty for a flag
    std::string help;    // the default is in brackets
    std::string values;  // one line per valid name
    bool of_scene;       // whether the setting only affects how a scene is loaded
  };
  // Lists all settings, as `emberline render --help-all` does.
  static std::vector<Help> help();

 private:
  friend struct Access;
  struct State;
  std::unique_ptr<State> state_;
};

// Limits on threads, memory and loading time. They do not affect a frame's pixels.
struct Resources {
  int threads = 0;                       // at most 4096; 0: one per core
  std::optional<uint64_t> memory_bytes;  // for a scene and its frame; absent: the command's default
  std::optional<double> load_timeout_s;  // .001 to 1e9; absent: no time-out
};

// A loaded scene that can be edited without being rebuilt.
class EMBERLINE_API Scene {
 public:
  // Uses these settings: env and related ones, backfaces, lenient, resource-root, variant, edits,
  // animation and its time or frame, working-space, catcher, catcher-plane, holdout, whether
  // cryptomatte is set, and whether the integrator shows texture coordinates. Throws UsageError,
  // InputError, RenderError, Stopped.
  explicit Scene(const std::string& path, const Settings& settings = {},
                 const Resources& resources = {}, const std::stop_token& stop = {});
  Scene(Scene&& other) noexcept;
  Scene& operator=(Scene&& other) noexcept;
  ~Scene();

  // Like the constructor, but loads a scene that pose() can animate: its file stays open, and
  // moving parts are stored separately. Since 1.1.0.
  static Scene animated(const std::string& path, const Settings& settings = {},
                        const Resources& resources = {}, const std::stop_token& stop = {});
  // Moves a scene that animated() has loaded to another pose. Uses the settings animation, time or
  // frame, fps and shutter, and whether aov requests velocities. Keeps the edits. The scene must
  // not be rendered meanwhile. Throws what the constructor throws, and then leaves the scene
  // unchanged. Since 1.1.0.
  void pose(const Settings& settings, const std::stop_token& stop = {});

  // Replaces all edits with those in `json`, which has the format of --edits. Edits cannot change
  // the pose: an "animation" in them must equal the one in the edits that the scene was opened
  // with. Throws InputError, and then leaves the scene unchanged.
  void edit(std::string_view json);
  // Like edit() above, and also sets an environment with these texels, which are copied:
  // latitude-longitude, linear R G B, interleaved, top row first. Throws UsageError if a texel is
  // negative or not finite, or if the edits also name an environment file.
  struct Environment {
    const float* rgb = nullptr;
    int width = 0, height = 0;
  };
  void edit(std::string_view json, const Environment& environment);
  // Return the names in the file. lights() returns only the lights of KHR_lights_punctual.
  std::vector<std::string> lights() const;
  std::vector<std::string> materials() const;
  std::vector<std::string> cameras() const;
  // Returns the names of everything that emits light: lights(), then the emissive materials, then
  // "environment" if there is one. Since 1.1.0.
  std::vector<std::string> light_sources() const;
  // The file's nodes and animations, in the file's order. Since 1.1.0.
  struct Node {
    std::string name;
    int parent = -1;  // index of the parent; -1: none
    bool mesh = false, camera = false, light = false;
    bool in_scene = false;  // whether it belongs to the scene that is rendered
  };
  std::vector<Node> nodes() const;
  struct Animation {
    std::string name;
    double duration = 0;  // seconds
  };
  std::vector<Animation> animations() const;
  // Returns edits that name every light, every material and the environment, with the file's values
  // for everything that can be edited. Calling edit() with this text restores the file's values.
  // Since 1.1.0.
  std::string editable() const;
  // Return the features of the file that are approximated or ignored, one line each.
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
  std::optional<double> error_estimate;  // for the current picture, if the driver estimates errors
  // Linear R G B A of every pixel, top row first; null if the driver shows no picture before the
  // end.
  const float* rgba = nullptr;
  int width = 0, height = 0;  // size of the rendered crop
};

struct Picture {
  int width = 0, height = 0;  // size of the rendered crop, or of the whole frame without a crop
  int x = 0, y = 0;           // top-left corner in the frame
  // "R", "G", "B", "A", "samples" and the channels of "aov", followed by the channels of other
  // settings. The names are those in the command's EXR: "light.NAME.R" (light-groups),
  // "CryptoObject00.R" (cryptomatte; ids are stored as the bits of floats, see matte_names()),
  // "denoised.R" and "denoised.error" (denoise).
  std::vector<std::string> channels;
  std::vector<float> values;  // interleaved, top row first; linear, in the working space
  uint64_t samples = 0, rays = 0;
  uint64_t non_finite_samples = 0;       // these samples count as black
  std::optional<double> error_estimate;  // expected RMS error of display values, 0 to 1
  bool complete = false;                 // false if the render was stopped early
  int frame_width = 0, frame_height = 0;

  const float* pixel(int column, int row) const {
    return &values[(size_t(row) * size_t(width) + size_t(column)) * channels.size()];
  }
};

// A picture together with everything else that the command's file contains: settings, working
// space, camera and matte names at the time of rendering. Since 1.1.0.
class EMBERLINE_API RenderedPicture : public Picture {
 public:
  // Wraps a picture that render() did not return. The picture must be in Rec. 709, like a picture
  // from read_picture().
  explicit RenderedPicture(Picture picture = {});

  // Returns R G B for compare() and flip(), converted from the working space to linear Rec. 709.
  // Throws UsageError for a picture without R G B.
  std::vector<float> rec709() const;

 private:
  friend struct Access;
  struct Record;
  std::shared_ptr<const Record> record_;
};

// Renders a frame. All channels are bit-identical to those of the command's EXR. `watch` may be
// called from any thread, but never from two threads at once. The bucket driver calls it after each
// tile; the other drivers call it at every pause, while nothing is being rendered. A stop request
// through `stop` makes the call return the unfinished picture. A request through `give_up` ends the
// call faster, but throws Stopped. "time-limit" counts from the start of the call. Throws
// UsageError, InputError, RenderError, and whatever `watch` throws.
EMBERLINE_API Picture render(const Scene& scene, const Settings& settings,
                             const Resources& resources = {}, const std::stop_token& stop = {},
                             const std::function<void(const Progress&)>& watch = {},
                             const std::stop_token& give_up = {});

// The file in which a frame's checkpoint is saved. Another run can resume from the checkpoint, and
// then gets a bit-identical picture. The format is that of the command (`--checkpoint`). Since
// 1.1.0.
struct RenderFiles {
  static RenderFiles none() { return {}; }
  // Throws UsageError for an empty name.
  static RenderFiles at(std::string checkpoint) {
    if (checkpoint.empty()) throw UsageError("checkpoint: no file is named");
    RenderFiles files;
    files.checkpoint = std::move(checkpoint);
    return files;
  }

  std::string checkpoint;   // name of the file; empty: none
  bool resume = false;      // whether to resume from an existing file instead of overwriting it
  double interval_s = 300;  // time between two saves
  // Whether to keep the file for extend() when the frame is done. The file of a part ("part",
  // "sample-range") is always kept, for merge().
  bool keep = false;

 private:
  RenderFiles() = default;  // private, so that {} in render(scene, settings, {}) means Resources
};
// Like render() above, with a checkpoint. The checkpoint is saved at intervals, when the frame is
// stopped or given up, and when `watch` throws. Picture::complete is false if a time limit ended
// the frame, because such a frame can be resumed. The scene's files are read again for their
// fingerprints. Throws InputError if they have changed since loading, or if the frame to resume
// does not match (the message lists the differences). Throws UsageError if the file is not a
// checkpoint or, without `resume`, belongs to another frame. Throws RenderError if the file cannot
// be created. A failed save is logged as an error, or throws RenderError if the frame is a part.
// Only one call at a time may use the file. Since 1.1.0.
EMBERLINE_API RenderedPicture render(const RenderFiles& files, const Scene& scene,
                                     const Settings& settings, const Resources& resources = {},
                                     const std::stop_token& stop = {},
                                     const std::function<void(const Progress&)>& watch = {},
                                     const std::stop_token& give_up = {});

// The names in the scene and their ids, for one of the kinds that the setting "cryptomatte" lists.
// Channels store the ids as the bits of floats. Since 1.1.0.
struct MatteNames {
  std::string layer;  // for example "CryptoObject" for "CryptoObject00.R"
  std::vector<std::pair<std::string, uint32_t>> ids;  // every id occurs once
};
// Returns the names for the scene's current pose and edits. There is one entry for each kind that
// the settings request, in the order object, material, asset. Throws UsageError. Since 1.1.0.
EMBERLINE_API std::vector<MatteNames> matte_names(const Scene& scene, const Settings& settings);

// The contents of a checkpoint. Loading the scene with these settings reproduces the frame's scene,
// except for edits made by Scene::edit(). Since 1.1.0.
struct StoredFrame {
  std::string scene;  // path of the scene when the frame was rendered
  Settings settings;  // settings of the frame and of its scene
  std::vector<MatteNames> mattes;
};
// Reads the contents of a checkpoint. Throws InputError. Since 1.1.0.
EMBERLINE_API StoredFrame stored_frame(const std::string& checkpoint);

// Adds samples to a finished frame whose checkpoint was kept. `more` sets "spp", "noise-threshold"
// or "max-spp", and optionally "time-limit". If all pixels have the same number of samples, the
// result is bit-identical to a frame rendered in one go. An adaptive frame continues from its
// state. Afterwards the checkpoint contains the extended frame. If the extension is stopped, the
// next call resumes it from the file CHECKPOINT.next. Throws UsageError if `more` asks for less
// than the frame has, or contains other settings; InputError if the checkpoint cannot be extended,
// is damaged or belongs to another scene; and what render() throws. Since 1.1.0.
EMBERLINE_API RenderedPicture extend(const std::string& checkpoint, const Scene& scene,
                                     const Settings& more, const Resources& resources = {},
                                     const std::stop_token& stop = {},
                                     const std::function<void(const Progress&)>& watch = {},
                                     const std::stop_token& give_up = {});

struct MergeRules {
  bool allow_holes = false;  // parts may be missing; their pixels are black
  bool strict = false;       // all parts must come from the same kind of machine
  bool parts = false;  // adds the channel "part": which checkpoint each pixel is from (1, 2, ...)
};
// Merges the parts of a frame ("part", "sample-range", or different "seed" values) as if the frame
// had been rendered in one go. Throws InputError, which names the part, and Stopped. Since 1.1.0.
EMBERLINE_API RenderedPicture merge(const std::vector<std::string>& checkpoints,
                                    const MergeRules& rules = {}, const Resources& resources = {},
                                    const std::stop_token& stop = {});

// Reads an EXR with all its channels, or a PNG, JPEG, HDR, WebP or TIFF. Converts 8-bit values to
// linear ones, and other working spaces to Rec. 709. Throws InputError, Stopped.
EMBERLINE_API Picture read_picture(const std::string& path, const Resources& resources = {},
                                   const std::stop_token& stop = {});
// Writes the file atomically. An EXR contains every channel unchanged. A PNG or JPEG shows R G B
// with `exposure`, in stops, and the command's display transform ($OCIO); the colours must be Rec.
// 709. Throws UsageError, RenderError.
EMBERLINE_API void write_picture(const std::string& path, const Picture& picture,
                                 double exposure = 0);
// Writes the same file as the command. An EXR is written with the settings working-space, half,
// exr-compression and exr-parts, and has matte names, camera and settings in its header. A PNG or
// JPEG shows the denoised picture, if any; a PNG has alpha if the frame is transparent. Since
// 1.1.0.
EMBERLINE_API void write_picture(const std::string& path, const RenderedPicture& picture,
                                 double exposure = 0);
// Writes a PNG or JPEG of 1, 3 or 4 interleaved channels of display values.
EMBERLINE_API void write_picture(const std::string& path, const uint8_t* values, int width,
                                 int height, int channels);

// The difference between a picture x and a reference r, as reported by `emberline compare`.
struct Comparison {
  double mse = 0, rmse = 0;
  double relmse = 0, relmse_epsilon = 0;
  double relmse_trimmed = 0;  // excluding the worst 0.1 % of pixels
  double signed_bias = 0;     // sum(x - r) / sum(r)
  double psnr = 0, ssim = 0;  // computed from display values, like `flip`
  double flip = 0;
  double max_abs = 0;
  uint64_t different_pixels = 0;
  uint64_t non_finite = 0;  // pixels with a NaN or infinity; the values above exclude them
};
// Compares two pictures. Both must be linear Rec. 709, interleaved R G B, top row first (see
// RenderedPicture::rec709()). `exposure` is in stops. Throws UsageError if there are no pixels or
// the exposure is not from -100 to 100; also RenderError.
EMBERLINE_API Comparison compare(const float* image, const float* reference, int width, int height,
                                 double exposure = 0);
// Returns the FLIP error of each pixel, 0 to 1; 0 where either picture is not finite.
EMBERLINE_API std::vector<float> flip(const float* image, const float* reference, int width,
                                      int height, double exposure = 0);

// The options of `emberline study`, with the same names and texts. Since 1.1.0.
class EMBERLINE_API StudyRequest {
 public:
  // The study writes its results to the folder. A stopped study is resumed from there.
  explicit StudyRequest(std::string folder);
  StudyRequest(const StudyRequest& other);
  StudyRequest(StudyRequest&& other) noexcept;
  StudyRequest& operator=(StudyRequest other) noexcept;
  ~StudyRequest();

  // Accepts "drivers", "estimators", "samplers", "spp" or "seconds", "seeds", "baseline",
  // "denoise", "separate", "reference", "reference-spp", "cache" and "restart". The entries of a
  // list are separated by commas; flags take "yes" or "no". Throws UsageError.
  StudyRequest& set(std::string_view name, std::string_view text);

 private:
  friend struct Access;
  struct State;
  std::unique_ptr<State> state_;
};
// The result of one method with one seed and one budget: a row of study.csv.
struct StudyRow {
  std::string method, driver, sampler, estimator, allocation;
  bool unbiased = false, denoised = false;
  uint32_t seed = 0;
  std::string failure;  // empty if the run did not fail; a failed run has one row, without numbers
  double budget = 0;    // samples per pixel, or seconds
  uint64_t samples = 0;
  double mean_samples = 0;                             // per pixel
  double wall_s = 0, cpu_s = 0;                        // time spent on rendering
  std::optional<double> estimate;                      // the method's own estimate of its error
  std::vector<std::pair<std::string, double>> errors;  // "mse", "relmse", ... "signed_bias"
};
struct StudyTable {
  std::vector<StudyRow> rows;  // sorted by seed, then method, then budget
  std::string text;            // summary for people: each method's error, slope and speedup
  bool complete = false;       // false if the study was stopped; the same call resumes it
};
// Renders the scene with every method, seed and budget, and writes study.csv, study.json and
// study.html into the folder. `settings` apply to all frames. Only settings of samples, view,
// light, scene loading, buckets and the first seed are allowed. `on_samples` is called with the
// number of new samples, from any thread, and possibly from several threads at once. Throws
// UsageError, InputError, RenderError, and Stopped if the study is stopped before the reference is
// finished. Since 1.1.0.
EMBERLINE_API StudyTable study(const std::string& scene, const Settings& settings,
                               const StudyRequest& request, const Resources& resources = {},
                               const std::stop_token& stop = {},
                               const std::function<void(uint64_t)>& on_samples = {});

// A per-pixel quantity that a heatmap can show. Since 1.1.0.
struct HeatmapKind {
  std::string name;  // "samples", "error", "stop", ...
  std::string summary;
  std::vector<std::string> channels;  // channels that a picture must have
};
// Returns all kinds. The first is the default.
EMBERLINE_API std::vector<HeatmapKind> heatmap_kinds();
// Returns one value per pixel, top row first; NaN where the quantity is undefined. Throws
// UsageError for an unknown name, InputError if the picture lacks the channels. Since 1.1.0.
EMBERLINE_API std::vector<float> heatmap_values(const Picture& picture,
                                                const std::string& of = "samples");

// A picture of display values (sRGB): interleaved R G B, top row first. Since 1.1.0.
struct DisplayedPicture {
  int width = 0, height = 0;
  std::vector<uint8_t> values;
};
// The appearance of a heatmap. The members correspond to the options of `emberline heatmap`. Since
// 1.1.0.
struct HeatmapLook {
  std::string colors = "grey";  // or viridis, inferno, magma, turbo
  std::optional<std::pair<double, double>>
      range;           // range of the colours; absent: derived from the values
  bool log = false;    // whether the scale is logarithmic
  bool plain = false;  // whether to omit the legend below the pixels
};
// Draws a heatmap. write_picture() then writes the same file as the command. Throws what
// heatmap_values() throws. Since 1.1.0.
EMBERLINE_API DisplayedPicture heatmap(const Picture& picture, const std::string& of = "samples",
                                       const HeatmapLook& look = {});

// How messages, exceptions and help texts spell settings: noise-threshold, or noise_threshold as a
// Python argument.
enum class SettingSpelling { kPlain, kUnderscores };
// Sets the spelling for the whole process. Since 1.1.0.
EMBERLINE_API void spell_settings(SettingSpelling spelling);

enum class Message { kError, kWarning, kInfo };
// Redirects messages to `log`, which may be called from any thread, but never from two threads at
// once. If `log` is null, messages go to stderr, which is the default.
EMBERLINE_API void set_log(std::function<void(Message, std::string_view)> log);

}  // namespace emberline::api
