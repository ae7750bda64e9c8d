// Gives a session's newest picture out, as the display settings have it, and says what is wrong.
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

// Thread-safe. Pictures are given out as shared pointers, whose memory comes back when
// the last is let go: a frame of 1280 x 720 takes 18 MB, and 2 ms to be touched for the first time.
class PicturePublisher {
 public:
  PicturePublisher();
  PicturePublisher(const PicturePublisher&) = delete;
  PicturePublisher& operator=(const PicturePublisher&) = delete;

  // Grades from now on by these settings, and the newest picture anew, without a new sample; in the
  // background. With an overlay, the newest picture stays as it is: colours of maps are no light.
  // Settings that cannot be are a problem, and the ones of before stay.
  void set_display(const DisplaySettings& settings);
  // Waits for the first set_display() to be done. Null if nothing was ever possible.
  std::shared_ptr<const Grading> grading();

  // A picture to fill in, with the memory of one that nobody looks at any more.
  std::shared_ptr<ShownPicture> blank();
  // Gives out a picture that was graded by `grading`, gives it its serial number, wakes the owner
  // up.
  void publish(std::shared_ptr<ShownPicture> picture, std::shared_ptr<const Grading> grading);
  std::shared_ptr<const ShownPicture> picture() const;

  // A picture of before, graded as the newest one is; in the background, and anew whenever the
  // display settings change. With an overlay it stays as it is. Null: none.
  void compare_with(std::shared_ptr<const ShownPicture> kept);
  std::shared_ptr<const ShownPicture> compared() const;  // null until it has been graded

  // Of rendering; an empty text takes it back.
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
