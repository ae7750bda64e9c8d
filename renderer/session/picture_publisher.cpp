#include "renderer/session/picture_publisher.h"

#include <utility>
#include <vector>

#include "renderer/core/errors.h"

namespace emberline {
namespace {

// One picture is published, one is being drawn, one is on the screen, and one is in transit between
// these states.
constexpr size_t kMaxPooledPictures = 4;

}  // namespace

struct PicturePublisher::PicturePool {
  std::mutex mutex;
  std::vector<std::unique_ptr<SessionPicture>> pictures;
};

PicturePublisher::PicturePublisher() : pool_(std::make_shared<PicturePool>()) {}

void PicturePublisher::set_display(const DisplaySettings& settings) {
  {
    const std::lock_guard lock(mutex_);
    newest_settings_ = settings;
  }
  grader_.post([this, settings] {
    {
      const std::lock_guard lock(mutex_);
      if (settings != newest_settings_) return;  // a newer request follows
    }
    apply_display(settings);
    regrade();
    regrade_comparison();
  });
}

void PicturePublisher::apply_display(const DisplaySettings& settings) {
  std::shared_ptr<const Grading> before, new_grading;
  {
    const std::lock_guard lock(mutex_);
    before = grading_;
  }
  std::string problem;
  try {
    DisplaySettings at_same_exposure = settings;
    if (before) at_same_exposure.exposure = before->settings().exposure;
    new_grading = before && at_same_exposure == before->settings()
                      ? std::make_shared<const Grading>(*before, settings.exposure)
                      : std::make_shared<const Grading>(settings);
  } catch (const EmberlineError& error) {
    problem = error.what();
    new_grading = before;
  }
  if (!new_grading) {  // there were no valid settings yet: use the defaults
    try {
      new_grading = std::make_shared<const Grading>(DisplaySettings{});
    } catch (const EmberlineError&) {  // already reported
    }
  }
  {
    const std::lock_guard lock(mutex_);
    grading_ = std::move(new_grading);
    display_problem_ = std::move(problem);
    has_grading_ = true;
  }
  grading_available_.notify_all();
  wake();
}

void PicturePublisher::regrade() {
  while (true) {
    std::shared_ptr<const SessionPicture> old;
    std::shared_ptr<const Grading> grading;
    {
      const std::lock_guard lock(mutex_);
      if (!picture_ || picture_grading_ == grading_ || !picture_->overlay_legend.empty()) return;
      old = picture_;
      grading = grading_;
    }
    const std::shared_ptr<SessionPicture> fresh = grade_copy(*old, *grading);
    {
      const std::lock_guard lock(mutex_);
      if (picture_ != old) continue;  // a newer picture was published meanwhile
      fresh->serial = ++serial_;
      picture_ = fresh;
      picture_grading_ = grading;
    }
    wake();
    return;
  }
}

void PicturePublisher::regrade_comparison() {
  std::shared_ptr<const SessionPicture> comparison;
  std::shared_ptr<const Grading> grading;
  {
    const std::lock_guard lock(mutex_);
    if (!comparison_ || !grading_ || (graded_comparison_ && comparison_grading_ == grading_))
      return;
    comparison = comparison_;
    grading = grading_;
  }
  const bool overlay = !comparison->overlay_legend.empty();
  std::shared_ptr<const SessionPicture> fresh =
      overlay ? comparison : grade_copy(*comparison, *grading);
  {
    const std::lock_guard lock(mutex_);
    if (comparison_ != comparison) return;  // the newer comparison has its own task
    graded_comparison_.swap(fresh);         // the old picture is released outside the lock
    comparison_grading_ = std::move(grading);
  }
  wake();
}

std::shared_ptr<SessionPicture> PicturePublisher::grade_copy(const SessionPicture& old,
                                                             const Grading& grading) {
  std::shared_ptr<SessionPicture> fresh = acquire_picture();
  *fresh = old;
  grading.grade(fresh->linear(), fresh->width, fresh->rgba8);
  if (!fresh->raw8.empty()) grading.grade(fresh->rgba, fresh->width, fresh->raw8);
  return fresh;
}

void PicturePublisher::compare_with(std::shared_ptr<const SessionPicture> comparison) {
  std::shared_ptr<const SessionPicture> before;  // released outside the lock
  {
    const std::lock_guard lock(mutex_);
    if (comparison_ == comparison) return;
    comparison_ = std::move(comparison);
    before = std::move(graded_comparison_);
    if (!comparison_) return;
  }
  grader_.post([this] { regrade_comparison(); });
}

std::shared_ptr<const SessionPicture> PicturePublisher::graded_comparison() const {
  const std::lock_guard lock(mutex_);
  return graded_comparison_;
}

std::shared_ptr<const Grading> PicturePublisher::grading() {
  std::unique_lock lock(mutex_);
  grading_available_.wait(lock, [this] { return has_grading_; });
  return grading_;
}

std::shared_ptr<SessionPicture> PicturePublisher::acquire_picture() {
  std::unique_ptr<SessionPicture> picture;
  {
    const std::lock_guard lock(pool_->mutex);
    if (!pool_->pictures.empty()) {
      picture = std::move(pool_->pictures.back());
      pool_->pictures.pop_back();
    }
  }
  if (!picture) picture = std::make_unique<SessionPicture>();
  return {picture.release(), [pool = pool_](SessionPicture* used) {
            std::unique_ptr<SessionPicture> owned(used);
            const std::lock_guard lock(pool->mutex);
            if (pool->pictures.size() < kMaxPooledPictures)
              pool->pictures.push_back(std::move(owned));
          }};
}

void PicturePublisher::publish(std::shared_ptr<SessionPicture> picture,
                               std::shared_ptr<const Grading> grading) {
  std::shared_ptr<const SessionPicture> before;  // released outside the lock
  bool outdated;
  {
    const std::lock_guard lock(mutex_);
    picture->serial = ++serial_;
    before = std::move(picture_);
    picture_ = std::move(picture);
    picture_grading_ = std::move(grading);
    outdated = picture_grading_ != grading_;
  }
  wake();
  if (outdated) grader_.post([this] { regrade(); });
}

std::shared_ptr<const SessionPicture> PicturePublisher::picture() const {
  const std::lock_guard lock(mutex_);
  return picture_;
}

void PicturePublisher::set_problem(const std::string& text) {
  {
    const std::lock_guard lock(mutex_);
    if (render_problem_ == text) return;
    render_problem_ = text;
  }
  wake();
}

std::string PicturePublisher::problem() const {
  const std::lock_guard lock(mutex_);
  return render_problem_.empty() ? display_problem_ : render_problem_;
}

void PicturePublisher::on_change(std::function<void()> wake) {
  const std::lock_guard lock(wake_mutex_);
  wake_ = std::move(wake);
}

void PicturePublisher::wake() {
  const std::lock_guard lock(wake_mutex_);
  if (wake_) wake_();
}

}  // namespace emberline
