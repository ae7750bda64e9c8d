#include "renderer/app/frame_animation.h"

#include "io/display/display.h"
#include "renderer/core/errors.h"
#include "renderer/core/file_suffix.h"

namespace emberline {

bool is_gif(std::string_view path) { return lower_suffix(path) == ".gif"; }

void FrameAnimation::begin(const Rect& window, const std::string& path,
                           const LoadProgress& progress) {
  if (window_.empty()) window_ = window;
  if (window.width() != window_.width() || window.height() != window_.height()) {
    throw InputError(path,
                     "it has {} x {} pixels, but the other frames of the animation have {} x {}",
                     window.width(), window.height(), window_.width(), window_.height());
  }
  frame_.emplace(window, max_side_);
  // The encoded file is at most as large as the frames, which are encoded at the end.
  const uint64_t frame_bytes = 3 * frame_->size();
  progress.budget()->reserve(MemoryPart::kFilm,
                             frame_->bytes() + 2 * frame_bytes * (frames_.size() + 1),
                             "the animation up to " + path);
}

void FrameAnimation::end(const DisplayTransform& transform) {
  frames_.push_back(frame_->display(transform));
  frame_.reset();
}

std::vector<unsigned char> FrameAnimation::encode(double fps, const std::string& path) const {
  return encode_animation(frames_, 1.0 / fps, path);
}

}  // namespace emberline
