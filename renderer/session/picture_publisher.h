// Publishes a session's newest picture, graded for display, and its problems.
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

// Thread-safe. Pictures are shared pointers whose memory is reused after the last release, since a
// frame of 1280 x 720 takes 18 MB and 2 ms for the first touch.
class PicturePublisher {
 public:
  PicturePublisher();

  // Grades the newest picture again, and later ones, in the background and without new samples.
  // Pictures with an overlay are not graded. Invalid settings become a problem(), and the previous
  // ones stay.
  void set_display(const DisplaySettings& settings);
  // Waits for the first set_display(). Null if there were no valid settings yet.
  std::shared_ptr<const Grading> grading();

  // Returns a picture to fill in, which may reuse a released one's memory.
  std::shared_ptr<SessionPicture> acquire_picture();
  // Publishes a picture that was graded by `grading`: assigns its serial number and wakes the
  // owner.
  void publish(std::shared_ptr<SessionPicture> picture, std::shared_ptr<const Grading> grading);
  std::shared_ptr<const SessionPicture> picture() const;

  // Grades an older picture in the background with the current display settings, and again after
  // each change. A picture with an overlay stays unchanged. Null: none.
  void compare_with(std::shared_ptr<const SessionPicture> comparison);
  std::shared_ptr<const SessionPicture> graded_comparison() const;  // null until graded

  // Sets the problem of rendering; an empty text clears it.
  void set_problem(const std::string& text);
  std::string problem() const;

  void on_change(std::function<void()> wake);
  void wake();

 private:
  struct PicturePool;  // memory of pictures

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
  std::shared_ptr<const Grading> picture_grading_;  // used for picture_
  uint64_t serial_ = 0;
  std::shared_ptr<const SessionPicture> comparison_, graded_comparison_;  // original and graded
  std::shared_ptr<const Grading> comparison_grading_;
  std::string render_problem_, display_problem_;
  DisplaySettings newest_settings_;  // the newest settings; older pending ones are skipped

  std::mutex wake_mutex_;  // held during the callback, so that on_change({}) is final
  std::function<void()> wake_;

  TaskThread grader_;  // last: its tasks use all of the above
};

}  // namespace emberline
