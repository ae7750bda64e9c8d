#include "renderer/session/view_renderer.h"

#include <tbb/task_scheduler_observer.h>

#if defined(__linux__)
#include <sys/resource.h>
#include <unistd.h>
#endif

#include <algorithm>
#include <exception>
#include <new>
#include <utility>

#include "io/image/input.h"
#include "renderer/core/errors.h"
#include "renderer/lights/environment_light.h"

namespace emberline {
namespace {

// After relighting, the frame waits for this time, so that the next change of a light takes effect
// at once. Otherwise that change would wait for the driver's next pause, which is a few
// milliseconds away, or more while the driver plans a round.
constexpr auto kRelightPause = std::chrono::milliseconds(150);

std::exception_ptr no_picture_error() {
  return std::make_exception_ptr(
      RenderError("there is no picture to save yet; wait for the first one"));
}

}  // namespace

// While this object exists, threads that start working in the arena lower their own priority, so
// that the window's thread and software OpenGL get the processor immediately. An idle machine still
// renders at full speed. Uses Linux's nice value per thread; does nothing on other systems. The
// change is permanent, since only a privileged process could undo it.
class ViewRenderer::LowPriorityWorkers final : public tbb::task_scheduler_observer {
 public:
  explicit LowPriorityWorkers(tbb::task_arena& arena) : task_scheduler_observer(arena) {
    observe(true);
  }
  ~LowPriorityWorkers() override { observe(false); }

