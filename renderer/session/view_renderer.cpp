#include "renderer/session/view_renderer.h"

#include <algorithm>
#include <exception>
#include <new>
#include <utility>

#include "io/image_input.h"
#include "renderer/core/errors.h"
#include "renderer/lights/environment_light.h"

namespace emberline {
namespace {

// After a picture under other lights the frame stands still for a moment, so that the next one does
// not have to wait for a pause: one that is asked for comes after some milliseconds of work, and
// later where a driver plans its next round.
constexpr auto kRelitPause = std::chrono::milliseconds(150);

std::exception_ptr nothing_to_copy() {
  return std::make_exception_ptr(
      RenderError("there is no picture to be saved yet; wait for the first one"));
}

}  // namespace

ViewRenderer::ViewRenderer(PictureBoard& board) : board_(board), thread_([this] { work(); }) {}

ViewRenderer::~ViewRenderer() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
    if (stop_) stop_->request(PixelStop::kUser);
  }
  news_.notify_all();
  thread_.join();
  for (std::promise<FilmCopy>& copy : copies_) copy.set_exception(nothing_to_copy());
}

void ViewRenderer::post(ViewOrder order, bool only_edits) {
  std::optional<LightMix> mix;
  if (only_edits) mix = mix_of(order);
  {
    const std::lock_guard lock(mutex_);
    if (mix && !order_) {
      relighting_ = Relighting{order.edit, order.posted, std::move(*mix)};
      hurry_ = true;
    } else {
      relighting_.reset();
      // An order that is replaced before it begins hands on that it could not wait.
      patient_ = only_edits && (!order_ || patient_);
      order_ = std::move(order);
      if (stop_ && (!patient_ || frame_shown_)) stop_->request(PixelStop::kUser);
    }
  }
  news_.notify_all();
}

// How the frame that there is becomes that of the order, if it can.
std::optional<LightMix> ViewRenderer::mix_of(const ViewOrder& order) const {
  std::shared_ptr<const LightGroups> groups;
  const EnvironmentEdit& environment = order.edits.environment;
  if (!environment.file.empty() && !environment.image) return std::nullopt;  // not read yet
  {
    const std::lock_guard lock(mutex_);
    if (order_ || groups_scene_ != order.scene) return std::nullopt;
    groups = groups_;
  }
  return groups ? groups->mix(order.edits) : std::nullopt;
}

void ViewRenderer::set_paused(bool paused) {
  {
    const std::lock_guard lock(mutex_);
    paused_ = paused;
    hurry_ = true;
  }
  news_.notify_all();
}

void ViewRenderer::set_overlay(ViewOverlay overlay) {
  overlay_ = overlay;
  show_again();
}

void ViewRenderer::show_again() {
  {
    const std::lock_guard lock(mutex_);
    show_again_ = true;
    hurry_ = true;
  }
  news_.notify_all();
}

std::future<FilmCopy> ViewRenderer::copy() {
  std::future<FilmCopy> result;
  {
    const std::lock_guard lock(mutex_);
    result = copies_.emplace_back().get_future();
    hurry_ = true;
  }
  news_.notify_all();
  return result;
}

void ViewRenderer::inspect(Look look, std::optional<Vec2i> pixel) {
  {
    const std::lock_guard lock(mutex_);
    look_of(look) = {pixel, pixel.has_value(), std::nullopt};
    if (pixel) hurry_ = true;
  }
  if (pixel) news_.notify_all();
}

std::optional<PixelInspection> ViewRenderer::inspection(Look look) const {
  const std::lock_guard lock(mutex_);
  return looks_[size_t(look)].found;
}

void ViewRenderer::work() {
  while (std::optional<ViewOrder> order = next_order()) {
    try {
      render(std::move(*order));
    } catch (const EmberlineError& error) {
      board_.set_problem(error.what());
    } catch (const std::bad_alloc&) {
      board_.set_problem("not enough memory to render this frame; make it smaller");
    }
    const std::lock_guard lock(mutex_);
    stop_.reset();
  }
  frame_.reset();
}

std::optional<ViewOrder> ViewRenderer::next_order() {
  std::unique_lock lock(mutex_);
  while (true) {
    if (ending_) return std::nullopt;
    if (order_) {
      stop_ = std::make_shared<StopRequest>();
      frame_shown_ = false;
      groups_.reset();  // until they are those of the new frame, nothing can be mixed
      relighting_.reset();
      return std::exchange(order_, std::nullopt);
    }
    if (wanted()) {
      serve(lock);
      continue;
    }
    for (std::promise<FilmCopy>& copy : copies_) copy.set_exception(nothing_to_copy());
    copies_.clear();
    news_.wait(lock);
  }
}

bool ViewRenderer::wanted() const {
  if (!frame_ || !frame_->readable()) return false;
  const bool looked_for = std::ranges::any_of(looks_, &LookedAt::asked);
  return show_again_ || relighting_ || looked_for || (!copies_.empty() && frame_->whole());
}

