#include "renderer/api/emberline.h"

#include <tbb/info.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <span>
#include <thread>
#include <utility>

#include "io/json/edits_file.h"
#include "renderer/api/translated.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/names.h"
#include "renderer/core/setting_names.h"
#include "renderer/core/version.h"
#include "renderer/description/framing.h"
#include "renderer/drivers/bucket_schedule.h"
#include "renderer/drivers/driver_table.h"
#include "renderer/engine/film_memory.h"
#include "renderer/engine/frame_plan.h"
#include "renderer/engine/frame_scene.h"
#include "renderer/engine/open_scene.h"
#include "renderer/engine/render_job.h"
#include "renderer/engine/run_limits.h"
#include "renderer/engine/setting_rules.h"
#include "renderer/engine/stop_request.h"
#include "renderer/film/shared_samples.h"

namespace emberline::api {

struct Settings::State {
  FrameSettings settings;
};

struct Scene::State {
  State(const std::string& path, const Settings& given, const Resources& resources,
        const std::stop_token& stop, bool poses);
  void pose(const FrameSettings& wanted, const std::stop_token& stop);

  Resources resources;
  FrameSettings settings;  // that it was opened with
  LoadLimits limits;
  SceneBuildOptions build;
  WorldBounds bounds;
  AnimationEdit animation;  // that it was opened with
  std::unique_ptr<OpenScene> open;
};

struct Access {
  using SceneState = Scene::State;
  static const FrameSettings& of(const Settings& settings) { return settings.state_->settings; }
  static const SceneState& of(const Scene& scene) { return *scene.state_; }
};

namespace {

// TBB has no more than the machine, and says so on stderr when it is asked for them.
int arena_threads(const Resources& resources) {
  const int most = tbb::info::default_concurrency();
  return resources.threads > 0 ? std::min(resources.threads, most) : most;
}

template <typename List>
std::vector<std::string> names_of(const List& list) {
  std::vector<std::string> names;
  for (const auto& entry : list) names.push_back(entry.name);
  return names;
}

// Asks for the end when the caller does, or when the time is over.
class EndOfFrame {
 public:
  EndOfFrame(const std::stop_token& stop, const std::stop_token& give_up,
             std::optional<double> limit_s)
      : by_caller_(stop, [this] { request_.request(PixelStop::kUser); }),
        given_up_(give_up, [this] { request_.request(PixelStop::kUser); }) {
    if (!limit_s) return;
    clock_ = std::jthread([this, limit_s](const std::stop_token& over) {
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, over, std::chrono::duration<double>(*limit_s), [] { return false; });
      if (!over.stop_requested()) request_.request(PixelStop::kTimeLimit);
    });
  }
  std::stop_token token() const { return request_.token(); }
  PixelStop cause() const { return request_.cause(); }

 private:
  StopRequest request_;
  std::stop_callback<std::function<void()>> by_caller_, given_up_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::jthread clock_;
};

// Puts finished tiles into a picture, and shows it on its way.
class PictureObserver final : public FrameObserver {
 public:
  PictureObserver(Picture& picture, const Rect& crop, const EndOfFrame& end, bool by_tiles,
                  const std::function<void(const Progress&)>& watch)
      : picture_(picture), crop_(crop), end_(end), by_tiles_(by_tiles), watch_(watch) {}

  void tile_finished(const FilmTile& tile) override {
    put_channels(tile, crop_, picture_.values);  // no pixel is in two tiles
    if (!watch_ || !by_tiles_) return;
    const std::lock_guard lock(mutex_);
    watch_({samples_, std::nullopt, nullptr, crop_.width(), crop_.height()});
  }
  void samples_finished(uint64_t count) override { samples_ += count; }
  void picture_changed(const FrameProgress& now, const FramePicture& picture) override {
    if (!watch_) return;
    rgba_.resize(4 * size_t(crop_.area()));
    picture.resolve(rgba_);
    watch_({now.samples, now.error_estimate, rgba_.data(), crop_.width(), crop_.height()});
  }
  PixelStop stop_cause() const override { return end_.cause(); }