  void on_scheduler_entry(bool /*worker*/) override {
#if defined(__linux__)
    // A thread with this nice value gets about a quarter of a processor that it shares with a
    // thread of normal priority, and all of a processor that is otherwise idle. With a nice value
    // of 10, the thread would get only a tenth next to another busy program.
    constexpr int kNice = 5;
    const auto thread = id_t(gettid());
    if (getpriority(PRIO_PROCESS, thread) < kNice) (void)setpriority(PRIO_PROCESS, thread, kNice);
#endif
  }
};

ViewRenderer::ViewRenderer(PicturePublisher& publisher)
    : publisher_(publisher), thread_([this] { work(); }) {}

// Changes shared state under the lock and wakes the rendering thread.
template <class Change>
void ViewRenderer::update_state(const Change& update) {
  {
    const std::lock_guard lock(mutex_);
    update();
  }
  state_changed_.notify_all();
}

ViewRenderer::~ViewRenderer() {
  update_state([&] {
    ending_ = true;
    if (stop_) stop_->request(PixelStop::kUser);
  });
  thread_.join();
  for (std::promise<FilmCopy>& copy : copies_) copy.set_exception(no_picture_error());
}

void ViewRenderer::post(RenderRequest request, bool only_edits) {
  std::optional<LightMix> mix;
  if (only_edits) mix = mix_of(request);
  update_state([&] {
    if (mix && !request_) {
      relighting_ = RelightRequest{request.edit, request.posted, std::move(*mix)};
      pause_requested_ = true;
    } else {
      relighting_.reset();
      // The current frame may finish its first picture only if the new request differs in edits
      // alone. If a pending request is replaced here, its changes count too.
      let_first_picture_finish_ = only_edits && (!request_ || let_first_picture_finish_);
      request_ = std::move(request);
      if (stop_ && (!let_first_picture_finish_ || frame_published_))
        stop_->request(PixelStop::kUser);
    }
  });
}

// Returns how to mix the current frame's light groups to show the request, or nullopt if the groups
// cannot show it.
std::optional<LightMix> ViewRenderer::mix_of(const RenderRequest& request) const {
  std::shared_ptr<const LightGroups> groups;
  const EnvironmentEdit& environment = request.edits.environment;
  if (!environment.file.empty() && !environment.image) return std::nullopt;  // not read yet
  {
    const std::lock_guard lock(mutex_);
    if (request_ || groups_scene_ != request.scene) return std::nullopt;
    groups = groups_;
  }
  return groups ? groups->mix(request.edits) : std::nullopt;
}

void ViewRenderer::set_paused(bool paused) {
  update_state([&] {
    paused_ = paused;
    pause_requested_ = true;
  });
}

void ViewRenderer::set_display_mode(const DisplayMode& display_mode) {
  display_mode_ = display_mode;
  republish();
}

void ViewRenderer::republish() {
  update_state([&] { republish_requested_ = pause_requested_ = true; });
}

std::future<FilmCopy> ViewRenderer::copy() {
  std::future<FilmCopy> result;
  update_state([&] {
    result = copies_.emplace_back().get_future();
    pause_requested_ = true;
  });
  return result;
}

void ViewRenderer::inspect(InspectionTarget target, std::optional<Vec2i> pixel) {
  {
    const std::lock_guard lock(mutex_);
    inspected_pixel(target) = {pixel, pixel.has_value(), std::nullopt};
    if (pixel) pause_requested_ = true;
  }
  if (pixel) state_changed_.notify_all();
}

std::optional<PixelInspection> ViewRenderer::inspection(InspectionTarget target) const {
  const std::lock_guard lock(mutex_);
  return inspection_targets_[size_t(target)].found;
}

void ViewRenderer::work() {
  while (std::optional<RenderRequest> request = next_request()) {
    try {
      render(std::move(*request));
    } catch (const EmberlineError& error) {
      publisher_.set_problem(error.what());
    } catch (const std::bad_alloc&) {
      publisher_.set_problem("not enough memory to render this frame; make it smaller");
    }
    const std::lock_guard lock(mutex_);
    stop_.reset();
  }
  frame_.reset();
}

std::optional<RenderRequest> ViewRenderer::next_request() {
  std::unique_lock lock(mutex_);
  while (true) {
    if (ending_) return std::nullopt;
    if (request_) {
      stop_ = std::make_shared<StopRequest>();
      frame_published_ = false;
      groups_.reset();  // until the new frame has groups, mix_of() must not use the old ones
      relighting_.reset();
      return std::exchange(request_, std::nullopt);
    }
    if (requested()) {
      serve(lock);
      continue;
    }
    for (std::promise<FilmCopy>& copy : copies_) copy.set_exception(no_picture_error());
    copies_.clear();
    state_changed_.wait(lock);
  }
}

bool ViewRenderer::requested() const {
  if (!frame_ || !frame_->has_picture()) return false;
  const bool inspection_pending =
      std::ranges::any_of(inspection_targets_, &InspectedPixel::is_pending);
  return republish_requested_ || relighting_ || inspection_pending ||
         (!copies_.empty() && frame_->has_whole_picture());
}

void ViewRenderer::serve(std::unique_lock<std::mutex>& lock) {
  const bool show = std::exchange(republish_requested_, false);
  const std::optional<RelightRequest> lights = std::exchange(relighting_, std::nullopt);
  if (lights) relight_pause_end_ = ViewClock::now() + kRelightPause;
  for (InspectedPixel& target : inspection_targets_) target.is_pending = false;
  const std::array<InspectedPixel, 2> targets = inspection_targets_;
  std::vector<std::promise<FilmCopy>> copies;
  if (frame_->has_whole_picture()) copies.swap(copies_);
  lock.unlock();
  if (lights) {
    frame_->relight(*lights);
  } else if (show) {
    frame_->republish();
  }
  for (std::promise<FilmCopy>& copy : copies) {
    try {
      copy.set_value(frame_->copy());
    } catch (...) {
      copy.set_exception(std::current_exception());
    }
  }
  std::array<std::optional<PixelInspection>, 2> found;
  for (size_t i = 0; i < targets.size(); ++i) {
    if (const auto& pixel = targets[i].pixel) {
      found[i] = frame_->inspect_pixel(pixel->x, pixel->y,
                                       InspectionTarget(i) == InspectionTarget::kPicked);
    }
  }
  lock.lock();
  for (size_t i = 0; i < targets.size(); ++i) {
    if (!found[i] || inspection_targets_[i].pixel != targets[i].pixel) continue;
    inspection_targets_[i].found = std::move(found[i]);
    publisher_.wake();
  }
}

void ViewRenderer::pause(bool is_published) {
  std::unique_lock lock(mutex_);
  pause_requested_ = false;
  if (is_published) request_inspections();
  if (requested()) serve(lock);
  if (!frame_published_ &&
      frame_->has_published()) {  // because it was due or another thread asked for it
    frame_published_ = true;
    if (request_) stop_->request(PixelStop::kUser);
  }
  if (!is_waiting()) return;
  const ViewClock::time_point begun = ViewClock::now();
  republish_requested_ =
      republish_requested_ || (paused_ && !is_published);  // a paused frame shows its last state
  while (is_waiting()) {
    if (requested()) {
      serve(lock);
    } else if (paused_) {
      state_changed_.wait(lock);
    } else {
      state_changed_.wait_until(lock, relight_pause_end_);
    }
  }
  frame_->exclude_time(ViewClock::now() - begun);
}

void ViewRenderer::request_inspections() {
  for (InspectedPixel& target : inspection_targets_) target.is_pending = target.pixel.has_value();
}

bool ViewRenderer::is_waiting() const {
  if (stop_->cause() != PixelStop::kNone || !frame_published_) return false;
  return paused_ || ViewClock::now() < relight_pause_end_;
}

// Returns null if the current prepared settings can be reused.
std::unique_ptr<PreparedSettings> ViewRenderer::prepare(const ViewSettings& settings) const {
  const bool serve = prepared_ && frame_satisfies(prepared_for_, settings) &&
                     frame_satisfies(settings, prepared_for_);
  return serve ? nullptr : std::make_unique<PreparedSettings>(settings);
}

void ViewRenderer::set_threads(int requested) {
  if (workers_ && requested == threads_) return;
  low_priority_.reset();
  arena_.reset();
  workers_.reset();
  workers_.emplace(requested);
  threads_ = requested;
  arena_.emplace(workers_->count());
  low_priority_ = std::make_unique<LowPriorityWorkers>(*arena_);
}

void ViewRenderer::read_environment(RenderRequest& request) {
  EnvironmentEdit& edit = request.edits.environment;
  if (edit.file.empty() || edit.image) return;
  if (environment_.file != edit.file) {
    const std::shared_ptr<MemoryBudget>& budget = request.scene->memory.budget();
    LoadLimits limits;
    limits.memory = budget->child_budget();
    LoadProgress progress({}, {}, limits);
    uint64_t repaired = 0;
    auto image = emberline::read_environment(edit.file, &repaired, progress);
    MemoryReservation memory(budget, MemoryPart::kTextures, limits.memory->newly_reserved(),
                             edit.file);
    memory.add(EnvironmentLight::table_bytes(*image), edit.file);
    environment_memory_ = std::move(memory);
    environment_.image = std::move(image);
    environment_.repaired_texels = repaired;
    environment_.file = edit.file;
  }
  edit.image = environment_.image;
  edit.repaired_texels = environment_.repaired_texels;
}

// Applies the edits to the scene and returns null. If light groups can be used, applies the edits
// with all lights on instead (neutral_baseline()). It then returns the light groups, whose mix
// shows the requested light.
std::shared_ptr<const LightGroups> ViewRenderer::apply_edits(const RenderRequest& request,
                                                             const PreparedSettings& prepared) {
  EditableScene& scene = request.scene->scene->editable();
  if (prepared.light_groups) {
    const SceneEdits baseline = neutral_baseline(request.edits);
    scene.set(baseline);
    auto groups = std::make_shared<const LightGroups>(scene.original(), baseline);
    if (groups->mix(request.edits)) return groups;
  }
  scene.set(request.edits);
  return nullptr;
}

// Keeps the previous frame, for inspection and saving, until no step can fail any more.
void ViewRenderer::render(RenderRequest request) {
  std::unique_ptr<PreparedSettings> prepared = prepare(request.settings);
  set_threads(request.settings.render.threads);
  read_environment(request);
  std::optional<Vec2i> explained;
  std::shared_ptr<StopRequest> stop;
  {
    const std::lock_guard lock(mutex_);
    explained = inspected_pixel(InspectionTarget::kPicked).pixel;
    stop = stop_;
  }
  arena_->execute([&] {
    if (request.scene->needs_repose(request.edits)) {
      request.scene->pose(request.edits);
      frame_.reset();  // the old frame refers to the previous pose
    }
    const std::shared_ptr<const LightGroups> groups =
        apply_edits(request, prepared ? *prepared : *prepared_);
    std::optional<LightMix> mix;
    if (groups && request.scene->scene->editable().edits() != request.edits)
      mix = groups->mix(request.edits);
    std::shared_ptr<LoadedScene> scene_before =
        request.scene;  // after swap(): the previous scene, released outside the lock
    {
      const std::lock_guard lock(mutex_);
      groups_ = groups;
      groups_scene_.swap(scene_before);
    }
    frame_.reset();  // the old frame refers to prepared_, and may be its scene's last owner
    if (prepared) {
      prepared_ = std::move(prepared);
      prepared_for_ = request.settings;
    }
    frame_ = std::make_unique<ViewFrame>(std::move(request), *prepared_, publisher_, denoiser_,
                                         stop, display_mode_, pause_requested_,
                                         [this](bool is_published) { pause(is_published); });
    frame_->set_lights(groups, std::move(mix));
    publisher_.set_problem("");
    frame_->render(explained);
  });
  const std::lock_guard lock(mutex_);
  request_inspections();  // because there was no pause after the last samples
}

}  // namespace emberline
