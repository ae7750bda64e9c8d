#include "renderer/app/view/view_renderer.h"

#include <algorithm>
#include <exception>
#include <new>
#include <utility>

#include "io/image_input.h"
#include "renderer/core/errors.h"

namespace emberline {
namespace {

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

void ViewRenderer::post(ViewOrder order, bool patient) {
  {
    const std::lock_guard lock(mutex_);
    // An order that is replaced before it begins hands on that it could not wait.
    patient_ = patient && (!order_ || patient_);
    order_ = std::move(order);
    if (stop_ && (!patient_ || frame_shown_)) stop_->request(PixelStop::kUser);
  }
  news_.notify_all();
}

void ViewRenderer::set_paused(bool paused) {
  {
    const std::lock_guard lock(mutex_);
    paused_ = paused;
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
  }
  news_.notify_all();
}

std::future<FilmCopy> ViewRenderer::copy() {
  std::future<FilmCopy> result;
  {
    const std::lock_guard lock(mutex_);
    result = copies_.emplace_back().get_future();
  }
  news_.notify_all();
  return result;
}

void ViewRenderer::inspect(std::optional<Vec2i> pixel) {
  {
    const std::lock_guard lock(mutex_);
    pixel_ = pixel;
    pixel_asked_ = pixel.has_value();
    inspection_.reset();
  }
  if (pixel) news_.notify_all();
}

std::optional<PixelInspection> ViewRenderer::inspection() const {
  const std::lock_guard lock(mutex_);
  return inspection_;
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
  return show_again_ || pixel_asked_ || (!copies_.empty() && frame_->whole());
}

void ViewRenderer::serve(std::unique_lock<std::mutex>& lock) {
  const bool show = std::exchange(show_again_, false);
  pixel_asked_ = false;
  const std::optional<Vec2i> pixel = pixel_;
  std::vector<std::promise<FilmCopy>> copies;
  if (frame_->whole()) copies.swap(copies_);
  lock.unlock();
  if (show) frame_->show_again();
  for (std::promise<FilmCopy>& copy : copies) {
    try {
      copy.set_value(frame_->copy());
    } catch (...) {
      copy.set_exception(std::current_exception());
    }
  }
  std::optional<PixelInspection> found;
  if (pixel) found = frame_->look_at(pixel->x, pixel->y);
  lock.lock();
  if (found && pixel_ == pixel) {
    inspection_ = std::move(found);
    board_.wake();
  }
}

void ViewRenderer::pause(bool shown) {
  std::unique_lock lock(mutex_);
  if (shown) {
    pixel_asked_ = pixel_.has_value();
    if (!frame_shown_) {
      frame_shown_ = true;
      if (order_) stop_->request(PixelStop::kUser);
    }
  }
  if (wanted()) serve(lock);
  if (!paused_ || !frame_shown_) return;
  const ViewClock::time_point begun = ViewClock::now();
  show_again_ = show_again_ || !shown;  // what stands still is seen as it is
  while (paused_ && stop_->cause() == PixelStop::kNone) {
    if (wanted()) {
      serve(lock);
    } else {
      news_.wait(lock);
    }
  }
  frame_->leave_out(ViewClock::now() - begun);
}

// Null if those of the frame before will do.
std::unique_ptr<FrameTools> ViewRenderer::tools_for(const ViewSettings& settings) const {
  const bool serve =
      tools_ && frames_serve(tools_settings_, settings) && frames_serve(settings, tools_settings_);
  return serve ? nullptr : std::make_unique<FrameTools>(settings);
}

void ViewRenderer::set_threads(int wanted) {
  const int threads = wanted > 0 ? wanted : int(std::max(1u, std::thread::hardware_concurrency()));
  if (threads == threads_) return;
  threads_ = threads;
  arena_.reset();
  limit_.reset();
  limit_.emplace(tbb::global_control::max_allowed_parallelism, size_t(threads));
  arena_.emplace(threads);
}

void ViewRenderer::read_environment(EnvironmentEdit& edit) {
  if (edit.file.empty() || edit.image) return;
  if (environment_.file != edit.file) {
    uint64_t repaired = 0;
    environment_.image = emberline::read_environment(edit.file, &repaired);
    environment_.repaired_texels = repaired;
    environment_.file = edit.file;
  }
  edit.image = environment_.image;
  edit.repaired_texels = environment_.repaired_texels;
}

// Until nothing can go wrong any more the frame of before stays, to be looked at and saved.
void ViewRenderer::render(ViewOrder order) {
  std::unique_ptr<FrameTools> tools = tools_for(order.settings);
  set_threads(order.settings.render.threads);
  read_environment(order.edits.environment);
  std::optional<Vec2i> pixel;
  std::shared_ptr<StopRequest> stop;
  {
    const std::lock_guard lock(mutex_);
    pixel = pixel_;
    stop = stop_;
  }
  arena_->execute([&] {
    EditableScene& scene = order.scene->scene;
    scene.set(order.edits);
    bvh_builds_ = scene.scene().bvh_builds();
    frame_.reset();  // which looks at the tools, and may be the last to hold a scene
    if (tools) {
      tools_ = std::move(tools);
      tools_settings_ = order.settings;
    }
    frame_ = std::make_unique<ViewFrame>(std::move(order), *tools_, board_, stop, overlay_,
                                         [this](bool shown) { pause(shown); });
    board_.set_problem("");
    frame_->render(pixel);
  });
}

}  // namespace emberline