void ViewRenderer::serve(std::unique_lock<std::mutex>& lock) {
  const bool show = std::exchange(show_again_, false);
  const std::optional<Relighting> lights = std::exchange(relighting_, std::nullopt);
  if (lights) relit_until_ = ViewClock::now() + kRelitPause;
  for (LookedAt& look : looks_) look.asked = false;
  const std::array<LookedAt, 2> looks = looks_;
  std::vector<std::promise<FilmCopy>> copies;
  if (frame_->whole()) copies.swap(copies_);
  lock.unlock();
  if (lights) {
    frame_->relight(*lights);
  } else if (show) {
    frame_->show_again();
  }
  for (std::promise<FilmCopy>& copy : copies) {
    try {
      copy.set_value(frame_->copy());
    } catch (...) {
      copy.set_exception(std::current_exception());
    }
  }
  std::array<std::optional<PixelInspection>, 2> found;
  for (size_t i = 0; i < looks.size(); ++i) {
    if (const auto& pixel = looks[i].pixel) {
      found[i] = frame_->look_at(pixel->x, pixel->y, Look(i) == Look::kPicked);
    }
  }
  lock.lock();
  for (size_t i = 0; i < looks.size(); ++i) {
    if (!found[i] || looks_[i].pixel != looks[i].pixel) continue;
    looks_[i].found = std::move(found[i]);
    board_.wake();
  }
}

void ViewRenderer::pause(bool shown) {
  std::unique_lock lock(mutex_);
  hurry_ = false;
  if (shown) ask_again();
  if (wanted()) serve(lock);
  if (!frame_shown_ && frame_->has_shown()) {  // in its own time, or because somebody asked
    frame_shown_ = true;
    if (order_) stop_->request(PixelStop::kUser);
  }
  if (!stands_still()) return;
  const ViewClock::time_point begun = ViewClock::now();
  show_again_ = show_again_ || (paused_ && !shown);  // what stands still is seen as it is
  while (stands_still()) {
    if (wanted()) {
      serve(lock);
    } else if (paused_) {
      news_.wait(lock);
    } else {
      news_.wait_until(lock, relit_until_);
    }
  }
  frame_->leave_out(ViewClock::now() - begun);
}

void ViewRenderer::ask_again() {
  for (LookedAt& look : looks_) look.asked = look.pixel.has_value();
}

bool ViewRenderer::stands_still() const {
  if (stop_->cause() != PixelStop::kNone || !frame_shown_) return false;
  return paused_ || ViewClock::now() < relit_until_;
}

// Null if those of the frame before will do.
std::unique_ptr<FrameTools> ViewRenderer::tools_for(const ViewSettings& settings) const {
  const bool serve =
      tools_ && frames_serve(tools_settings_, settings) && frames_serve(settings, tools_settings_);
  return serve ? nullptr : std::make_unique<FrameTools>(settings);
}

void ViewRenderer::set_threads(int wanted) {
  if (workers_ && wanted == threads_) return;
  polite_.reset();
  arena_.reset();
  workers_.reset();
  workers_.emplace(wanted);
  threads_ = wanted;
  arena_.emplace(workers_->count());
  polite_.emplace(*arena_);
}

void ViewRenderer::read_environment(ViewOrder& order) {
  EnvironmentEdit& edit = order.edits.environment;
  if (edit.file.empty() || edit.image) return;
  if (environment_.file != edit.file) {
    const std::shared_ptr<MemoryBudget>& crop = order.scene->memory.budget();
    LoadLimits limits;
    limits.memory = crop->rest();
    LoadProgress progress({}, {}, limits);
    uint64_t repaired = 0;
    auto image = emberline::read_environment(edit.file, &repaired, progress);
    MemoryReservation memory(crop, MemoryPart::kTextures, limits.memory->took(), edit.file);
    memory.add(EnvironmentLight::table_bytes(*image), edit.file);
    environment_memory_ = std::move(memory);
    environment_.image = std::move(image);
    environment_.repaired_texels = repaired;
    environment_.file = edit.file;
  }
  edit.image = environment_.image;
  edit.repaired_texels = environment_.repaired_texels;
}

// Edits the scene. With light groups, to what can be mixed to be the order's; null without.
std::shared_ptr<const LightGroups> ViewRenderer::dress(const ViewOrder& order,
                                                       const FrameTools& tools) {
  EditableScene& scene = order.scene->scene;
  if (tools.light_groups) {
    const SceneEdits baseline = neutral_baseline(order.edits);
    scene.set(baseline);
    auto groups = std::make_shared<const LightGroups>(scene.original(), baseline);
    if (groups->mix(order.edits)) return groups;
  }
  scene.set(order.edits);
  return nullptr;
}

// Until nothing can go wrong any more the frame of before stays, to be looked at and saved.
void ViewRenderer::render(ViewOrder order) {
  std::unique_ptr<FrameTools> tools = tools_for(order.settings);
  set_threads(order.settings.render.threads);
  read_environment(order);
  std::optional<Vec2i> explained;
  std::shared_ptr<StopRequest> stop;
  {
    const std::lock_guard lock(mutex_);
    explained = look_of(Look::kPicked).pixel;
    stop = stop_;
  }
  arena_->execute([&] {
    const std::shared_ptr<const LightGroups> groups = dress(order, tools ? *tools : *tools_);
    std::optional<LightMix> mix;
    if (groups && order.scene->scene.edits() != order.edits) mix = groups->mix(order.edits);
    bvh_builds_ = order.scene->scene.scene().bvh_builds();
    std::shared_ptr<LoadedScene> scene_before = order.scene;  // freed here, if it was the last
    {
      const std::lock_guard lock(mutex_);
      groups_ = groups;
      groups_scene_.swap(scene_before);
    }
    frame_.reset();  // which looks at the tools, and may be the last to hold a scene
    if (tools) {
      tools_ = std::move(tools);
      tools_settings_ = order.settings;
    }
    frame_ = std::make_unique<ViewFrame>(std::move(order), *tools_, board_, stop, overlay_, hurry_,
                                         [this](bool shown) { pause(shown); });
    frame_->set_lights(groups, std::move(mix));
    board_.set_problem("");
    frame_->render(explained);
  });
  const std::lock_guard lock(mutex_);
  ask_again();  // of the last samples there was no pause
}

}  // namespace emberline