 private:
  Picture& picture_;
  const Rect crop_;
  const EndOfFrame& end_;
  const bool by_tiles_;
  const std::function<void(const Progress&)>& watch_;
  std::vector<float> rgba_;
  std::atomic<uint64_t> samples_{0};
  std::mutex mutex_;
};

Picture blank_picture(const FramePlan& plan) {
  Picture picture;
  picture.width = plan.crop.width();
  picture.height = plan.crop.height();
  picture.x = plan.crop.x0;
  picture.y = plan.crop.y0;
  picture.frame_width = plan.width;
  picture.frame_height = plan.height;
  picture.channels = film_channel_names(plan.aovs);
  picture.values.resize(size_t(plan.crop.area()) * picture.channels.size());
  return picture;
}

// What a Picture, whose colours are Rec. 709, has no place for.
void check_is_of_library(const FrameSettings& settings) {
  if (settings.working_space != WorkingSpace::kRec709)
    throw emberline::UsageError("`working-space`: the command alone has another");
  if (settings.light_groups)
    throw emberline::UsageError("`light-groups`: the command alone has them");
  if (!settings.cryptomattes.empty())
    throw emberline::UsageError("`cryptomatte`: the command alone has it");
  if (settings.denoise) {
    throw emberline::UsageError(
        "`denoise`: the command alone does; the channels that it takes come with `aov` denoising");
  }
}

// Between the settings of a frame and those that its scene was opened with.
void check_suits(const FrameSettings& settings, const FramePlan& plan,
                 const Access::SceneState& scene) {
  const SceneBuildOptions& built = scene.build;
  if (settings.catchers != scene.settings.catchers) {
    throw emberline::UsageError("`catcher`: the scene was loaded with another value");
  }
  if (settings.holdouts != scene.settings.holdouts) {
    throw emberline::UsageError("`holdout`: the scene was loaded with another value");
  }
  if (plan.build.show_backfaces != built.show_backfaces) {
    throw emberline::UsageError("`backfaces`: the scene was loaded with another value");
  }
  if (plan.build.isa != built.isa) {
    throw emberline::UsageError("`isa`: the scene was loaded with another value");
  }
  if (plan.build.unread_uv && !built.unread_uv) {
    throw emberline::UsageError(
        "`integrator`, `aov`: the scene was loaded without the texture coordinates that they show; "
        "load it with these settings");
  }
}

std::shared_ptr<const Image> image_of(const Scene::Environment& environment) {
  const int width = environment.width, height = environment.height;
  if (width <= 0 || height <= 0) throw emberline::UsageError("environment: no texels");
  auto image = std::make_shared<Image>();
  image->name = "the environment";
  image->width = width;
  image->height = height;
  image->channels = 3;
  image->type = TexelType::kFloat;
  const size_t count = 3 * size_t(width) * size_t(height);
  for (size_t i = 0; i < count; ++i) {
    const float value = environment.rgb[i];
    if (std::isfinite(value) && value >= 0.0f) continue;
    const size_t texel = i / 3;
    throw emberline::UsageError("environment: {} at column {} of row {}", value,
                                texel % size_t(width), texel / size_t(width));
  }
  const auto bytes = std::as_bytes(std::span(environment.rgb, count));
  image->texels.assign(bytes.begin(), bytes.end());
  return image;
}

// What the settings and the scene's edits look through.
Camera camera_of(const Access::SceneState& state, const FrameSettings& settings) {
  SceneDescription views;
  views.cameras = state.open->editable().original().cameras;
  if (views.cameras.empty()) {
    const double aspect = double(settings.width) / settings.height;
    views.cameras.push_back(framing_camera(state.bounds, aspect));
  }
  const CameraDescription camera = choose_camera(settings, views, state.open->editable().edits());
  return create_camera(settings, camera, state.open->scene());
}

Picture render_picture(const Access::SceneState& state, const FrameSettings& settings,
                       const Resources& resources, const std::stop_token& stop,
                       const std::function<void(const Progress&)>& watch,
                       const std::stop_token& give_up) {
  const FramePlan plan(settings);
  check_is_of_library(settings);
  check_suits(settings, plan, state);
  const DriverFactory drivers = plan.drivers();
  const uint64_t channels = film_channels(plan.aovs).size();
  MemoryReservation memory(state.limits.memory, MemoryPart::kFilm);
  const uint64_t shown =
      drivers.tiles ? 0 : shown_layer_bytes_per_pixel(PathLayers(plan.aovs).list().size());
  memory.add(bytes_of(uint64_t(plan.crop.area()), kept_bytes_per_pixel(drivers, plan.aovs) +
                                                      (channels + 4) * sizeof(float) + shown),
             "a frame of " + std::to_string(plan.crop.width()) + "x" +
                 std::to_string(plan.crop.height()) + " pixels");
  const int tile = tile_size(*plan.driver, settings.bucket_size);
  memory.add(bucket_list_bytes(plan.crop, tile), "the list of its buckets");
  const int threads = arena_threads(resources);
  const BucketsAtWork at_work = buckets_at_work(plan.crop, tile, threads);
  memory.add(bytes_of(at_work.pixels(), tile_bytes_per_pixel(drivers, plan.aovs)),
             "working on buckets of " + std::to_string(at_work.width) + "x" +
                 std::to_string(at_work.height) + " pixels");
  Picture picture = blank_picture(plan);
  const Camera camera = camera_of(state, settings);
  tbb::task_arena arena(threads);
  const EndOfFrame end(stop, give_up, settings.time_limit_s);
  const std::unique_ptr<RenderJob> job =
      arena.execute([&] { return plan.prepare(*state.open, camera, end.token()); });
  PictureObserver observer(picture, plan.crop, end, job->by_tiles(), watch);
  const RenderResult result = arena.execute([&] {
    RenderResult rendered = job->render(observer, end.token());
    if (!give_up.stop_requested()) job->deliver(observer);
    return rendered;
  });
  const FrameCounters& counters = result.counters;
  if (give_up.stop_requested()) throw Stopped("the frame was given up");
  sum_shared(plan.crop, picture.channels, picture.values);
  warn_of_optics(counters.optics);
  picture.samples = counters.samples;
  picture.rays = counters.rays.total();
  picture.non_finite_samples = counters.non_finite_samples;
  picture.error_estimate = job->error_estimate();
  picture.complete = result.complete;
  return picture;
}

}  // namespace

