// Emberline as a library: a scene and settings in, pictures and estimates out.
//
//   using namespace emberline::api;
//   Settings settings;
//   settings.set("driver", "adaptive").set("noise-threshold", "0.01");
//   Scene scene("shot.glb", settings);
//   scene.edit(R"({"emberline_edits": 1, "environment": {"strength": 0.5}})");
//   const Picture picture = render(scene, settings);
//
// Equal scene, edits and settings give equal bits, whatever the threads, and those of the command.
// Objects may be used from one thread at a time; different ones from different threads at once: two
// scenes, two frames of one scene. What is wrong is thrown; nothing is kept when something throws.
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

// Semantic: what is built against 1.x runs with every later 1.y.
#define EMBERLINE_VERSION_MAJOR 1
#define EMBERLINE_VERSION_MINOR 1
#define EMBERLINE_VERSION_PATCH 0

namespace emberline::api {

// Of the library that runs, which need not be that of this header: "1.0.0".
EMBERLINE_API std::string version();

// One line: what, where, what to do.
struct EMBERLINE_API Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};
struct EMBERLINE_API UsageError : Error {  // a setting
  using Error::Error;
};
struct EMBERLINE_API InputError : Error {  // a file, or edits
  using Error::Error;
};
struct EMBERLINE_API RenderError : Error {  // memory, a file that cannot be written
  using Error::Error;
};
struct EMBERLINE_API Stopped : Error {  // a load, or a frame that was given up
  using Error::Error;
};

// Everything that decides a frame, by the names of the command's options ("spp", "look-from") and
// with their texts. `emberline render --help` lists them.
class EMBERLINE_API Settings {
 public:
  Settings();
  Settings(const Settings& other);
  Settings(Settings&& other) noexcept;
  Settings& operator=(Settings other) noexcept;
  ~Settings();

  // Of an option without value: "yes" or "no". Throws UsageError.
  Settings& set(std::string_view name, std::string_view text);
  // Empty: none is given. Throws UsageError for a name that there is not.
  std::string get(std::string_view name) const;
  // A file of --save-settings. Throws InputError.
  Settings& read(const std::string& path);

  struct Help {
    std::string name;
    std::string type;    // of its value; empty: on or off
    std::string help;    // in brackets what holds where nothing is given
    std::string values;  // a line for each name that is valid
    bool of_scene;       // decides how a scene is loaded, and nothing afterwards
  };
  // Of every setting, as `emberline render --help` has it.
  static std::vector<Help> help();

 private:
  friend struct Access;
  struct State;
  std::unique_ptr<State> state_;
};

// What the machine gives; a frame does not depend on it.
struct Resources {
  int threads = 0;                       // at most, up to 4096; 0: one for each core
  std::optional<uint64_t> memory_bytes;  // of a scene and its frame; absent: as the command has it
  std::optional<double> load_timeout_s;  // .001 to 1e9; absent: none
};

// A loaded scene, which follows edits without being built again.
class EMBERLINE_API Scene {
 public:
  // Of the settings: env and its like, backfaces, lenient, resource-root, variant, edits, animation
  // and its time or frame, working-space, catcher, holdout, whether there is cryptomatte, and
  // whether the integrator shows texture coordinates.
  // Throws UsageError, InputError, RenderError, Stopped.
  explicit Scene(const std::string& path, const Settings& settings = {},
                 const Resources& resources = {}, const std::stop_token& stop = {});
  Scene(Scene&& other) noexcept;
  Scene& operator=(Scene&& other) noexcept;
  ~Scene();

  // The same for a scene that pose() puts into other poses: its file stays open, and what moves is
  // kept apart from what does not. Since 1.1.0.
  static Scene animated(const std::string& path, const Settings& settings = {},
                        const Resources& resources = {}, const std::stop_token& stop = {});
  // Puts a scene of animated() where its animation has it: of the settings animation, time or
  // frame, fps and shutter, and whether aov asks for velocities. The edits stay. Throws as the
  // constructor does; the scene is then as it was. Nobody may render it meanwhile. Since 1.1.0.
  void pose(const Settings& settings, const std::stop_token& stop = {});

