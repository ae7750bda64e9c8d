#include "renderer/session/bucket_picture.h"

namespace emberline {

void BucketPicture::finish(const FilmTile& bucket, const std::shared_ptr<const Grading>& grading) {
  const Rect pixels = picture_.add(bucket);
  std::erase(in_progress_, pixels);
  if (!grading || grading != grading_) return;
  const size_t row = 4 * size_t(pixels.width());
  for (int y = pixels.y0; y < pixels.y1; ++y) {
    const size_t first = 4 * picture_.rect().index_of(pixels.x0, y);
    grading->grade_run(picture_.rgba().subspan(first, row), {&rgba8_[first], row});
  }
}

std::span<const uint8_t> BucketPicture::rgba8(const std::shared_ptr<const Grading>& grading) {
  if (grading != grading_) {
    // On this thread alone: it must not begin another bucket while it waits for help.
    grading->grade_run(picture_.rgba(), rgba8_);
    grading_ = grading;
  }
  return rgba8_;
}

}  // namespace emberline
