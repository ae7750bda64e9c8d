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
#include <vector>

#if defined(_WIN32)
#define EMBERLINE_API
#else
#define EMBERLINE_API __attribute__((visibility("default")))
#endif

// Semantic: what is built against 1.x runs with every later 1.y.
#define EMBERLINE_VERSION_MAJOR 1
#define EMBERLINE_VERSION_MINOR 0
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
  int threads = 0;                       // at most; 0: one for each core
  std::optional<uint64_t> memory_bytes;  // of a scene and its frame; absent: as the command has it
  std::optional<double> load_timeout_s;  // absent: none
};

// A loaded scene, which follows edits without being built again.
class EMBERLINE_API Scene {
 public:
  // Of the settings: env and its like, backfaces, lenient, resource-root, variant, edits, animation
  // and its time or frame, and whether the integrator shows texture coordinates. Throws UsageError,
  // InputError, RenderError, Stopped.
  explicit Scene(const std::string& path, const Settings& settings = {},
                 const Resources& resources = {}, const std::stop_token& stop = {});
  Scene(Scene&& other) noexcept;
  Scene& operator=(Scene&& other) noexcept;
  ~Scene();

  // All that differs from the file from now on, as --edits reads it (JSON), but for the time: the
  // scene stays as it was posed when it was opened, and another "animation" is refused. Throws
  // InputError; the scene is then as it was.
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
  std::unique_ptr<State> state_;
};

// How far a frame has come.
struct Progress {
  uint64_t samples = 0;
  std::optional<double> error_estimate;  // of the picture of now, where the driver makes one
  // R G B A of every pixel, rows from the top, linear; null: this driver shows no picture before it
  // is done.
  const float* rgba = nullptr;
  int width = 0, height = 0;  // of what is rendered
};

struct Picture {
  int width = 0, height = 0;          // of what was rendered: the crop, or the frame
  int x = 0, y = 0;                   // its corner in the frame
  std::vector<std::string> channels;  // "R", "G", "B", "A", "samples", and what "aov" asks for
  std::vector<float> values;          // interleaved, rows from the top; linear Rec. 709
  uint64_t samples = 0, rays = 0;
  uint64_t non_finite_samples = 0;       // which count as black
  std::optional<double> error_estimate;  // expected RMS error as displayed, 0 to 1
  bool complete = false;                 // false: stopped before its end
  int frame_width = 0, frame_height = 0;

  const float* pixel(int column, int row) const {
    return &values[(size_t(row) * size_t(width) + size_t(column)) * channels.size()];
  }
};

// `watch` is called by any thread, one call at a time: with `bucket` after each of its tiles, with
// the other drivers at every pause, while nothing renders. A stop brings what there is by then;
// one of `give_up` brings nothing, sooner, but Stopped. "time-limit" counts from here. Throws
// UsageError, InputError, RenderError, and what `watch` throws.
EMBERLINE_API Picture render(const Scene& scene, const Settings& settings,
                             const Resources& resources = {}, const std::stop_token& stop = {},
                             const std::function<void(const Progress&)>& watch = {},
                             const std::stop_token& give_up = {});

// An EXR with all its channels, or a PNG, JPEG, HDR, WebP or TIFF, whose 8 bits become linear.
// Throws InputError, Stopped.
EMBERLINE_API Picture read_picture(const std::string& path, const Resources& resources = {},
                                   const std::stop_token& stop = {});
// Into a file that appears whole or not at all. EXR holds every channel as it is; PNG and JPEG show
// R G B after so many stops, as the command's files do ($OCIO). Throws UsageError, RenderError.
EMBERLINE_API void write_picture(const std::string& path, const Picture& picture,
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
// Of linear R G B, interleaved, rows from the top. The exposure is in stops. Throws UsageError for
// no pixels, or an exposure that is not finite; RenderError.
EMBERLINE_API Comparison compare(const float* image, const float* reference, int width, int height,
                                 double exposure = 0);
// FLIP's error of each pixel, 0 to 1; 0 where one of the two is not finite.
EMBERLINE_API std::vector<float> flip(const float* image, const float* reference, int width,
                                      int height, double exposure = 0);

enum class Message { kError, kWarning, kInfo };
// Where messages go, from any thread, one at a time; null: to stderr, as they do until this is
// called.
EMBERLINE_API void set_log(std::function<void(Message, std::string_view)> log);

}  // namespace emberline::api