std::string version() { return kEmberlineVersion; }

void check_resources(const Resources& resources) {
  if (resources.threads < 0 || resources.threads > kMostThreads) {
    throw emberline::UsageError("threads: {} is not from 1 to {}, nor 0 for all of them",
                                resources.threads, kMostThreads);
  }
  if (resources.memory_bytes == 0) throw emberline::UsageError("`memory-limit`: 0 is not a size");
  const double seconds = resources.load_timeout_s.value_or(1.0);
  if (!(seconds >= kLeastLoadTimeout && seconds <= kMostLoadTimeout)) {
    throw emberline::UsageError("`load-timeout`: {} is not a number from {} to {}", seconds,
                                kLeastLoadTimeout, kMostLoadTimeout);
  }
}

Settings::Settings() : state_(std::make_unique<State>()) {}
Settings::Settings(const Settings& other) : state_(std::make_unique<State>(*other.state_)) {}
Settings::Settings(Settings&& other) noexcept = default;
Settings& Settings::operator=(Settings other) noexcept {
  state_ = std::move(other.state_);
  return *this;
}
Settings::~Settings() = default;

Settings& Settings::set(std::string_view name, std::string_view text) {
  translated([&] {
    find_named(setting_table(), "settings", "setting", name).read(state_->settings, text);
  });
  return *this;
}

std::string Settings::get(std::string_view name) const {
  return translated([&] {
    return find_named(setting_table(), "settings", "setting", name).text(state_->settings);
  });
}

Settings& Settings::read(const std::string& path) {
  FrameSettings read = state_->settings;
  translated([&] { read_settings(path, read); });
  state_->settings = std::move(read);
  return *this;
}

std::vector<Settings::Help> Settings::help() {
  std::vector<Help> all;
  for (const Setting& row : setting_table()) {
    const bool of_scene = row.group == SettingGroup::kLoading ||
                          row.group == SettingGroup::kEdits || row.group == SettingGroup::kLight;
    const RulesHelp& rules = rules_of(row);
    all.push_back(
        {row.name, row.type, spelled(row.help + rules.rules), spelled(rules.values), of_scene});
  }
  return all;
}

Scene::State::State(const std::string& path, const Settings& given, const Resources& with,
                    const std::stop_token& stop, bool poses)
    : resources(with), settings(Access::of(given)) {
  check_resources(resources);
  settings.scene = path;
  check_is_of_library(settings);
  limits = limits_of({resources.memory_bytes, resources.load_timeout_s}, path);
  build = FramePlan(settings).build;
  build.editable = true;
  LoadProgress progress({}, stop, limits);
  tbb::task_arena(arena_threads(resources)).execute([&] {
    ReadScene read(settings, load_edits(settings, progress),
                   {.build = build, .edits = true, .poses = poses}, progress);
    const SceneEdits edits = read.edits();
    animation = edits.animation;
    if (read.description().cameras.empty()) bounds = framed_bounds(read.description());
    open = std::move(read).build(progress);
    open->editable().set(edits);
  });
}

