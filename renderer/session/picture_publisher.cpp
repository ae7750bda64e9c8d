#include "renderer/session/picture_publisher.h"

#include <utility>
#include <vector>

#include "renderer/core/errors.h"

namespace emberline {
namespace {

// One is published, one being drawn, one on the screen, and one in transit.
constexpr size_t kMostSpare = 4;

}  // namespace

struct PicturePublisher::Spare {
  std::mutex mutex;
  std::vector<std::unique_ptr<ShownPicture>> pictures;
};

PicturePublisher::PicturePublisher() : spare_(std::make_shared<Spare>()) {}

void PicturePublisher::set_display(const DisplaySettings& settings) {
  {
    const std::lock_guard lock(mutex_);
    wanted_ = settings;
  }
  grader_.post([this, settings] {
    {
      const std::lock_guard lock(mutex_);
      if (settings != wanted_) return;  // a newer request follows
    }
    change_display(settings);
    regrade();
    regrade_compared();
  });
}

void PicturePublisher::change_display(const DisplaySettings& settings) {
  std::shared_ptr<const Grading> before, made;
  {
    const std::lock_guard lock(mutex_);
    before = grading_;
  }
  std::string problem;
  try {
    DisplaySettings but_exposure = settings;
    if (before) but_exposure.exposure = before->settings().exposure;
    made = before && but_exposure == before->settings()
               ? std::make_shared<const Grading>(*before, settings.exposure)
               : std::make_shared<const Grading>(settings);
  } catch (const EmberlineError& error) {
    problem = error.what();
    made = before;
  }
  if (!made) {  // no settings yet: show something
    try {
      made = std::make_shared<const Grading>(DisplaySettings{});
    } catch (const EmberlineError&) {  // already reported
    }
  }
  {
    const std::lock_guard lock(mutex_);
    grading_ = std::move(made);
    display_problem_ = std::move(problem);
    made_ = true;
  }
  grading_made_.notify_all();
  wake();
}

void PicturePublisher::regrade() {
  while (true) {
    std::shared_ptr<const ShownPicture> old;
    std::shared_ptr<const Grading> grading;
    {
      const std::lock_guard lock(mutex_);
      if (!picture_ || picture_grading_ == grading_ || !picture_->overlay_legend.empty()) return;
      old = picture_;
      grading = grading_;
    }
    const std::shared_ptr<ShownPicture> fresh = graded(*old, *grading);
    {
      const std::lock_guard lock(mutex_);
      if (picture_ != old) continue;  // a newer one was published meanwhile
      fresh->serial = ++serial_;
      picture_ = fresh;
      picture_grading_ = grading;
    }
    wake();
    return;
  }
}

void PicturePublisher::regrade_compared() {
  std::shared_ptr<const ShownPicture> kept;
  std::shared_ptr<const Grading> grading;
  {
    const std::lock_guard lock(mutex_);
    if (!kept_ || !grading_ || (compared_ && compared_grading_ == grading_)) return;
    kept = kept_;
    grading = grading_;
  }
  const bool overlay = !kept->overlay_legend.empty();
  std::shared_ptr<const ShownPicture> fresh = overlay ? kept : graded(*kept, *grading);
  {
    const std::lock_guard lock(mutex_);
    if (kept_ != kept) return;  // the newer one has its own task
    compared_.swap(fresh);      // the old one is released outside the lock
    compared_grading_ = std::move(grading);
  }
  wake();
}

std::shared_ptr<ShownPicture> PicturePublisher::graded(const ShownPicture& old,
                                                       const Grading& grading) {
  std::shared_ptr<ShownPicture> fresh = blank();
  *fresh = old;
  grading.grade(fresh->linear(), fresh->width, fresh->rgba8);
  if (!fresh->raw8.empty()) grading.grade(fresh->rgba, fresh->width, fresh->raw8);
  return fresh;
}

void PicturePublisher::compare_with(std::shared_ptr<const ShownPicture> kept) {
  std::shared_ptr<const ShownPicture> before;  // released outside the lock
  {
    const std::lock_guard lock(mutex_);
    if (kept_ == kept) return;
    kept_ = std::move(kept);
    before = std::move(compared_);
    if (!kept_) return;
  }
  grader_.post([this] { regrade_compared(); });
}

std::shared_ptr<const ShownPicture> PicturePublisher::compared() const {
  const std::lock_guard lock(mutex_);
  return compared_;
}

std::shared_ptr<const Grading> PicturePublisher::grading() {
  std::unique_lock lock(mutex_);
  grading_made_.wait(lock, [this] { return made_; });
  return grading_;
}

std::shared_ptr<ShownPicture> PicturePublisher::blank() {
  std::unique_ptr<ShownPicture> picture;
  {
    const std::lock_guard lock(spare_->mutex);
    if (!spare_->pictures.empty()) {
      picture = std::move(spare_->pictures.back());
      spare_->pictures.pop_back();
    }
  }
  if (!picture) picture = std::make_unique<ShownPicture>();
  return {picture.release(), [spare = spare_](ShownPicture* used) {
            std::unique_ptr<ShownPicture> owned(used);
            const std::lock_guard lock(spare->mutex);
            if (spare->pictures.size() < kMostSpare) spare->pictures.push_back(std::move(owned));
          }};
}

void PicturePublisher::publish(std::shared_ptr<ShownPicture> picture,
                               std::shared_ptr<const Grading> grading) {
  std::shared_ptr<const ShownPicture> before;  // released outside the lock
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

std::shared_ptr<const ShownPicture> PicturePublisher::picture() const {
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
