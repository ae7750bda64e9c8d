// The displayed picture while a driver finishes one bucket after another.
#pragma once

#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "renderer/engine/live_picture.h"
#include "renderer/session/grading.h"

namespace emberline {

// Several threads add buckets, so callers must hold lock() while they call any other function.
class BucketPicture {
 public:
  BucketPicture(const RenderPlan& plan, std::vector<float> before)
      : picture_(plan, std::move(before)), rgba8_(picture_.rgba().size()) {}

  std::unique_lock<std::mutex> lock() { return std::unique_lock(mutex_); }

  void begin(const Rect& pixels) { in_progress_.push_back(pixels); }

  void finish(const FilmTile& bucket, const std::shared_ptr<const Grading>& grading) {
    const Rect pixels = picture_.add(bucket);
    std::erase(in_progress_, pixels);
    if (!grading || grading != grading_) return;
    const size_t row = 4 * size_t(pixels.width());
    for (int y = pixels.y0; y < pixels.y1; ++y) {
      const size_t first = 4 * picture_.rect().index_of(pixels.x0, y);
      grading->grade_run(picture_.rgba().subspan(first, row), {&rgba8_[first], row});
    }
  }

  const std::vector<Rect>& in_progress() const { return in_progress_; }
  const TilePicture& picture() const { return picture_; }
  // Returns the display values. Each bucket is graded when it is finished, and the whole picture
  // only when the grading has changed.
  std::span<const uint8_t> rgba8(const std::shared_ptr<const Grading>& grading) {
    if (grading != grading_) {
      // Uses this thread alone, because a thread that waits for TBB could start another bucket and
      // lock the mutex again.
      grading->grade_run(picture_.rgba(), rgba8_);
      grading_ = grading;
    }
    return rgba8_;
  }

 private:
  std::mutex mutex_;
  TilePicture picture_;
  std::vector<uint8_t> rgba8_;
  std::shared_ptr<const Grading> grading_;  // the grading that made rgba8_
  std::vector<Rect> in_progress_;
};

}  // namespace emberline
