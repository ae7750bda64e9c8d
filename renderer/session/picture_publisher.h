// Publishes a session's newest picture, graded by the display settings, and its problems.
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "renderer/session/grading.h"
#include "renderer/session/shown_picture.h"
#include "renderer/session/task_thread.h"

namespace emberline {

// Thread-safe. Pictures are shared pointers, whose memory is reused when the last is released: a
// frame of 1280 x 720 takes 18 MB, and 2 ms to touch for the first time.
class PicturePublisher {
 public:
  PicturePublisher();

  // Grades the newest picture again, and later ones, by these settings; in the background, without
  // new samples. Pictures with an overlay are not graded. Impossible settings are a problem(); the
  // previous ones stay.
  void set_display(const DisplaySettings& settings);
  // Waits for the first set_display(). Null if no settings were possible yet.
  std::shared_ptr<const Grading> grading();

  // A picture to fill in, with the memory of a released one.
  std::shared_ptr<ShownPicture> blank();
  // Publishes a picture that was graded by `grading`: numbers it, and wakes the owner.
  void publish(std::shared_ptr<ShownPicture> picture, std::shared_ptr<const Grading> grading);
  std::shared_ptr<const ShownPicture> picture() const;

  // Grades an older picture like the newest one, in the background, again after each change of the
  // display settings. One with an overlay stays unchanged. Null: none.
  void compare_with(std::shared_ptr<const ShownPicture> kept);
  std::shared_ptr<const ShownPicture> compared() const;  // null until it has been graded

  // Sets the problem of rendering; an empty text clears it.
  void set_problem(const std::string& text);
  std::string problem() const;

  void on_change(std::function<void()> wake);
  void wake();

 private:
  struct Spare;  // memory of pictures

  void change_display(const DisplaySettings& settings);
  void regrade();
  void regrade_compared();
  std::shared_ptr<ShownPicture> graded(const ShownPicture& old, const Grading& grading);

  const std::shared_ptr<Spare> spare_;
  mutable std::mutex mutex_;
  std::condition_variable grading_made_;
  bool made_ = false;
  std::shared_ptr<const Grading> grading_;
  std::shared_ptr<const ShownPicture> picture_;
  std::shared_ptr<const Grading> picture_grading_;  // what `picture_` was graded by
  uint64_t serial_ = 0;
  std::shared_ptr<const ShownPicture> kept_, compared_;  // as given, and as graded
  std::shared_ptr<const Grading> compared_grading_;
  std::string render_problem_, display_problem_;
  DisplaySettings wanted_;  // the newest, so that those between are left out

  std::mutex wake_mutex_;  // held while the owner is woken, so that on_change({}) is final
  std::function<void()> wake_;

  TaskThread grader_;  // last: its tasks use all of the above
};

}  // namespace emberline
