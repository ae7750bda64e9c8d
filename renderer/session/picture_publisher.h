// Publishes a session's newest picture, graded for display, and the session's error message
// (`problem`).
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "renderer/session/grading.h"
#include "renderer/session/session_picture.h"
#include "renderer/session/task_thread.h"

namespace emberline {

// Thread-safe. When the last pointer to a picture is released, its memory is kept for reuse. A 1280
// x 720 picture needs 18 MB, and touching that much new memory takes 2 ms.
class PicturePublisher {
 public:
  PicturePublisher();

  // Grades the newest picture again in the background, without new samples, and uses the settings
  // for later pictures. Does not change pictures with an overlay. If the settings are invalid, sets
  // problem() and keeps the previous settings.
  void set_display(const DisplaySettings& settings);
  // Waits for the first set_display(). Returns null if no grading could be created.
  std::shared_ptr<const Grading> grading();

  // Returns a picture to fill in. It may be a released picture that still has its old values.
  std::shared_ptr<SessionPicture> acquire_picture();
  // Publishes a picture that was graded with `grading`: assigns its serial number and wakes the
  // session's owner.
  void publish(std::shared_ptr<SessionPicture> picture, std::shared_ptr<const Grading> grading);
  std::shared_ptr<const SessionPicture> picture() const;

  // Grades an older picture in the background with the current display settings, and again after
  // each change of these settings. Does not change a picture with an overlay. A null pointer ends
  // the comparison.
  void compare_with(std::shared_ptr<const SessionPicture> comparison);
  std::shared_ptr<const SessionPicture> graded_comparison() const;  // null until graded

  // Sets the problem that rendering reports; an empty text clears it.
  void set_problem(const std::string& text);
  std::string problem() const;

  void on_change(std::function<void()> wake);
  void wake();

 private:
  struct PicturePool;  // released pictures, whose memory is reused

  void apply_display(const DisplaySettings& settings);
  void regrade();
  void regrade_comparison();
  std::shared_ptr<SessionPicture> grade_copy(const SessionPicture& old, const Grading& grading);

  const std::shared_ptr<PicturePool> pool_;
  mutable std::mutex mutex_;
  std::condition_variable grading_available_;
  bool has_grading_ = false;
  std::shared_ptr<const Grading> grading_;
  std::shared_ptr<const SessionPicture> picture_;
  std::shared_ptr<const Grading> picture_grading_;  // the grading that made picture_
  uint64_t serial_ = 0;
  std::shared_ptr<const SessionPicture> comparison_, graded_comparison_;  // original and graded
  std::shared_ptr<const Grading> comparison_grading_;
  std::string render_problem_, display_problem_;
  DisplaySettings newest_settings_;  // older settings that are still pending are skipped

  std::mutex wake_mutex_;  // held while wake_ runs, so that no call outlasts on_change({})
  std::function<void()> wake_;

  TaskThread grader_;  // declared last, because its tasks use all members above
};

}  // namespace emberline
