#include "renderer/library/emberline.h"

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

#include "io/edits_file.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/names.h"
#include "renderer/core/version.h"
#include "renderer/description/framing.h"
#include "renderer/drivers/frame_plan.h"
#include "renderer/drivers/setting_table.h"
#include "renderer/film/shared_samples.h"
#include "renderer/frame/bucket_schedule.h"
#include "renderer/frame/frame_scene.h"
#include "renderer/library/translated.h"
#include "renderer/process/run_limits.h"
#include "renderer/process/stop_request.h"
#include "renderer/scene/editable_scene.h"

namespace emberline::api {

struct Settings::State {
  FrameSettings settings;
};

struct Scene::State {
  std::shared_ptr<MemoryBudget> memory;
  SceneBuildOptions build;
  CoverageReport coverage;
  WorldBounds bounds;
  AnimationEdit animation;  // that it was opened with
  std::unique_ptr<EditableScene> scene;
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

SceneBuildOptions editable(SceneBuildOptions options) {
  options.editable = true;
  return options;
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
    throw emberline::UsageError("working-space: the command alone has another");
  if (settings.light_groups)
    throw emberline::UsageError("light-groups: the command alone has them");
  if (!settings.cryptomattes.empty())
    throw emberline::UsageError("cryptomatte: the command alone has it");
  if (!settings.catchers.empty() || !settings.holdouts.empty())
    throw emberline::UsageError("{}: the command alone has them",
                                settings.catchers.empty() ? "holdout" : "catcher");
  if (settings.denoise) {
    throw emberline::UsageError(
        "denoise: the command alone does; the channels that it takes come with aov denoising");
  }
}

void check_suits(const FramePlan& plan, const SceneBuildOptions& built) {
  if (plan.build.show_backfaces != built.show_backfaces) {
    throw emberline::UsageError("backfaces: the scene was loaded with another value");
  }
  if (plan.build.isa != built.isa) {
    throw emberline::UsageError("isa: the scene was loaded with another value");
  }
  if (plan.build.unread_uv && !built.unread_uv) {
    throw emberline::UsageError(
        "integrator, aov: the scene was loaded without the texture coordinates that they show; "
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
  views.cameras = state.scene->original().cameras;
  if (views.cameras.empty()) {
    const double aspect = double(settings.width) / settings.height;
    views.cameras.push_back(framing_camera(state.bounds, aspect));
  }
  const CameraDescription camera = choose_camera(settings, views, state.scene->edits());
  return create_camera(settings, camera, state.scene->scene());
}

Picture render_picture(const Access::SceneState& state, const FrameSettings& settings,
                       const Resources& resources, const std::stop_token& stop,
                       const std::function<void(const Progress&)>& watch,
                       const std::stop_token& give_up) {
  const FramePlan plan(settings);
  check_is_of_library(settings);
  check_suits(plan, state.build);
  FrameRender render(driver_factory(plan.driver->name, plan.driver_settings));
  const uint64_t channels = film_channels(plan.aovs).size();
  MemoryReservation memory(state.memory, MemoryPart::kFilm);
  memory.add(bytes_of(uint64_t(plan.crop.area()),
                      render.bytes_per_pixel(plan.aovs) + (channels + 4) * sizeof(float)),
             "a frame of " + std::to_string(plan.crop.width()) + "x" +
                 std::to_string(plan.crop.height()) + " pixels");
  const int threads = arena_threads(resources);
  const BucketsAtWork at_work = buckets_at_work(plan.crop, settings.bucket_size, threads);
  memory.add(bytes_of(at_work.pixels(), render.tile_bytes_per_pixel(plan.aovs)),
             "working on buckets of " + std::to_string(at_work.width) + "x" +
                 std::to_string(at_work.height) + " pixels");
  Picture picture = blank_picture(plan);
  const Camera camera = camera_of(state, settings);
  tbb::task_arena arena(threads);
  const EndOfFrame end(stop, give_up, settings.time_limit_s);
  const Frame frame = arena.execute(
      [&] { return plan.frame(state.scene->scene(), camera, {.stop = end.token()}); });
  PictureObserver observer(picture, plan.crop, end, render.by_tiles(), watch);
  FrameCounters counters;
  arena.execute([&] {
    counters = render.render(frame, observer, end.token());
    if (!give_up.stop_requested()) render.deliver(observer);
  });
  if (give_up.stop_requested()) throw Stopped("the frame was given up");
  sum_shared(plan.crop, picture.channels, picture.values);
  picture.samples = counters.samples;
  picture.rays = counters.rays.total();
  picture.non_finite_samples = counters.non_finite_samples;
  picture.error_estimate = render.error_estimate();
  picture.complete = render.is_complete(counters, end.cause());
  return picture;
}

}  // namespace

std::string version() { return kEmberlineVersion; }

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
    all.push_back({row.name, row.type, row.help, row.values, of_scene});
  }
  return all;
}

Scene::Scene(const std::string& path, const Settings& given, const Resources& resources,
             const std::stop_token& stop)
    : state_(std::make_unique<State>()) {
  translated([&] {
    FrameSettings settings = Access::of(given);
    settings.scene = path;
    check_is_of_library(settings);
    const LoadLimits limits = limits_of({resources.memory_bytes, resources.load_timeout_s}, path);
    state_->memory = limits.memory;
    state_->build = editable(FramePlan(settings).build);
    LoadProgress progress({}, stop, limits);
    tbb::task_arena(arena_threads(resources)).execute([&] {
      SceneEdits edits = load_edits(settings, progress);
      apply_animation(edits.animation, settings);
      state_->animation = edits.animation;
      SceneDescription description = load_scene(settings, progress, true, need_tangents(edits));
      choose_variant(settings, description, edits);
      state_->coverage = description.coverage;
      if (description.cameras.empty()) state_->bounds = framed_bounds(description);
      state_->scene =
          std::make_unique<EditableScene>(std::move(description), state_->build, progress);
      state_->scene->set(edits);
    });
  });
}
Scene::Scene(Scene&& other) noexcept = default;
Scene& Scene::operator=(Scene&& other) noexcept = default;
Scene::~Scene() = default;

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
      throw emberline::InputError(edits.animation.place, "a scene is posed when it is opened");
    }
    state_->scene->set(edits);
  });
}

std::vector<std::string> Scene::lights() const {
  return names_of(state_->scene->original().lights);
}
std::vector<std::string> Scene::materials() const {
  return names_of(state_->scene->original().materials);
}
std::vector<std::string> Scene::cameras() const {
  return names_of(state_->scene->original().cameras);
}
std::vector<std::string> Scene::approximated() const { return state_->coverage.approximated; }
std::vector<std::string> Scene::ignored() const { return state_->coverage.ignored; }

Picture render(const Scene& scene, const Settings& settings, const Resources& resources,
               const std::stop_token& stop, const std::function<void(const Progress&)>& watch,
               const std::stop_token& give_up) {
  return translated([&] {
    return render_picture(Access::of(scene), Access::of(settings), resources, stop, watch, give_up);
  });
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