  // All that differs from the file from now on, as --edits reads it (JSON), but for the time: the
  // scene stays as it is posed, and another "animation" is refused. Throws InputError; the scene is
  // then as it was.
  void edit(std::string_view json);
  // With an environment of these texels, which are copied: latitude-longitude as a file has it,
  // linear R G B, interleaved, rows from the top. Throws UsageError where one is not finite or
  // negative, or where the edits name a file as well.
  struct Environment {
    const float* rgb = nullptr;
    int width = 0, height = 0;
  };
  void edit(std::string_view json, const Environment& environment);
  // The file's names.
  std::vector<std::string> lights() const;
  std::vector<std::string> materials() const;
  std::vector<std::string> cameras() const;
  // What of the file is not honoured to the letter, a line each.
  std::vector<std::string> approximated() const;
  std::vector<std::string> ignored() const;

 private:
  friend struct Access;
  struct State;
  explicit Scene(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

// How far a frame has come.
struct Progress {
  uint64_t samples = 0;
  std::optional<double> error_estimate;  // for the picture as it is now, if the driver estimates it
  // R G B A of every pixel, rows from the top, linear; null: this driver shows no picture before it
  // is done.
  const float* rgba = nullptr;
  int width = 0, height = 0;  // of the rendered crop
};

struct Picture {
  int width = 0, height = 0;  // of what was rendered: the crop, or the frame
  int x = 0, y = 0;           // its corner in the frame
  // "R", "G", "B", "A", "samples", and what "aov" asks for; behind them, as the command's EXR names
  // them, "light.NAME.R" of "light-groups", "CryptoObject00.R" of "cryptomatte" (ids are the bits
  // of floats: matte_names()), "denoised.R" and "denoised.error" of "denoise".
  std::vector<std::string> channels;
  std::vector<float> values;  // interleaved, rows from the top; linear, in the working space
  uint64_t samples = 0, rays = 0;
  uint64_t non_finite_samples = 0;       // which count as black
  std::optional<double> error_estimate;  // expected RMS error as displayed, 0 to 1
  bool complete = false;                 // false: stopped before its end
  int frame_width = 0, frame_height = 0;

  const float* pixel(int column, int row) const {
    return &values[(size_t(row) * size_t(width) + size_t(column)) * channels.size()];
  }
};

// A picture that has what the command's file of it has beside its pixels: settings, working space,
// camera and names of mattes, as they were when it was rendered. Since 1.1.0.
class EMBERLINE_API RenderedPicture : public Picture {
 public:
  // Of nothing that was rendered: Rec. 709, as read_picture() has it.
  explicit RenderedPicture(Picture picture = {});

  // R G B as compare() and flip() take them: linear Rec. 709, whatever the working space is.
  // Throws UsageError for a picture without them.
  std::vector<float> rec709() const;

 private:
  friend struct Access;
  struct Record;
  std::shared_ptr<const Record> record_;
};

// The values are the bits of the command's EXR, in every channel. `watch` is called by any thread,
// one call at a time: with `bucket` after each of its tiles, with the other drivers at every pause,
// while nothing renders. A stop brings what there is by then; one of `give_up` brings nothing,
// sooner, but Stopped. "time-limit" counts from here. Throws UsageError, InputError, RenderError,
// and what `watch` throws.
EMBERLINE_API Picture render(const Scene& scene, const Settings& settings,
                             const Resources& resources = {}, const std::stop_token& stop = {},
                             const std::function<void(const Progress&)>& watch = {},
                             const std::stop_token& give_up = {});

// The file that a frame is saved to on its way, so that another run goes on from there to the same
// bits: the command's (`--checkpoint`), too. Since 1.1.0.
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
  bool resume = false;      // goes on with what is there; else the file is begun anew
  double interval_s = 300;  // between two savings
  // The file stays when the frame is done, for extend(); that of a part ("part", "sample-range")
  // always does, for merge().
  bool keep = false;

 private:
  RenderFiles() = default;  // render(scene, settings, {}) has Resources
};
// The same with such a file, which is saved at intervals, when the frame is stopped or given up,
// and when `watch` throws. `complete` is false for a frame that a time limit has ended: it can go
// on. The scene's files are read again, to know what the frame is of. Throws InputError where they
// have changed since the scene was loaded; UsageError for a file that is no checkpoint or, without
// `resume`, another frame's; InputError for one that `resume` cannot go on with, with what differs;
// RenderError where it cannot be made. What cannot be saved later is an error in the log, and for a
// part RenderError. One call at a time may have the file. Since 1.1.0.
EMBERLINE_API RenderedPicture render(const RenderFiles& files, const Scene& scene,
                                     const Settings& settings, const Resources& resources = {},
                                     const std::stop_token& stop = {},
                                     const std::function<void(const Progress&)>& watch = {},
                                     const std::stop_token& give_up = {});

// What the channels of "cryptomatte" show: of one kind the names in the scene and their ids, which
// the channels have as the bits of floats. Since 1.1.0.
struct MatteNames {
  std::string layer;                                  // "CryptoObject" of "CryptoObject00.R"
  std::vector<std::pair<std::string, uint32_t>> ids;  // each id once
};
// Of the kinds that the settings ask for, in their order, in the scene as it is posed and edited.
// Throws UsageError. Since 1.1.0.
EMBERLINE_API std::vector<MatteNames> matte_names(const Scene& scene, const Settings& settings);

// What a checkpoint is of. A scene that is loaded with these settings is its frame's, unless the
// program had edited it. Since 1.1.0.
struct StoredFrame {
  std::string scene;  // the file, where it was
  Settings settings;  // of the frame, and of how its scene was loaded
  std::vector<MatteNames> mattes;
};
// Throws InputError. Since 1.1.0.
EMBERLINE_API StoredFrame stored_frame(const std::string& checkpoint);

// More of a frame that is finished and whose checkpoint was kept. `more` has "spp",
// "noise-threshold" or "max-spp", and may have "time-limit". Where every pixel gets as many
// samples, the picture has the bits of a frame that was rendered so at once; an adaptive frame goes
// on from where it is. The checkpoint is the larger frame's from then on. An extension that was
// stopped goes on from CHECKPOINT.next when it is asked for again. Throws UsageError for less than
// the frame has and for other settings, InputError for a checkpoint that cannot go on, is damaged,
// or is of another scene; else as render(). Since 1.1.0.
EMBERLINE_API RenderedPicture extend(const std::string& checkpoint, const Scene& scene,
                                     const Settings& more, const Resources& resources = {},
                                     const std::stop_token& stop = {},
                                     const std::function<void(const Progress&)>& watch = {},
                                     const std::stop_token& give_up = {});

struct MergeRules {
  bool allow_holes = false;  // parts may be missing; pixels without samples are black
  bool strict = false;       // all parts are of one kind of machine
  bool parts = false;        // a channel "part": which checkpoint each pixel is of, 1 the first
};
// The frame whose parts ("part", "sample-range", or a "seed" each) these checkpoints have, as if it
// had been rendered at once. Throws InputError: which of them, and what it is about; Stopped. Since
// 1.1.0.
EMBERLINE_API RenderedPicture merge(const std::vector<std::string>& checkpoints,
                                    const MergeRules& rules = {}, const Resources& resources = {},
                                    const std::stop_token& stop = {});

// An EXR with all its channels, or a PNG, JPEG, HDR, WebP or TIFF, whose 8 bits become linear; what
// is in another working space becomes Rec. 709. Throws InputError, Stopped.
EMBERLINE_API Picture read_picture(const std::string& path, const Resources& resources = {},
                                   const std::stop_token& stop = {});
// Into a file that appears whole or not at all. EXR holds every channel as it is; PNG and JPEG show
// R G B after so many stops, as the command's files do ($OCIO). Colours are taken for Rec. 709.
// Throws UsageError, RenderError.
EMBERLINE_API void write_picture(const std::string& path, const Picture& picture,
                                 double exposure = 0);
// As the command writes it: an EXR with the working space, half, exr-compression and exr-parts, the
// names of mattes, camera and settings in its header; a PNG or JPEG of the denoised picture, if
// there is one, and a PNG with alpha if transparent. Since 1.1.0.
EMBERLINE_API void write_picture(const std::string& path, const RenderedPicture& picture,
                                 double exposure = 0);
// The same for PNG and JPEG of 1, 3 or 4 interleaved channels, which are as displayed.
EMBERLINE_API void write_picture(const std::string& path, const uint8_t* values, int width,
                                 int height, int channels);

// How far a picture is from a reference, as `emberline compare` says it.
struct Comparison {
  double mse = 0, rmse = 0;
  double relmse = 0, relmse_epsilon = 0;
  double relmse_trimmed = 0;  // without the worst 0.1 % of pixels
  double signed_bias = 0;     // sum(x - r) / sum(r)
  double psnr = 0, ssim = 0;  // these and `flip` as displayed
  double flip = 0;
  double max_abs = 0;
  uint64_t different_pixels = 0;
  uint64_t non_finite = 0;  // pixels with a NaN or infinity, left out of the above
};
// Of linear Rec. 709, R G B interleaved, rows from the top (RenderedPicture::rec709()). The
// exposure is in stops. Throws UsageError for no pixels, or an exposure that is not finite;
// RenderError.
EMBERLINE_API Comparison compare(const float* image, const float* reference, int width, int height,
                                 double exposure = 0);
// FLIP's error of each pixel, 0 to 1; 0 where one of the two is not finite.
EMBERLINE_API std::vector<float> flip(const float* image, const float* reference, int width,
                                      int height, double exposure = 0);

// What `emberline study` compares, by the names of its options and with their texts. Since 1.1.0.
class EMBERLINE_API StudyRequest {
 public:
  // Results go into the folder; a study that was stopped goes on in it.
  explicit StudyRequest(std::string folder);
  StudyRequest(const StudyRequest& other);
  StudyRequest(StudyRequest&& other) noexcept;
  StudyRequest& operator=(StudyRequest other) noexcept;
  ~StudyRequest();