void Scene::State::pose(const FrameSettings& wanted, const std::stop_token& stop) {
  FrameSettings at = settings;
  at.variant.clear();  // the edits have it
  at.animation = wanted.animation;
  at.time = wanted.time;
  at.frame = wanted.frame;
  at.fps = wanted.fps;
  at.shutter = wanted.shutter;
  at.aovs = wanted.aovs;
  SceneEdits edits = open->editable().edits();
  edits.animation = {};
  LoadProgress progress({}, stop, limits);
  tbb::task_arena(arena_threads(resources)).execute([&] {
    ReadScene read = open->read(at, edits, progress);
    WorldBounds posed;
    if (read.description().cameras.empty()) posed = framed_bounds(read.description());
    open->pose(std::move(read), progress);
    bounds = posed;
  });
}

Scene::Scene(std::unique_ptr<State> state) : state_(std::move(state)) {}
Scene::Scene(const std::string& path, const Settings& settings, const Resources& resources,
             const std::stop_token& stop)
    : Scene(translated(
          [&] { return std::make_unique<State>(path, settings, resources, stop, false); })) {}
Scene Scene::animated(const std::string& path, const Settings& settings, const Resources& resources,
                      const std::stop_token& stop) {
  return Scene(
      translated([&] { return std::make_unique<State>(path, settings, resources, stop, true); }));
}
Scene::Scene(Scene&& other) noexcept = default;
Scene& Scene::operator=(Scene&& other) noexcept = default;
Scene::~Scene() = default;

void Scene::pose(const Settings& settings, const std::stop_token& stop) {
  translated([&] {
    if (!state_->open->can_pose()) {
      throw emberline::UsageError(
          "pose: the scene has no animations, or was not opened as an animated one");
    }
    state_->pose(Access::of(settings), stop);
  });
}

void Scene::edit(std::string_view json) { edit(json, {}); }

void Scene::edit(std::string_view json, const Environment& environment) {
  translated([&] {
    SceneEdits edits = parse_edits(json, "the edits");
    if (environment.rgb) {
      if (edits.environment.image) {
        throw emberline::UsageError("environment: the edits name a file as well");
      }
      edits.environment.image = image_of(environment);
    }
    if (edits.animation != AnimationEdit() && edits.animation != state_->animation) {
      throw emberline::InputError(edits.animation.place, "a scene is posed by its settings");
    }
    state_->open->editable().set(edits);
  });
}

std::vector<std::string> Scene::lights() const {
  return names_of(state_->open->editable().original().lights);
}
std::vector<std::string> Scene::materials() const {
  return names_of(state_->open->editable().original().materials);
}
std::vector<std::string> Scene::cameras() const {
  return names_of(state_->open->editable().original().cameras);
}
std::vector<std::string> Scene::approximated() const {
  return state_->open->coverage().approximated;
}
std::vector<std::string> Scene::ignored() const { return state_->open->coverage().ignored; }

Picture render(const Scene& scene, const Settings& settings, const Resources& resources,
               const std::stop_token& stop, const std::function<void(const Progress&)>& watch,
               const std::stop_token& give_up) {
  return translated([&] {
    check_resources(resources);
    return render_picture(Access::of(scene), Access::of(settings), resources, stop, watch, give_up);
  });
}

void spell_settings(SettingSpelling spelling) {
  constexpr emberline::SpellSetting kPlain = [](std::string_view name) {
    return std::string(name);
  };
  constexpr emberline::SpellSetting kUnderscores = [](std::string_view name) {
    std::string argument(name);
    std::ranges::replace(argument, '-', '_');
    return argument;
  };
  emberline::spell_settings(spelling == SettingSpelling::kUnderscores ? kUnderscores : kPlain);
}

void set_log(std::function<void(Message, std::string_view)> log) {
  if (!log) return set_log_sink({});
  set_log_sink([log = std::move(log)](LogKind kind, std::string_view message) {
    log(kind == LogKind::kError     ? Message::kError
        : kind == LogKind::kWarning ? Message::kWarning
                                    : Message::kInfo,
        message);
  });
}

}  // namespace emberline::api