  // "drivers", "estimators", "samplers", "spp" or "seconds", "seeds", "baseline", "denoise",
  // "separate", "reference", "reference-spp", "cache" and "restart". Lists have commas; of an
  // option without value "yes" or "no". Throws UsageError.
  StudyRequest& set(std::string_view name, std::string_view text);

 private:
  friend struct Access;
  struct State;
  std::unique_ptr<State> state_;
};
// A run of one method with one seed, at one budget, as a row of study.csv.
struct StudyRow {
  std::string method, driver, sampler, estimator, allocation;
  bool unbiased = false, denoised = false;
  uint32_t seed = 0;
  std::string failure;  // empty: none; else the run has this row alone, and no numbers
  double budget = 0;    // samples per pixel, or seconds
  uint64_t samples = 0;
  double mean_samples = 0;                             // of a pixel
  double wall_s = 0, cpu_s = 0;                        // of rendering
  std::optional<double> estimate;                      // what the method claims of its error
  std::vector<std::pair<std::string, double>> errors;  // "mse", "relmse", ... "signed_bias"
};
struct StudyTable {
  std::vector<StudyRow> rows;  // by seed, then method, then budget
  std::string text;            // for people: each method's error, slope and speedup
  bool complete = false;       // false: stopped; the same call goes on
};
// Renders the scene by every method, seed and budget, and writes study.csv, study.json and
// study.html into the folder. The settings are those of all frames: what a sample is, the view, the
// light, how the scene is loaded, buckets, and the first seed. `on_samples` is called by any
// thread, several at once, with how many more are done. Throws UsageError, also for other settings;
// InputError, RenderError, and Stopped before there is a reference. Since 1.1.0.
EMBERLINE_API StudyTable study(const std::string& scene, const Settings& settings,
                               const StudyRequest& request, const Resources& resources = {},
                               const std::stop_token& stop = {},
                               const std::function<void(uint64_t)>& on_samples = {});

// What a heatmap can show of each pixel. Since 1.1.0.
struct HeatmapKind {
  std::string name;  // "samples", "error", "stop", ...
  std::string summary;
  std::vector<std::string> channels;  // that a picture needs for it
};
// The first is the default.
EMBERLINE_API std::vector<HeatmapKind> heatmap_kinds();
// Of each pixel, rows from the top; NaN: it has none. Throws UsageError for a name that there is
// not, InputError for a picture without the channels. Since 1.1.0.
EMBERLINE_API std::vector<float> heatmap_values(const Picture& picture,
                                                const std::string& of = "samples");

// sRGB as displayed: R G B interleaved, rows from the top. Since 1.1.0.
struct DisplayedPicture {
  int width = 0, height = 0;
  std::vector<uint8_t> values;
};
// How a heatmap looks, by the options of `emberline heatmap`. Since 1.1.0.
struct HeatmapLook {
  std::string colors = "grey";                     // or viridis, inferno, magma, turbo
  std::optional<std::pair<double, double>> range;  // of the colours; absent: the values decide
  bool log = false;                                // logarithmic
  bool plain = false;                              // without legend, which is below the pixels
};
// The bytes of the command's picture before it is encoded; write_picture() of them is its file.
// Throws as heatmap_values() does. Since 1.1.0.
EMBERLINE_API DisplayedPicture heatmap(const Picture& picture, const std::string& of = "samples",
                                       const HeatmapLook& look = {});

// How messages, exceptions and help texts name settings: noise-threshold, or as arguments of
// Python, noise_threshold.
enum class SettingSpelling { kPlain, kUnderscores };
// Of the whole process. Since 1.1.0.
EMBERLINE_API void spell_settings(SettingSpelling spelling);

enum class Message { kError, kWarning, kInfo };
// Where messages go, from any thread, one at a time; null: to stderr, as they do until this is
// called.
EMBERLINE_API void set_log(std::function<void(Message, std::string_view)> log);

}  // namespace emberline::api
